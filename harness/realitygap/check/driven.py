"""Whether anything drives the robot: servos that match, commands that come, joints that have both."""

from collections.abc import Sequence
from fnmatch import fnmatchcase

import numpy as np

from realitygap.check.mistake import Mistake
from realitygap.check.observed import Observed
from realitygap.check.words import joined
from realitygap.robot.drive import NONE
from realitygap.robot.plant import Plant, match_joints
from realitygap.scenario.file import ScenarioFile


def servo_patterns(file: ScenarioFile, plants: Sequence[Plant]) -> list[Mistake]:
    """Patterns of servos that match no joint of any run's robot, and servos whose joints all have an earlier one."""
    out = []
    names = list(dict.fromkeys(name for plant in plants for name in plant.model.joint_names))
    for i, servo in enumerate(file.scenario.servos if names else []):
        for k, pattern in enumerate(servo.joints):
            if not any(fnmatchcase(name, pattern) for name in names):
                sentence = f"the pattern {pattern} matches no joint; the robot has {', '.join(names)}"
                out.append(Mistake("servo_pattern", "certain", (), sentence, f"servos[{i}].joints[{k}]"))
        earlier = [pattern for s in file.scenario.servos[:i] for pattern in s.joints]
        own = {name for p in plants for name in _matched(p, servo.joints)}
        if own and all(own & _matched(p, servo.joints) <= _matched(p, earlier) for p in plants):
            sentence = (
                f"every joint that {', '.join(servo.joints)} matches has an earlier servo, and the first that matches "
                "wins; expected the narrower patterns first"
            )
            out.append(Mistake("servo_pattern", "likely", tuple(sorted(own)), sentence, f"servos[{i}].joints"))
    return out


def _matched(plant: Plant, patterns: Sequence[str]) -> set[str]:
    return {plant.model.joint_names[j] for j in match_joints(plant.model, list(patterns))} if patterns else set()


def drives_nothing(file: ScenarioFile, plants: Sequence[Plant], observed: Sequence[Observed]) -> list[Mistake]:
    """A robot with joints that no servo or no motion drives."""
    with_joints = [p for p in plants if p.model.joints]
    if not with_joints or file.scenario.follows:
        return []
    names = tuple(sorted({name for p in with_joints for name in p.model.joint_names}))
    if all((p.drive["kind"] == NONE).all() and not p.efforts for p in with_joints):
        sentence = "found no servo, so that nothing drives the robot's joints; expected what turns commands into torque"
        return [Mistake("drives_nothing", "certain", names, sentence, "servos")]
    if file.scenario.motion is None:
        if not observed:  # no motion and no recording: there is nothing to do at all, which is said elsewhere
            return []
        sentence = "found no motion, so that nothing drives the robot; expected recorded: TOPIC or keyframes: FILE"
        return [Mistake("drives_nothing", "certain", names, sentence, "motion")]
    if file.scenario.motion.keyframes is not None:
        return []
    out = []
    for o in observed:
        if not np.isfinite(o.recording.command).any():
            sentence = (
                f"{o.name} holds no command of a joint whose servo is on, so that nothing drives the robot; expected "
                "some, or `accept: [drives_nothing]` where the robot swings freely"
            )
            out.append(Mistake("drives_nothing", "certain", o.joints, sentence, "motion.recorded", (o.name,)))
    return out


def undriven(o: Observed) -> list[Mistake]:
    """Joints without a servo that are told to move, or that are never commanded, among others that are.

    A pole on a cart has no servo, and no command that changes; a joint that mimics another is moved by that one's.
    """
    if o.is_followed:
        return []
    free = np.array([joint.mimic is None for joint in o.plant.model.joints])
    limp = (o.plant.drive["kind"] == NONE) & free
    told = np.isfinite(o.recording.command).any(axis=0) | ~free
    recorded = o.scenario.motion is not None and o.scenario.motion.recorded is not None
    moved = np.nan_to_num(np.diff(o.recording.command, axis=0)).any(axis=0) if recorded else limp
    out = []
    if (limp & moved).any() and not limp.all():
        names = [o.joints[j] for j in np.flatnonzero(limp & moved)]
        sentence = (
            f"no servo drives {joined(names)}: it moves freely; expected a servo whose pattern matches it, or "
            "`accept: [undriven_joint]` for a joint that is passive"
        )
        out.append(Mistake("undriven_joint", "likely", tuple(sorted(names)), sentence, "servos", (o.name,)))
    if recorded and told.any() and (~told & ~limp).any():
        names = [o.joints[j] for j in np.flatnonzero(~told & ~limp)]
        sentence = (
            f"{joined(names)} is never commanded, so that its servo is off; expected a command for it, or "
            "`accept: [undriven_joint]` where it was off"
        )
        out.append(Mistake("undriven_joint", "likely", tuple(sorted(names)), sentence, "motion.recorded", (o.name,)))
    return out
