"""Guesses on a robot that no file states: whether its base is fixed, and what its servos are."""

import json
import re
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from realitygap_engines.model.robot import Joint, Model

from realitygap.init.measured_gains import Gains
from realitygap.init.names import words
from realitygap.init.sections import quoted
from realitygap.robot.servos import written_together

FIXED_ROOTS = ("world", "map", "odom", "ground", "table")
LEGS = re.compile(r"(left|right|front|rear|back|hind|[lrfbh]{0,2})(foot|feet|ankle|leg|wheel|knee)s?")
"""A word of a name that says leg or wheel, also with its side in front: allegro and legacy are none."""
FULL_ERROR = 0.1  # rad or m: a stiff position servo gives its full effort at about this error
TRAVEL_SHARE = 0.1  # of a slide's travel, where that is less: a finger of 40 mm never has an error of 100 mm
EFFORT_UNKNOWN = 5.0  # N·m or N at that error, for a joint without effort limit
GAIN_UNKNOWN = 1.0  # N·m·s/rad, for a joint without limits that is told velocities
SUPPLY = 12.0  # V
DAMPING_TIME = 0.005  # s: kd = kp times this, little enough for light links at 1 ms
STS3215 = re.compile(r"so.?10[01]|lekiwi", re.IGNORECASE)
"""What LeRobot calls robots with Feetech STS3215 servos."""


def base_of(model: Model, fixed: str | None, moving: str | None) -> tuple[str, str]:
    """Whether the base is fixed, floating or a free body, and why.

    Args:
        model: the robot.
        fixed: why it must be fixed, where it must.
        moving: a recorded stream that only a moving base has.
    """
    root = model.links[0].name
    parents = {joint.parent for joint in model.joints}
    ends = [link.name for i, link in enumerate(model.links) if i not in parents]
    if not model.joints:
        return "free", "the robot has no joints"
    if fixed is not None:
        return "fixed", fixed
    if any(note.startswith("floating joint ") for note in model.notes):
        return "floating", f"the URDF has a floating joint above the link {root}"
    if root.lower() in FIXED_ROOTS:
        return "fixed", f"the root link is called {root}"
    if moving is not None:
        return "floating", f"{moving} was recorded, as on a robot that moves"
    names = [name for link in model.links for name in (link.name, *link.merged)]
    if (leg := next((n for n in names if any(LEGS.fullmatch(word) for word in words(n))), None)) is not None:
        return "floating", f"the link {leg} is called as a leg or a wheel"
    if len(ends) >= 4:
        return "floating", f"the tree has {len(ends)} ends"
    return "fixed", f"the tree has {len(ends)} {'end' if len(ends) == 1 else 'ends'}, no legs and no wheels"


def servo_lines(model: Model, meaning: str, robot: str, gains: Mapping[str, Gains]) -> list[str]:
    """The lines of `servos`: the actuators of the robot's file, else a guess.

    Args:
        model: the robot.
        meaning: what a recorded command is: position, velocity, duty or effort.
        robot: what the recordings call it.
        gains: of servos, by joint, as far as measured efforts tell them.
    """
    if model.actuators:
        lines = ["# The actuators of the robot's file, as far as servos say them.", "servos:"]
        lines += [f"  - {json.dumps(servo, ensure_ascii=False)}" for servo in written_together(model.actuators)]
        return [*lines, *(f"  # {note}" for note in model.notes if note.startswith("actuator "))]
    return [
        "# GUESS: how the servos work is not in the files. With the data of a servo, `kind: dc` says more.",
        "servos:",
        *_guessed(model.joints, meaning, robot, gains),
    ]


def _guessed(joints: Sequence[Joint], meaning: str, robot: str, gains: Mapping[str, Gains]) -> list[str]:
    """The servo of a robot that is known by name, those whose gains are told, or one per limits of the URDF."""
    if STS3215.search(robot) and meaning == "position":
        return _sts3215(robot)
    groups: dict[tuple[float, float, float, bool], list[Joint]] = {}
    lines = [line for joint, of in gains.items() for line in _measured(joint, of)]
    for joint in joints:
        if joint.mimic is not None or joint.name in gains:  # another joint's servo moves it
            continue
        groups.setdefault((joint.effort, joint.velocity, _full_error(joint), joint.prismatic), []).append(joint)
    for alike in groups.values():
        pattern = '"*"' if len(groups) == 1 and not gains else f"[{', '.join(quoted(joint.name) for joint in alike)}]"
        lines.append(f"  - joints: {pattern}")
        lines += KINDS[meaning](alike[0])
    return lines


def _full_error(joint: Joint) -> float:
    """The error [rad or m] at which a servo is guessed to give its full effort."""
    travel = joint.upper - joint.lower
    return min(FULL_ERROR, TRAVEL_SHARE * travel) if joint.prismatic and travel > 0 else FULL_ERROR


def _sts3215(robot: str) -> list[str]:
    """The servo of `scenarios/so101`, with its sources: published identification of a 7.4 V unit, LeRobot's P 16."""
    return [
        f'  - joints: "*"  # GUESS: {" ".join(robot.split())} has Feetech STS3215 servos with LeRobot\'s settings',
        "    kind: dc",
        "    gain: 2.64  # GUESS: duty per rad at P 16, which is 0.165 times P",
        "    supply: 7.4  # GUESS: volts; kits of 5 to 12 V exist",
        "    torque_constant: 1.21  # GUESS: these four are a published identification of another unit",
        "    resistance: 2.68",
        "    armature: 0.0284",
        "    friction: {coulomb: 0.0524, viscous: 0.0591}",
    ]


def _measured(joint: str, gains: Gains) -> list[str]:
    """A servo whose gains measured efforts tell; a D on the measured speed alone is a cascade's."""
    why = f"explains {gains.share:.1%} of the measured effort"
    lines = [f"  - joints: [{quoted(joint)}]"]
    if gains.on_speed:
        return [
            *lines,
            "    kind: cascade  # GUESS: the measured effort follows the speed, and not the rate of the error",
            f"    gain: {_rounded(gains.kd):g}",
            "    kv: 1",
            f"    kp: {_rounded(gains.kp / gains.kd):g}  # GUESS: {why}",
        ]
    return [
        *lines,
        "    kind: pid",
        f"    kp: {_rounded(gains.kp):g}  # GUESS: {why}",
        f"    kd: {_rounded(gains.kd):g}",
    ]


def _rounded(value: float) -> float:
    """To three digits, as no guess is better."""
    return float(f"{value:.3g}")


def _effort(_: Joint) -> list[str]:
    """A motor that gives what it is told."""
    return ["    kind: effort  # GUESS: the commanded effort is what the motor gives, in N·m or N"]


def _velocity(joint: Joint) -> list[str]:
    """A servo that is told velocities and gives the URDF's effort at a small share of its velocity."""
    effort, velocity = joint.effort, joint.velocity
    bounded = bool(np.isfinite([effort, velocity]).all()) and velocity > 0
    gain = effort / (FULL_ERROR * velocity) if bounded else GAIN_UNKNOWN
    why = f"the URDF's effort limit of {effort:g} at an error of {FULL_ERROR:g} of its velocity limit of {velocity:g}"
    return [
        "    kind: velocity",
        f"    gain: {_rounded(gain):g}  # GUESS: {why if bounded else 'the URDF has no limits'}",
    ]


def _pid(joint: Joint) -> list[str]:
    """A stiff position servo with a little damping."""
    error, unit = _full_error(joint), "m" if joint.prismatic else "rad"
    bounded = bool(np.isfinite(joint.effort))
    kp = (joint.effort if bounded else EFFORT_UNKNOWN) / error
    travel = ", a tenth of its travel" if error < FULL_ERROR else ""
    limit = f"the URDF's effort limit of {joint.effort:g}" if bounded else f"no effort limit: {EFFORT_UNKNOWN:g}"
    spikes = "steps of a held command become spikes of effort, which motion's held: false avoids"
    return [
        "    kind: pid",
        f"    kp: {_rounded(kp):g}  # GUESS: {limit} at {error:.3g} {unit} of error{travel}",
        f"    kd: {_rounded(kp * DAMPING_TIME):g}  # GUESS: {DAMPING_TIME:g} s times kp; {spikes}",
    ]


def _dc(joint: Joint) -> list[str]:
    """A motor told its duty that stalls at the URDF's effort limit and runs free at its velocity limit."""
    bounded = bool(np.isfinite([joint.effort, joint.velocity]).all())
    stall, free = (joint.effort, joint.velocity) if bounded else (1.0, 10.0)
    why = "stalls at the URDF's effort limit, runs free at its velocity limit" if bounded else "the URDF has no limits"
    constant = SUPPLY / free
    return [
        "    kind: dc",
        "    gain: 0  # the recorded command is the duty",
        f"    supply: {SUPPLY:g}  # GUESS: volts",
        f"    torque_constant: {_rounded(constant):g}  # GUESS: {why}",
        f"    resistance: {_rounded(constant * SUPPLY / stall):g}  # GUESS: likewise",
    ]


KINDS: dict[str, Callable[[Joint], list[str]]] = {
    "position": _pid,
    "velocity": _velocity,
    "duty": _dc,
    "effort": _effort,
}
"""A servo by what it is told, from the URDF's limits of effort and velocity."""
