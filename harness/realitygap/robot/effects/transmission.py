"""What lies between motor and link: the rotor's inertia, play and elasticity. The encoder is on the output shaft."""

import math

from realitygap.robot.effects.effect import Effect, Page, Parameter, Values, reads, writes
from realitygap.robot.effects.joint import anywhere, effort_scale, has_rotor, speed_scale
from realitygap.robot.plant import Plant

DAMPING = Parameter("damping", "N·m·s/rad", 0.0, 1e4, 0.0, absent=0.0, default=0.0, shape=True)
"""Between rotor and link: it does nothing where they are one."""

BACKLASH = Effect(
    name="backlash",
    changes="torque",
    sits_at="joint",
    parameters=(Parameter("angle", "rad", 0.0, 0.5, 0.01, absent=0.0), DAMPING),
    signals=("position", "velocity"),
    own=reads(angle="backlash", damping="give_damping"),
    apply=writes(angle="backlash", damping="give_damping"),
    possible=has_rotor,
    page=Page(
        physics="Play between gear teeth: the rotor, with its inertia and the friction of the gears, moves freely "
        "over the dead zone before it pushes the output again, and lands there with an impact without rebound. The "
        "encoder is on the output, so the servo does not see its own rotor cross the gap; the back-EMF is that "
        "of the rotor. Grease in the gap drags the output along with the rotor (`damping`).",
        equation="τ on the output only where |q_rotor − q| = angle/2, between damping·(ω_rotor − ω); "
        "armature·dω_rotor/dt = τ_m − friction − τ",
        signature="A flat spot of the position after every reversal of the load, without an offset of the effort, "
        "then a jump in velocity; rattling about the goal where nothing loads the joint.",
        confused_with="coulomb_friction (a flat spot that the effort has to overcome), command_delay (a lag that is "
        "there without reversals too), joint_compliance (a smooth transition instead of a jump).",
        source="Nordin, Gutman: Controlling mechanical systems with backlash, a survey, Automatica 38(10), 2002.",
    ),
    excludes=("joint_compliance",),
    dissipative=True,
    unseen_when_followed="the rotor's way across the gap was not measured",
)


def _own_compliance(plant: Plant, index: int) -> dict[str, float]:
    d = plant.drive[index]
    return {"stiffness": float(d["stiffness"]) or math.inf, "damping": float(d["give_damping"])}


def _compliance(plant: Plant, indices: list[int], values: Values) -> None:
    stiffness = values["stiffness"]
    plant.drive["stiffness"][indices] = stiffness if math.isfinite(stiffness) else 0.0
    if "damping" in values:
        plant.drive["give_damping"][indices] = values["damping"]


def _soft_spring(plant: Plant, index: int) -> dict[str, float]:
    return {"stiffness": effort_scale(plant, index) / 0.05}


JOINT_COMPLIANCE = Effect(
    name="joint_compliance",
    changes="torque",
    sits_at="joint",
    parameters=(Parameter("stiffness", "N·m/rad", 0.1, 1e8, 100.0, absent=math.inf, logarithmic=True), DAMPING),
    signals=("position", "velocity"),
    own=_own_compliance,
    apply=_compliance,
    possible=has_rotor,
    scaled=_soft_spring,
    page=Page(
        physics="Gears, belts, brackets and printed parts bend: a spring between the output shaft, which carries the "
        "encoder, the rotor's inertia and the friction of the gears, and the link. The encoder does not see the "
        "link's deflection. Metal loses little in a swing, plastic more (`damping`).",
        equation="τ = stiffness·(q_encoder − q_link) + damping·(ω_encoder − ω_link); resonance "
        "√(stiffness·(1/I_rotor + 1/I_link))",
        signature="A ripple at one frequency after fast moves and impacts; the link sags under load while the "
        "encoder reads the goal.",
        confused_with="controller_gain (a softer servo shows its sag to the encoder), backlash (a jump instead of a "
        "ripple), soft_ground (where the robot stands).",
        source="M. W. Spong: Modeling and control of elastic joint robots, J. Dyn. Sys., Meas., Control 109, 1987.",
    ),
    excludes=("backlash",),
    unseen_when_followed="how far the link is behind the encoder was not measured",
)


QUICK = 0.01
"""A rotor that was not stated takes a tenth of what its joint is rated for to reach its speed in 0.1 s [s].
What its link weighs says little of it: a gear of 100 : 1 makes a hand's rotor heavier than the hand."""


def _more_rotor(plant: Plant, index: int) -> dict[str, float]:
    usual = QUICK * effort_scale(plant, index) / speed_scale(plant, index)
    return {"armature": 1.3 * float(plant.drive["armature"][index]) or usual}


ROTOR_INERTIA = Effect(
    name="rotor_inertia",
    changes="model",
    sits_at="joint",
    law="load",
    parameters=(Parameter("armature", "kg·m²", 0.0, 1000.0, 0.01),),
    signals=("position", "velocity"),
    own=reads(armature="armature"),
    apply=writes(armature="armature"),
    possible=anywhere,
    scaled=_more_rotor,
    page=Page(
        physics="The motor's rotor and gears turn with the joint; seen from the output their inertia is multiplied "
        "by the square of the gear ratio, and is often larger than the link's.",
        equation="(I_link + armature)·dω/dt = τ; armature = I_motor·ratio²",
        signature="Slower acceleration and more overshoot, whatever the pose; nothing at rest or at constant speed.",
        confused_with="link_inertia and link_mass (the same on a single joint; they depend on the pose and reach the "
        "other joints), command_delay (shifts slow motions too), torque_constant.",
        source="Featherstone: Rigid Body Dynamics Algorithms, 2008, section 9.6; Flemming 2019, chapter 4.",
    ),
)
