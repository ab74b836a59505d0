"""Friction that depends on the direction of motion or on the angle."""

import math

from realitygap.robot.effects.effect import Effect, Page, Parameter, Values, reads, writes
from realitygap.robot.effects.friction import FRICTION_HIGH, PRESLIDING_STEP
from realitygap.robot.effects.joint import anywhere, effort_scale, seen_periods, wave_turned, wave_unseen
from realitygap.robot.plant import Plant


def _own_directions(plant: Plant, index: int) -> dict[str, float]:
    mean, lean = float(plant.drive["coulomb"][index]), float(plant.drive["lean"][index])
    asymmetry = float(plant.drive["viscous_asymmetry"][index])
    presliding = float(plant.drive["presliding"][index])
    return {"forward": mean - lean, "backward": mean + lean, "asymmetry": asymmetry, "presliding": presliding}


def _directions(plant: Plant, indices: list[int], values: Values) -> None:
    """A bound from −forward to backward is the mean bound beside a constant half of their difference."""
    mean = 0.5 * (values["forward"] + values["backward"])
    plant.drive["coulomb"][indices] = plant.drive["static"][indices] = mean
    plant.drive["lean"][indices] = 0.5 * (values["backward"] - values["forward"])
    plant.drive["viscous_asymmetry"][indices] = values["asymmetry"]
    if "presliding" in values:
        plant.drive["presliding"][indices] = values["presliding"]


def _more_each_way(plant: Plant, index: int) -> dict[str, float]:
    own, more = _own_directions(plant, index), 0.02 * effort_scale(plant, index)
    return {"forward": own["forward"] + more, "backward": own["backward"] + 2.0 * more}


DIRECTION_FRICTION = Effect(
    name="direction_friction",
    changes="torque",
    sits_at="joint",
    law="friction",
    parameters=(
        Parameter("forward", "N·m", 0.0, FRICTION_HIGH, 0.1),
        Parameter("backward", "N·m", 0.0, FRICTION_HIGH, 0.2),
        Parameter("asymmetry", "", -1.0, 1.0, 0.1, absent=0.0, default=0.0, shape=True, typical=0.1),
        Parameter("presliding", "rad", 0.0, 0.1, 0.0, absent=0.0, default=0.0, shape=True, typical=PRESLIDING_STEP),
    ),
    signals=("position", "velocity"),
    own=_own_directions,
    apply=_directions,
    possible=anywhere,
    scaled=_more_each_way,
    page=Page(
        physics="Friction that is larger one way than the other: gear flanks, screws and seals are not the same on "
        "both sides. Forward is where the angle grows. Dry, it stands in place of Coulomb friction, and holds a joint "
        "at rest against up to as much in either direction; the joint's viscous friction is larger forward by the "
        "share asymmetry, and smaller backward. Before it slides it builds up over an angle, presliding, as Coulomb "
        "friction may.",
        equation="sliding: τ = −forward − viscous·(1 + asymmetry)·ω for ω > 0, +backward − viscous·(1 − asymmetry)·ω "
        "for ω < 0; stuck: −forward ≤ τ ≤ backward",
        signature="A hysteresis between effort and position whose middle is not where gravity puts it; one direction "
        "lags and stops short more than the other.",
        confused_with="coulomb_friction with a constant_effort (the same law in other numbers: the effort is half of "
        "the difference), cable_spring (changes with the angle), joint_offset.",
        source="Janot, Gautier, Brunot: Data set and reference models of EMPS, 2019 (asymmetric friction); "
        "Armstrong-Hélouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994.",
    ),
    excludes=("coulomb_friction", "stribeck_friction"),
    dissipative=True,
)


def _seen_ripple(plant: Plant, index: int) -> dict[str, float]:
    return {"periods": seen_periods(plant, index, 3.0)}


FRICTION_RIPPLE = Effect(
    name="friction_ripple",
    changes="torque",
    sits_at="joint",
    law="friction",
    parameters=(
        Parameter("share", "", 0.0, 1.0, 0.5, absent=0.0),
        Parameter("periods", "per 2π", 0.5, 2000.0, 3.0, shape=True),
        Parameter("phase", "rad", -2 * math.pi, 2 * math.pi, 0.0, default=0.0, shape=True, typical=1.0),
    ),
    signals=("position", "velocity"),
    own=reads(share="friction_ripple", periods="friction_periods", phase="friction_phase"),
    apply=writes(share="friction_ripple", periods="friction_periods", phase="friction_phase"),
    turned=wave_turned,
    absurd=wave_unseen,
    scaled=_seen_ripple,
    possible=anywhere,
    page=Page(
        physics="Dry friction that changes with the angle, because a shaft is bent, a gear runs out of true or teeth "
        "are worn: the whole bound of dry friction, also of what grows with the load, is multiplied. It is the "
        "rotor's angle as seen at the joint, where backlash or a spring lies behind it. Where there is no dry "
        "friction it does nothing.",
        equation="the bound of dry friction is multiplied by 1 + share·sin(periods·q + phase), "
        "q in rad, of a slide in m",
        signature="A hysteresis between effort and position whose width changes with the angle, the same in both "
        "directions; the joint sticks at some angles and not at others.",
        confused_with="torque_ripple (pushes one way at an angle, whatever the direction), load_dependent_friction "
        "(where the load changes with the angle), coulomb_friction (its mean).",
        source="Armstrong-Hélouvry: Control of Machines with Friction, 1991 (friction of a PUMA that depends on the "
        "position); Popović, Goldenberg, IEEE Trans. Robotics and Automation 14(1), 1998.",
    ),
    dissipative=True,
    everywhere=True,
)
