"""What pulls a link beside its drive: a cable or a spring, and stops."""

import math

from realitygap.robot.effects.effect import Effect, Page, Parameter, Values, reads, writes
from realitygap.robot.effects.joint import anywhere, effort_scale
from realitygap.robot.plant import Plant


def _firm_stop(plant: Plant, index: int) -> dict[str, float]:
    return {"stiffness": 5.0 * effort_scale(plant, index)}


def _crossed(values: Values) -> str | None:
    if values["lower"] < values["upper"]:
        return None
    return f"lower: found {values['lower']:g}, with an upper of {values['upper']:g}; expected lower below upper"


JOINT_STOP = Effect(
    name="joint_stop",
    changes="torque",
    sits_at="joint",
    parameters=(
        Parameter("lower", "rad", -100.0, 100.0, -0.6, absent=-math.inf, default=-math.inf),
        Parameter("upper", "rad", -100.0, 100.0, 0.6, absent=math.inf, default=math.inf),
        Parameter("stiffness", "N·m/rad", 0.1, 1e8, 100.0, absent=0.0, logarithmic=True),
    ),
    signals=("position", "effort"),
    own=reads(lower="stop_lower", upper="stop_upper", stiffness="stop_stiffness"),
    apply=writes(lower="stop_lower", upper="stop_upper", stiffness="stop_stiffness"),
    turned=lambda values, angle: {name: values[name] + angle for name in ("lower", "upper")},
    possible=anywhere,
    scaled=_firm_stop,
    page=Page(
        physics="A part that the joint runs against before it reaches the limits of the model: a bracket, a cable, a "
        "printed stop. It is a spring on the link from an angle on, without damping; an end that is left out is not "
        "there. A limit of the URDF is rigid instead, and is that of the engine.",
        equation="τ = −stiffness·(q − upper) for q > upper, −stiffness·(q − lower) for q < lower",
        signature="The position comes to an end at one angle whatever the command, and rebounds there; the effort "
        "grows until the servo's limit.",
        confused_with="effort_limit and torque_speed_limit (end at an effort or a speed, not at an angle), "
        "cable_spring (pulls from the beginning), dead_band.",
        source="Goldsmith: Impact, 1960; Hunt, Crossley: Coefficient of restitution interpreted as damping in "
        "vibroimpact, J. Appl. Mech. 42, 1975 (of which this is the part without loss).",
    ),
    contradiction=_crossed,
)


def _soft_cable(plant: Plant, index: int) -> dict[str, float]:
    return {"stiffness": 0.05 * effort_scale(plant, index)}


CABLE_SPRING = Effect(
    name="cable_spring",
    changes="torque",
    sits_at="joint",
    law="load",
    parameters=(
        Parameter("stiffness", "N·m/rad", 0.0, 1e5, 0.2, absent=0.0),
        Parameter("rest", "rad", -100.0, 100.0, 0.0, absent=0.0, default=0.0, shape=True, typical=0.3),
    ),
    signals=("position", "effort"),
    own=reads(stiffness="cable_stiffness", rest="cable_rest"),
    apply=writes(stiffness="cable_stiffness", rest="cable_rest"),
    turned=lambda values, angle: {"rest": values["rest"] + angle},
    possible=anywhere,
    scaled=_soft_cable,
    page=Page(
        physics="Cables and hoses that bend with a joint, and springs that are mounted to carry its load, pull it to "
        "an angle. The spring acts on the link, beside its gears.",
        equation="τ = −stiffness·(q − rest)",
        signature="An effort that changes in proportion to the angle, the same in both directions of motion and at "
        "rest; a joint that is let go returns to one angle.",
        confused_with="constant_effort (the same at every angle), controller_gain (about the command, not about one "
        "angle), center_of_mass and base_tilt (a sine of the angle), joint_offset.",
        source="Agrawal, Fattah: Gravity-balancing of spatial robotic manipulators, Mechanism and Machine Theory "
        "39(12), 2004.",
    ),
)
