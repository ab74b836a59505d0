"""What the sensors report."""

import math

from realitygap.robot.drive import DIRECTION_KNOWN
from realitygap.robot.effects.effect import Effect, Page, Parameter, Values, reads, writes
from realitygap.robot.effects.joint import anywhere, effort_scale
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


def _visible_hysteresis(plant: Plant, index: int) -> dict[str, float]:
    onset = float(plant.drive["hysteresis_onset"][index])
    return {"effort": 0.03 * effort_scale(plant, index), "onset": onset}


EFFORT_HYSTERESIS = Effect(
    name="effort_hysteresis",
    changes="observation",
    sits_at="joint",
    parameters=(
        Parameter("effort", "N·m", -200.0, 200.0, 0.1, absent=0.0),
        Parameter("onset", "rad/s", 1e-3, 5.0, DIRECTION_KNOWN, default=DIRECTION_KNOWN, logarithmic=True, shape=True),
    ),
    signals=("effort",),
    own=reads(effort="hysteresis", onset="hysteresis_onset"),
    apply=writes(effort="hysteresis", onset="hysteresis_onset"),
    possible=anywhere,
    scaled=_visible_hysteresis,
    unseen_when_followed="friction of the joint says the same of the effort, with the other sign",
    page=Page(
        physics="What is told of the effort is less in the direction of motion, by the same amount at every load: a "
        "current sensor whose offset turns with the bridge that drives the motor, or a drive that takes a friction off "
        "before it tells its torque. This is the sensor, not the robot: nothing moves differently.",
        equation="reading = τ − effort·tanh(ω/onset)",
        signature="Position and velocity are right, and so is what the effort says of the load; between both ways "
        "along the same path it differs by less than friction takes, or the other way round.",
        confused_with="coulomb_friction (holds the joint, too), torque_constant (a share of the effort), current_lag.",
        source="Measured on a Dynamixel MX-106: what its current lacks against its duty and its speed is the same on a "
        "horizontal bench whose duty was told; Dynamixel e-manual, present current.",
    ),
)
