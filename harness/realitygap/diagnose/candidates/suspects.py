"""Every effect at every target that could act: what a diagnosis suspects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.robot.effects import EFFECTS, Effect, Parameter
from realitygap.robot.effects.friction import presliding
from realitygap.robot.effects.joint import speed_scale
from realitygap.robot.effects.transmission import BACKLASH
from realitygap.robot.plant import Plant, match_joints
from realitygap.robot.suspicion import may_be_suspected


def suspects(problem: Problem) -> list[Suspect]:
    """All suspects, in the order of the effects' table: single targets, then servo types, then all joints.

    Among them those that can act once the rotor inertia is found that the scenario does not state.
    """
    every = [suspect for effect in EFFECTS.values() for suspect in _anywhere(problem, effect)]
    scenario, model = problem.file.scenario, problem.plant.model
    every = [s for s in every if model.joints or s.effect not in CARRIED]
    allowed = [s for s in every if may_be_suspected(scenario, model, s.effect, s.target)]
    rotors = _with_rotors(problem.plant)
    return [s for s in allowed if s.possible(problem.plant) or s.possible(rotors)]


def acting(problem: Problem) -> list[Suspect]:
    """Those of them that can act in the scenario's own model."""
    return [s for s in suspects(problem) if s.possible(problem.plant)]


def _with_rotors(plant: Plant) -> Plant:
    """A plant whose joints all have a rotor."""
    out, effect = plant.copy(), EFFECTS["rotor_inertia"]
    for i in range(len(plant.model.joints)):
        effect.apply(out, [i], effect.first_size(plant, i))
    return out


def _anywhere(problem: Problem, effect: Effect) -> list[Suspect]:
    """An effect at every target of its kind."""
    model = problem.plant.model
    if effect.sits_at in ("ground", "base"):
        return [Suspect(effect.name, effect.sits_at, (0,))]
    if effect.sits_at == "link":
        first = 0 if model.floating else 1
        return [Suspect(effect.name, link.name, (i,)) for i, link in enumerate(model.links) if i >= first]
    names = model.joint_names
    judged = [j for j in range(len(names)) if problem.judged[j]]
    single = [Suspect(effect.name, names[j], (j,)) for j in judged]
    if len(judged) < 2 or effect.name in OWN:
        return single
    groups = [(servo, group) for servo, group in _servo_groups(problem) if 1 < len(group) < len(judged)]
    types = [Suspect(effect.name, tuple(names[j] for j in g), tuple(g), servo) for servo, g in groups]
    return [*single, *types, Suspect(effect.name, "*", tuple(range(len(names))))]


def _servo_groups(problem: Problem) -> list[tuple[str, list[int]]]:
    """The name and the joints of each servo of the scenario: first match wins."""
    taken: set[int] = set()
    out = []
    for servo in problem.file.scenario.servos:
        matched = [j for j in match_joints(problem.plant.model, servo.joints) if j not in taken]
        taken |= set(matched)
        out.append((servo.name or "", matched))
    return out


OWN = ("joint_offset", "torque_ripple", "constant_effort", "joint_stop", "cable_spring", "friction_ripple")
"""Effects whose value is each joint's own: all joints of a type do not share it."""
ALWAYS_FREE = {
    "torque_ripple": ("amplitude", "periods", "phase"),
    "friction_ripple": ("share", "periods", "phase"),
    "stribeck_friction": ("static", "coulomb", "velocity"),
    "payload": ("mass", "x", "y", "z"),
}
"""Effects that say nothing without fitting their shape too."""
LATER = {
    "coulomb_friction": ("torque", "onset"),
    "stribeck_friction": ("static", "coulomb", "velocity", "exponent"),
    "load_dependent_friction": ("coefficient", "static_coefficient", "velocity"),
    "command_profile": ("speed", "acceleration"),
    "effort_limit": ("effort", "beyond", "share"),
    "cable_spring": ("stiffness", "rest"),
    "direction_friction": ("forward", "backward", "asymmetry"),
}
"""What is freed when an effect was found, if that helps."""
BUILDS_UP = {
    "coulomb_friction": ("torque", "presliding"),
    "direction_friction": ("forward", "backward", "presliding"),
}
"""What is freed in the place of something that gives way at the joints of a friction, as a spring. Not as any other
shape: asked for beside all else it gained 156 on a UR10e, whose held-out gap rose from 2.1 to 3.0 floors, and the
held-out score of an SO-101 went from 0.107 to 0.111."""

CARRIED = ("payload",)
"""What a link carries. A body without joints is thrown with whatever is fixed to it: its mass, its centre and its
inertia are suspects of their own. Of a cube whose centre of mass is 5.3 mm off, as its free flight tells
(`tests/bench_cube_flight.py`), a load of 7 g outside of it was made."""

EVERYDAY = {
    True: ("coulomb_friction", "viscous_friction", "controller_gain", "joint_offset"),
    False: ("coulomb_friction", "viscous_friction", "rotor_inertia", "constant_effort"),
}
"""What a plain fit has free at every joint, of a robot with servos and without: many small ones together explain what
none of them does alone. These are the free parameters of the usual recipes for servos (Rhoban's BAM) and for
industrial arms (Gautier 1997; Swevers 1997)."""
SHARED = ("command_delay",)
"""The same for all joints: a bus has one latency."""
FEW = 8
"""With more joints than this, a plain fit has one value for every type of servo, but of what is each joint's own: what
one joint does moves all of a humanoid, so that values of many single joints are told from each other late, and badly.
"""


def everyday(problem: Problem, suspect: Suspect) -> bool:
    """Whether a plain fit of this robot would have a suspect free."""
    if suspect.effect in SHARED:
        return suspect.target == "*"
    if suspect.effect not in EVERYDAY[bool(problem.file.scenario.servos)]:
        return False
    by_type = suspect.effect not in OWN and many_joints(problem)
    return len(suspect.indices) > 1 if by_type else len(suspect.indices) == 1


def plain_first(problem: Problem, everyone: Sequence[Suspect]) -> list[Suspect]:
    """What a search looks at first: with many joints only what a plain fit has free. All else is seen beside that, and
    seen falsely without it: what one joint lacks moves all of a humanoid.
    """
    return [s for s in everyone if everyday(problem, s)] if many_joints(problem) else list(everyone)


def many_joints(problem: Problem) -> bool:
    """Whether a robot has so many joints that a plain fit has one value for every type of servo."""
    return int(problem.judged.sum()) > FEW


def fitted(effect: Effect) -> list[Parameter]:
    """The parameters that are fitted: those that act on their own."""
    free = ALWAYS_FREE.get(effect.name)
    if effect.name in LATER and free is None:
        return [p for p in effect.parameters if not p.shape and (p.default is None or np.isinf(p.default))]
    return [p for p in effect.parameters if (p.name in free if free else not p.shape)]


def richer(plant: Plant, change: Change) -> Change | None:
    """A change with its shape freed too; None where there is none to free.

    Friction under load starts with half of itself at slow speed only: without a static part its speed means nothing.
    """
    free = LATER.get(change.suspect.effect)
    if free is None:
        return None
    values, suspect = change.parameters, change.suspect
    if values.get("onset") == 0.0:
        values["onset"] = _slow(plant, suspect)
    if values.get("static_coefficient") == 0.0:
        half = 0.5 * values["coefficient"]
        values |= {"coefficient": half, "static_coefficient": half, "velocity": _slow(plant, suspect)}
    first = suspect.kind.first_size(plant, suspect.indices[0])
    values |= {n: first[n] for n in free if n not in change.free and not np.isfinite(values[n])}
    if values.get("share") == 1.0:
        values["share"] = first["share"]
    return replace(change, values=tuple(values.items()), free=free)


def gives_way(suspect: Suspect) -> bool:
    """Whether it is a play, or a spring, between a motor and its link."""
    return BACKLASH.name in {suspect.effect, *suspect.kind.excludes}


def building_up(plant: Plant, change: Change) -> Change | None:
    """Friction that builds up over an angle, what joints ordinarily give; None of what is no such friction."""
    free, suspect = BUILDS_UP.get(change.suspect.effect), change.suspect
    if free is None or not change.free:
        return None
    zero, over = neutral(plant, suspect), min(presliding(plant, i) for i in suspect.indices)
    bare = {n: zero[n] for n in change.free if n not in free}
    return replace(change.at({**bare, "presliding": change.parameters["presliding"] or over}), free=free)


def in_shape_of(change: Change, other: Change) -> Change:
    """A change with the shape of another one that it says otherwise, where it may have that too: friction by side that
    builds up over an angle, as the dry friction does in whose place it is tried.
    """
    shape = {n for n in other.free if other.suspect.kind.parameter(n).shape}
    for shapes in (LATER, BUILDS_UP):
        free = shapes.get(change.suspect.effect, ())
        if shape and shape.issubset(free) and change.suspect.kind.rules_out(other.suspect.kind):
            return replace(change.at({n: other.parameters[n] for n in shape}), free=free)
    return change


def begun_again(plant: Plant, change: Change) -> Change:
    """A change with the speed at which its friction falls as it is first tried, or as it is where it has none.

    That may be of any size, and from where it shows nothing, as at creeping, no slope leads back. Beside a viscous
    friction that was not found yet, one of 0.47 rad/s was fitted as 0.001 rad/s, and both are found from here.
    """
    suspect = change.suspect
    speeds = {p.name for p in suspect.kind.parameters if p.shape and p.logarithmic}.intersection(change.free)
    return change.at(dict.fromkeys(speeds, _slow(plant, suspect))) if speeds else change


def _slow(plant: Plant, suspect: Suspect) -> float:
    """A speed that is slow for all joints of a suspect [rad/s or m/s]."""
    return 0.1 * min(speed_scale(plant, i) for i in suspect.indices)


def neutral(plant: Plant, suspect: Suspect) -> dict[str, float]:
    """The values that change nothing: the plant's own, also of an effect that the scenario has already."""
    effect = suspect.kind
    own = effect.own(plant, suspect.indices[0])
    out = {}
    for p in effect.parameters:
        value = own.get(p.name, p.absent)
        if value is None:
            value = p.default if p.default is not None else p.first
        out[p.name] = value
    return out


def sizes(plant: Plant, suspect: Suspect) -> dict[str, float]:
    """A sensible first change of each parameter at this target, above zero."""
    effect = suspect.kind
    first = effect.first_size(plant, suspect.indices[0])
    zero = neutral(plant, suspect)
    common = max(
        (abs(first[p.name] - zero[p.name]) for p in effect.parameters if np.isfinite(zero[p.name])), default=0.0
    )
    out = {}
    for p in effect.parameters:
        change = abs(first[p.name] - zero[p.name])
        if not np.isfinite(change) or change == 0.0:
            change = 0.3 * abs(first[p.name]) or p.typical or common or 0.01
        out[p.name] = change
    return out


def whole(effect: Effect) -> bool:
    """Whether an effect is absent at zero but cannot be small: its parameters only mean something together."""
    return any(p.logarithmic and p.absent == 0.0 for p in effect.parameters) or effect.name == "soft_ground"


def bounds(plant: Plant, suspect: Suspect) -> dict[str, tuple[float, float]]:
    """The least and the largest value of each parameter: its own bounds, and what can be at the target."""
    kind = suspect.kind
    there = [kind.largest(plant, i) for i in suspect.indices] if kind.largest else []
    return {
        p.name: (p.low, min([p.high, *(most[p.name] for most in there if p.name in most)])) for p in kind.parameters
    }
