"""The ground that the robot stands on."""

import math
from dataclasses import replace

from realitygap_engines import GRAVITY, Ground

from realitygap.robot.effects.effect import Effect, Page, Parameter, Values
from realitygap.robot.plant import Plant


def _touches(plant: Plant, _index: int) -> str | None:
    if plant.ground is None:
        return "there is no ground; expected `ground: flat`, grass or numbers"
    if not any(link.spheres for link in plant.model.links):
        return "no link of the robot can touch the ground; expected <collision> shapes"
    return None


def _ground(plant: Plant) -> Ground:
    assert plant.ground is not None, "the effect was not possible here"
    return plant.ground


def _own_friction(plant: Plant, _index: int) -> dict[str, float]:
    return {"coefficient": _ground(plant).friction}


def _friction(plant: Plant, _indices: list[int], values: Values) -> None:
    plant.ground = replace(_ground(plant), friction=values["coefficient"])


def _slippery(plant: Plant, _index: int) -> dict[str, float]:
    return {"coefficient": 0.6 * _ground(plant).friction or 0.3}


GROUND_FRICTION = Effect(
    name="ground_friction",
    changes="model",
    sits_at="ground",
    law="contact",
    parameters=(Parameter("coefficient", "", 0.0, 5.0, 0.5),),
    signals=("base_position", "position"),
    own=_own_friction,
    apply=_friction,
    possible=_touches,
    scaled=_slippery,
    page=Page(
        physics="Dry friction between robot and ground, as one coefficient of the pair of materials.",
        equation="|F_tangential| ≤ coefficient·F_normal; sliding: F = −coefficient·F_normal·v/|v|",
        signature="Feet slide or twist in fast moves; a thrown body stops earlier or later. Nothing while all feet "
        "stick.",
        confused_with="soft_ground (gives way without sliding), link_mass of the feet.",
        source="Acosta, Yang, Posa: Validating robotics simulators on real-world impacts, IEEE RA-L 7(3), 2022.",
    ),
    dissipative=True,
    unseen_when_followed="no contact is part of the motion",
)


def _own_softness(plant: Plant, _index: int) -> dict[str, float]:
    ground = _ground(plant)
    return {
        "stiffness": math.inf if ground.stiffness is None else ground.stiffness,
        "damping": ground.damping or 0.0,
    }


def _softness(plant: Plant, _indices: list[int], values: Values) -> None:
    rigid = not math.isfinite(values["stiffness"])
    stiffness, damping = (None, None) if rigid else (values["stiffness"], values["damping"])
    if rigid and _ground(plant).stiffness is None:
        return
    plant.ground = replace(_ground(plant), stiffness=stiffness, damping=damping)


def _sinks(plant: Plant, _index: int) -> dict[str, float]:
    """Half the stiffness of a soft ground; on a rigid one four points sink by 5 mm under the weight, well damped."""
    own = _ground(plant).stiffness
    stiffness = 0.5 * own if own is not None else plant.model.mass * GRAVITY / 4 / 0.005
    damping = _ground(plant).damping or math.sqrt(stiffness * plant.model.mass / 4)
    return {"stiffness": stiffness, "damping": damping}


SOFT_GROUND = Effect(
    name="soft_ground",
    changes="model",
    sits_at="ground",
    law="contact",
    parameters=(
        Parameter("stiffness", "N/m", 10.0, 1e8, 3000.0, logarithmic=True),
        Parameter("damping", "N·s/m", 0.0, 1e6, 100.0),
    ),
    signals=("base_position", "base_orientation", "position"),
    own=_own_softness,
    apply=_softness,
    possible=_touches,
    scaled=_sinks,
    page=Page(
        physics="Grass, foam and rubber soles give way: a spring and a damper at every contact point, which push only.",
        equation="F_normal = max(0, stiffness·depth + damping·d(depth)/dt) per contact point",
        signature="The robot sinks and rocks after impacts; ankles see less abrupt loads; the base sways in slow "
        "moves.",
        confused_with="joint_compliance and controller_gain of the ankles, ground_friction.",
        source="Gilardi, Sharf: Literature survey of contact dynamics modelling, Mech. Mach. Theory 37, 2002; the "
        "artificial grass of RoboCup fields.",
    ),
    unseen_when_followed="no contact is part of the motion",
)
