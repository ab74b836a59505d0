"""What a scenario holds for certain, and what it lets a diagnosis suspect."""

from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase

from realitygap_engines.model.robot import Model

from realitygap.files.errors import InputError, meant_first
from realitygap.robot.effects import EFFECTS
from realitygap.robot.plant import match_joints
from realitygap.scenario.file import ScenarioFile
from realitygap.scenario.schema import Scenario

DRY = ("coulomb_friction", "stribeck_friction", "load_dependent_friction", "direction_friction", "friction_ripple")
SERVO: dict[str, tuple[str, ...]] = {
    "gain": ("controller_gain", "gain_law"),
    "kp": ("controller_gain", "gain_law"),
    "kd": ("derivative_gain",),
    "duty_limit": ("effort_limit",),
    "supply": ("supply_voltage", "voltage_sag"),
    "torque_constant": ("torque_constant", "motor_heating", "motor_saturation"),
    "armature": ("rotor_inertia",),
    "friction": (*DRY, "viscous_friction"),
    "friction.coulomb": DRY,
    "friction.viscous": ("viscous_friction",),
}
"""Keys of a servo, and the effects that change what they say."""
BODY: dict[str, tuple[str, ...]] = {
    "robot.mass": ("link_mass", "payload"),
    "robot.center_of_mass": ("center_of_mass",),
    "robot.inertia": ("link_inertia",),
    "robot.base": ("base_tilt",),
}
QUANTITIES: dict[str, tuple[str, ...]] = {
    **BODY,
    "robot.urdf": tuple(effect for effects in BODY.values() for effect in effects),
    "ground": ("ground_friction", "soft_ground"),
    "ground.friction": ("ground_friction",),
    "ground.stiffness": ("soft_ground",),
    "ground.damping": ("soft_ground",),
}
"""What else a scenario says, and the effects that change it."""


def may_be_suspected(scenario: Scenario, model: Model, effect: str, target: str | Sequence[str]) -> bool:
    """Whether `certain` and `suspects` of a scenario allow an effect at a target to be suspected.

    An effect on several joints is allowed where it is at each of them. What is no effect of the table, as the
    "something else" that names are compared with, is always allowed.

    Args:
        scenario: the scenario.
        model: its robot, whose joints the servos' patterns match.
        effect: name of the effect.
        target: a joint, a link, `ground`, `base`, a pattern over joints (`*`), or several of them.
    """
    if effect not in EFFECTS:
        return True
    if scenario.follows and EFFECTS[effect].unseen_when_followed:
        return False
    names = _meant(model, effect, [target] if isinstance(target, str) else target)
    only = [_split(entry) for entry in scenario.suspects or ()]
    if only and not all(any(e == effect and fnmatchcase(name, where) for e, where in only) for name in names):
        return False
    return not any(effect in effects and names & where for effects, where in _certain(scenario, model))


def check_suspicion(file: ScenarioFile, model: Model) -> None:
    """Make sure that `certain` and `suspects` name what there is.

    Raises:
        InputError: for an effect, quantity, servo, joint or link that does not exist.
    """
    scenario, everywhere = file.scenario, _everything(model)
    for i, entry in enumerate(scenario.suspects or ()):
        effect, where = _split(entry)
        _known(file, f"suspects[{i}]", effect, EFFECTS, "an effect")
        _somewhere(file, f"suspects[{i}]", entry, where, everywhere)
    for i, entry in enumerate(scenario.certain):
        key, (quantity, where) = f"certain[{i}]", _split(entry)
        _somewhere(file, key, entry, where, everywhere)
        name, part = _servo_part(quantity)
        if name is None:
            _known(file, key, quantity, [*QUANTITIES, *EFFECTS], "a quantity or an effect")
            continue
        _known(file, key, part, SERVO, "servos.NAME and one of its keys that an effect changes")
        names = [s.name or str(k) for k, s in enumerate(scenario.servos)]
        if name != "*":
            _known(file, key, name, names, "the name of a servo")


def _certain(scenario: Scenario, model: Model) -> list[tuple[tuple[str, ...], set[str]]]:
    """Effects that are ruled out, with the names of the joints, links, `ground` and `base` where they are."""
    out = []
    for entry in scenario.certain:
        quantity, where = _split(entry)
        servo, part = _servo_part(quantity)
        if servo is None:
            effects, names = QUANTITIES.get(quantity, (quantity,)), _everything(model)
        else:
            effects, names = SERVO.get(part, ()), _joints_of(scenario, model, servo)
        out.append((effects, {name for name in names if fnmatchcase(name, where)}))
    return out


def _joints_of(scenario: Scenario, model: Model, name: str) -> set[str]:
    """The joints of the servos of that name (`*`: of all); the first servo that matches a joint has it."""
    taken: set[int] = set()
    out: set[str] = set()
    for i, servo in enumerate(scenario.servos):
        own = set(match_joints(model, servo.joints)) - taken
        taken |= own
        if name in ("*", servo.name, str(i)):
            out |= {model.joint_names[j] for j in own}
    return out


def _meant(model: Model, effect: str, targets: Iterable[str]) -> set[str]:
    """The names that targets mean: patterns over joints or links are filled in, a lumped link is its carrier."""
    sits_at = EFFECTS[effect].sits_at
    if sits_at in ("ground", "base"):
        return {sits_at}
    names = model.joint_names if sits_at == "joint" else [link.name for link in model.links]
    carrier = {m: link.name for link in model.links for m in link.merged} if sits_at == "link" else {}
    wanted = [carrier.get(t, t) for t in targets]
    return {name for name in names if any(fnmatchcase(name, t) for t in wanted)}


def _everything(model: Model) -> set[str]:
    return {*model.joint_names, *(link.name for link in model.links), "ground", "base"}


def _split(entry: str) -> tuple[str, str]:
    what, _, where = entry.partition("@")
    return what, where or "*"


def _servo_part(quantity: str) -> tuple[str | None, str]:
    """The servo's name and the key of a quantity like `servos.legs.friction.coulomb`; None for another quantity."""
    parts = quantity.split(".", 2)
    return (parts[1], parts[2]) if parts[0] == "servos" and len(parts) == 3 else (None, "")


def _known(file: ScenarioFile, key: str, found: str, known: Iterable[str], what: str) -> None:
    if found not in known:
        raise InputError(f"{file.path}: {key}: found {found}{meant_first(found, known, f'expected {what}')}")


def _somewhere(file: ScenarioFile, key: str, entry: str, where: str, names: Iterable[str]) -> None:
    if not any(fnmatchcase(name, where) for name in names):
        raise InputError(
            f"{file.path}: {key}: found {entry}, but {where} matches no joint or link; the robot has "
            f"{', '.join(sorted(names))}"
        )
