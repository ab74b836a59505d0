"""What the sensors report."""

import math

from realitygap.robot.effects.effect import Effect, Page, Parameter, Values, reads, writes
from realitygap.robot.effects.joint import anywhere
from realitygap.robot.plant import Plant

JOINT_OFFSET = Effect(
    name="joint_offset",
    changes="observation",
    sits_at="joint",
    parameters=(Parameter("angle", "rad", -math.pi, math.pi, 0.02, absent=0.0),),
    signals=("position",),
    own=reads(angle="offset"),
    apply=writes(angle="offset"),
    possible=anywhere,
    page=Page(
        physics="The encoder's zero is not where the model's is: a horn mounted one tooth further, a calibration by "
        "hand. The servo regulates the reading, so the true joint is off by the angle.",
        equation="q = reading + angle",
        signature="The reading follows the command as before, but the load belongs to another pose: effort, sag and "
        "the robot's balance are shifted.",
        confused_with="base_tilt (the same for a single joint), center_of_mass, constant_effort (no change of the "
        "load with the pose).",
        source="Dynamixel e-manual, homing offset; Flemming 2019, chapter 4.",
    ),
)


def _own_filter(plant: Plant, index: int) -> dict[str, float]:
    return {"time": float(plant.velocity_lag[index]), "scale": float(plant.velocity_scale[index])}


def _filter(plant: Plant, indices: list[int], values: Values) -> None:
    plant.velocity_lag[indices] = values["time"]
    plant.velocity_scale[indices] = values["scale"]


VELOCITY_FILTER = Effect(
    name="velocity_filter",
    changes="observation",
    sits_at="joint",
    parameters=(
        Parameter("time", "s", 0.0, 1.0, 0.02, absent=0.0, default=0.0),
        Parameter("scale", "", 0.1, 10.0, 1.0, absent=1.0, default=1.0),
    ),
    signals=("velocity",),
    own=_own_filter,
    apply=_filter,
    possible=anywhere,
    page=Page(
        physics="Servos compute velocity from few encoder counts and smooth it; the unit conversion may be off. This "
        "is the sensor, not the robot: nothing moves differently.",
        equation="time·dv/dt + v = scale·ω",
        signature="The reported velocity is late, smooth and too small (or too large), while the position is right.",
        confused_with="viscous_friction and command_delay, by whoever looks at the velocity alone: compare it with "
        "the derivative of the position.",
        source="Brown, Schneider, Mulligan: Velocity estimation from discrete position, IEEE Trans. Ind. Electron. "
        "39(1), 1992; Dynamixel e-manual, present velocity.",
    ),
)
