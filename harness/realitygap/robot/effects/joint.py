"""What a joint offers to an effect: whether it can act there, and the scales of effort and speed for first sizes."""

import math

from realitygap_engines import GRAVITY

from realitygap.robot.drive import CASCADE, DC, EFFORT, NONE, PID, POSITION, SPEED
from realitygap.robot.effects.effect import Values
from realitygap.robot.plant import Plant

SLOWEST = 1e-3
"""A joint that went slower than this share of its limit stood still, and its speed is the encoder's noise."""
SUPPLY = 12.0
"""Where the supply was recorded, and is not known beforehand [V]."""


def wave_turned(values: Values, angle: float) -> dict[str, float]:
    """A wave over a joint's angle that is the same over its readings where its zero is that much further."""
    return {"phase": math.remainder(values["phase"] - values["periods"] * angle, 2.0 * math.pi)}


def one_period(plant: Plant, index: int) -> float:
    """The periods per 2π of which a joint saw one in the motion that went furthest; 0 where none was recorded."""
    travelled = 0.0 if plant.travelled is None else float(plant.travelled[index])
    return 2.0 * math.pi / travelled if travelled > 0.0 else 0.0


def seen_periods(plant: Plant, index: int, periods: float) -> float:
    """So many periods per 2π, or twice as many as a joint saw one of, whichever is more: a first size of a wave."""
    return max(periods, 2.0 * one_period(plant, index))


def wave_unseen(plant: Plant, index: int, values: Values) -> str | None:
    """For waves over a joint's angle: one that never came back in any motion may be any slow change with the angle.

    As in a periodogram, which tells nothing below one period of what was observed (Lomb 1976).
    """
    least = one_period(plant, index)
    if values["periods"] < least:
        return f"{values['periods']:.3g} periods per 2π, of which no motion saw one; expected {least:.3g} or more"
    return None


def anywhere(_plant: Plant, _index: int) -> str | None:
    """For effects that can act at every target."""
    return None


def has_servo(plant: Plant, index: int) -> str | None:
    """For effects on a servo."""
    if plant.drive["kind"][index] == NONE:
        return f"joint {plant.model.joint_names[index]} has no servo; expected a joint that `servos` covers"
    return None


def follows_position(plant: Plant, index: int) -> str | None:
    """For effects on what a servo does about a position error."""
    d = plant.drive[index]
    if d["kind"] not in (DC, PID, CASCADE) or d["meaning"] != POSITION:
        return (
            f"joint {plant.model.joint_names[index]} follows no position; expected a servo of kind dc, pid or cascade "
            "and position commands"
        )
    return None


def has_dc_motor(plant: Plant, index: int) -> str | None:
    """For effects on a motor that is modelled by its voltage."""
    if plant.drive["kind"][index] != DC:
        return (
            f"joint {plant.model.joint_names[index]} has no servo of kind dc; expected one, with supply and resistance"
        )
    return None


def has_pid(plant: Plant, index: int) -> str | None:
    """For effects on what a pid servo does beside answering an error."""
    if plant.drive["kind"][index] != PID:
        return f"joint {plant.model.joint_names[index]} has no servo of kind pid; expected one, with kp and kd"
    return None


def answers_rate(plant: Plant, index: int) -> str | None:
    """For effects on how a servo knows its speed."""
    d = plant.drive[index]
    answers = d["kind"] in (CASCADE, SPEED) or (d["kind"] == PID and d["kd"] > 0.0)
    if not answers or d["meaning"] == EFFORT:
        return (
            f"joint {plant.model.joint_names[index]} has no servo that answers its speed; expected one of kind pid "
            "with a kd, cascade or velocity"
        )
    return None


def has_torque_constant(plant: Plant, index: int) -> str | None:
    """For effects on a motor's torque per current: it drives by its voltage, or its effort was told from a current."""
    if plant.drive["current_factor"][index] > 0:
        return None
    reason = has_dc_motor(plant, index)
    return reason and f"{reason}, or a motion that is followed and whose effort has a `factor`"


def has_rotor(plant: Plant, index: int) -> str | None:
    """For effects that part the rotor from the link."""
    if not plant.drive["armature"][index] > 0:
        name = plant.model.joint_names[index]
        return f"joint {name} has no rotor inertia; expected `armature` of its servo, or rotor_inertia, above zero"
    return None


AMPLE = 10.0
"""How many times what a motor gave it is rated for at most: URDFs state 1000 N·m of a joint that nobody asked about,
and a ripple of a fiftieth of that says nothing of one of 0.13 N·m at a pendulum."""


def effort_scale(plant: Plant, index: int) -> float:
    """The effort that the joint is rated for [N·m or N], as far as what it gave bears that out; where none is stated,
    what holds its link against gravity.
    """
    d = plant.drive[index]
    if d["kind"] == DC:
        supply = SUPPLY if d["recorded_supply"] else float(d["supply"])
        return float(d["torque_constant"] / d["resistance"] * d["duty_limit"]) * supply
    if math.isfinite(d["effort_limit"]):
        given = 0.0 if plant.exerted is None else float(plant.exerted[index])
        return min(float(d["effort_limit"]), AMPLE * given) if given > 0.0 else float(d["effort_limit"])
    joint, link = plant.model.joints[index], plant.model.links[index + 1]
    arm = 1.0 if joint.prismatic else max(float((link.com @ link.com) ** 0.5), 0.05)
    return 3.0 * GRAVITY * link.mass * arm


def speed_scale(plant: Plant, index: int) -> float:
    """How fast the joint went in the recordings, or else the speed that it can reach [rad/s or m/s]; 5 where nothing
    limits it.
    """
    d = plant.drive[index]
    limit = float(d["velocity_limit"]) if math.isfinite(d["velocity_limit"]) else 5.0
    if d["kind"] == DC:
        supply = SUPPLY if d["recorded_supply"] else float(d["supply"])
        limit = float(d["duty_limit"] / d["torque_constant"]) * supply
    if plant.reached is None:
        return limit
    return min(max(float(plant.reached[index]), SLOWEST * limit), limit)
