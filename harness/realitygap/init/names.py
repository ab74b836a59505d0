"""Names as people write them: which of a robot's joints a column or a value belongs to, and what it measures there."""

import re
from collections.abc import Mapping, Sequence

WORD = re.compile(
    r"(?<![A-Za-z])mA(?![a-z])|(?<![A-Za-z])m°|(?<![A-Za-z0-9_])(?:[UuRr1]|rev)/min(?![A-Za-z])|[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+|°"
)
"""Of lower case, with a capital before it, or of capitals; and mA, m°, ° and U/min, which people write so."""
Stem = tuple[str, ...]
"""The words of a label without those that say which joint."""
GENERIC = {"joint", "motor", "servo", "actuator"}
"""Words of a joint's name that labels leave out: shoulder_pos is of shoulder_joint."""


def words(label: str) -> Stem:
    """The words and numbers of a label, in lower case: `shoulderPan_pos1` is shoulder, pan, pos, 1."""
    return tuple(word.lower() for word in WORD.findall(label))


def spelt_otherwise(names: Sequence[str], joints: Sequence[str]) -> dict[str, str]:
    """The name of every joint among names that are its own but for capitals and what stands between words, as
    `Shoulder-Pan` of shoulder_pan; none where that leaves one without a name, or with several.
    """
    found = {joint: [name for name in names if _letters(name) == _letters(joint)] for joint in joints}
    return {joint: same[0] for joint, same in found.items()} if all(len(s) == 1 for s in found.values()) else {}


def _letters(name: str) -> str:
    return "".join(letter for letter in name.casefold() if letter.isalnum())


def by_stem(labels: Sequence[str], joints: Sequence[str]) -> dict[Stem, dict[str, str]]:
    """What is there for every joint: stem to joint to label. A label names a joint by its name or by its number.

    Numbers count from 0 or from 1 in the robot's order, or are those in the joints' own names. A robot with one joint
    needs no name. Units are no part of a stem, as joints may differ in them.
    """
    named: dict[Stem, dict[str, str]] = {}
    numbered: dict[Stem, dict[int, str]] = {}
    for label in labels:
        parts = words(label)
        joint, rest = _named(parts, joints)
        numbers = [part for part in parts if part.isdigit()]
        if joint is not None:
            named.setdefault(bare(rest), {}).setdefault(joint, label)
        elif numbers:
            place = len(parts) - 1 - parts[::-1].index(numbers[-1])
            stem = bare(parts[:place] + parts[place + 1 :])
            numbered.setdefault(stem, {}).setdefault(int(numbers[-1]), label)
        if joint is None and parts and len(joints) == 1:
            named.setdefault(bare(parts), {}).setdefault(joints[0], label)
    for stem, found in numbered.items():
        ordered = _in_order(found, joints)
        if ordered is not None:
            named.setdefault(stem, ordered)
    return {stem: found for stem, found in named.items() if len(found) == len(joints)}


def bare(stem: Stem) -> Stem:
    """The words of a stem but for units; of one that has no others, they are kept where they are none of a position."""
    kept = tuple(word for word in stem if word not in UNITS)
    return kept if kept or stands_alone(stem) else stem


def joint_of(label: str, joints: Sequence[str]) -> str | None:
    """The joint whose name stands in a label; None where none does."""
    return _named(words(label), joints)[0]


def _named(parts: Stem, joints: Sequence[str]) -> tuple[str | None, Stem]:
    """The joint whose words stand in a label, and what is left of the label; the longest name wins."""
    best: tuple[str | None, Stem] = None, parts
    longest = 0
    for joint in joints:
        for own in (words(joint), _short(joint, joints)):
            for i in range(len(parts) - len(own) + 1):
                if own and parts[i : i + len(own)] == own and len(own) > longest:
                    longest, best = len(own), (joint, parts[:i] + parts[i + len(own) :])
    return best


def _short(joint: str, joints: Sequence[str]) -> Stem:
    """The words of a joint's name without generic ones; none where another joint has the same, or numbers are left."""
    own = tuple(word for word in words(joint) if word not in GENERIC)
    same = [j for j in joints if tuple(word for word in words(j) if word not in GENERIC) == own]
    return own if len(same) == 1 and not all(word.isdigit() for word in own) else ()


def measured_joints(labels: Sequence[str], joints: Sequence[str]) -> tuple[str, ...]:
    """The joints that a label names and whose position it says that it holds, in the robot's order."""
    found, alone, beside = set[str](), set[str](), set[str]()
    for label in labels:
        joint, rest = _named(words(label), joints)
        role = role_of(tuple(word for word in rest if word not in UNITS))
        if joint is not None and role is not None:
            (found if role[:2] == ("position", False) else beside).add(joint)
        elif joint is not None and stands_alone(rest):
            alone.add(joint)
    return tuple(joint for joint in joints if joint in found or joint in alone & beside)


def of_all(labels: Sequence[str], joints: Sequence[str], quantity: str) -> str | None:
    """The only label of a quantity that names no joint, neither by its name nor by a number; None where none is, or
    several are.
    """
    found = [
        label
        for label in labels
        if (parts := words(label)) and _named(parts, joints)[0] is None and not any(part.isdigit() for part in parts)
        if (role := role_of(parts)) is not None and role[:2] == (quantity, False)
    ]
    return found[0] if len(found) == 1 else None


def unmeasured(labels: Sequence[str], joints: Sequence[str], held: Sequence[str]) -> dict[str, list[str]]:
    """The labels of signals that name a joint that is held: it was there, though its position was not recorded."""
    out: dict[str, list[str]] = {}
    for label in labels:
        joint, rest = _named(words(label), joints)
        if joint is not None and joint in held and role_of(rest) is not None:
            out.setdefault(joint, []).append(label)
    return out


def told_by(found: Mapping[str, str], joints: Sequence[str]) -> str:
    """How labels by joint say whose they are: a number says less than a name, as robots and loggers count apart."""
    if all(_named(words(label), joints)[0] == joint for joint, label in found.items()):
        return "by their names"
    if all(_number(joint) in map(int, re.findall(r"\d+", label)) for joint, label in found.items()):
        return "by the numbers in the joints' names"
    return "by number, in the URDF's order: check it"


def _number(joint: str) -> int:
    """The last number in a joint's name; -1 where it has none."""
    return int(numbers[-1]) if (numbers := re.findall(r"\d+", joint)) else -1


def _in_order(found: Mapping[int, str], joints: Sequence[str]) -> dict[str, str] | None:
    """Labels by number, given to the joints of these numbers."""
    own = [_number(joint) for joint in joints]
    for expected in (own, list(range(len(joints))), list(range(1, len(joints) + 1))):
        if len(set(expected)) == len(joints) and sorted(found) == sorted(expected):
            return {joint: found[number] for joint, number in zip(joints, expected, strict=True)}
    return None


COMMAND = {
    *("command", "commands", "commanded", "cmd", "goal", "goals", "target", "targets", "desired", "des"),
    *("reference", "references", "ref", "setpoint", "setpoints", "sp", "soll", "sollwert"),
}
COMMAND_WORDS = ", ".join(sorted(word for word in COMMAND if word.removesuffix("s") not in COMMAND - {word}))
"""Those that a sentence lists: each once, not in the plural, too."""
MEASURED = {
    *("measured", "meas", "actual", "act", "present", "state", "states", "feedback", "fb", "encoder", "enc", "real"),
    *("ist", "istwert"),
}
QUANTITIES: dict[str, set[str]] = {
    "position": {"position", "positions", "pos", "q", "angle", "angles", "theta", "joint", "joints", "winkel"},
    "torque_enabled": {"enabled", "enable"},  # before the torque, which is not what a torque_enabled holds
    "velocity": {
        *("velocity", "velocities", "vel", "qd", "dq", "qdot", "speed", "omega"),
        *("drehzahl", "geschwindigkeit", "winkelgeschwindigkeit"),
    },
    "effort": {"effort", "efforts", "torque", "torques", "tau", "force", "trq", "moment", "drehmoment", "kraft"},
    "current": {"current", "currents", "amp", "amps", "curr", "strom"},
    "duty": {"duty", "pwm"},
    "other": {
        *("acceleration", "acc", "qdd", "ddq", "temperature", "temp", "voltage", "volt", "error", "err", "status"),
        *("limit", "limits", "mode", "beschleunigung", "temperatur", "spannung", "fehler"),
    },
}
OF_POSITIONS = {
    *("rad", "rads", "mrad", "deg", "degrees", "degree", "grad", "°", "mdeg", "m°", "rev", "revs", "turn", "turns"),
    *("m", "cm", "mm"),
}
OF_TURNS = {"rpm", "u/min", "r/min", "rev/min", "1/min"}
UNITS = OF_POSITIONS | OF_TURNS | {"nm", "a", "ma", "s", "ms", "v"}


def stands_alone(stem: Stem) -> bool:
    """Whether a label has nothing but the joint's name, and perhaps a unit of a position."""
    return set(stem) <= OF_POSITIONS


def meant(stem: Stem) -> set[str]:
    """The words of a stem; of two that are written as one, as qdes or goalpos, what both of them say, too."""
    said = set(stem)
    quantities = {name for names in QUANTITIES.values() for name in names}
    for word in said - quantities - COMMAND - MEASURED:
        pairs = ((word[:k], word[k:]) for k in range(1, len(word)))
        for pair in pairs:
            if set(pair) & quantities and set(pair) & (COMMAND | MEASURED):
                said |= set(pair)
    return said


def role_of(stem: Stem) -> tuple[str, bool, bool] | None:
    """Quantity, whether it is a command, and whether the stem says that it is measured; None for what is no signal.

    A stem of no known quantity is a position where it says that it is commanded or measured.
    """
    said = meant(stem)
    command, measured = bool(said & COMMAND), bool(said & MEASURED)
    kinds = [kind for kind, names in QUANTITIES.items() if said & names]
    if "other" in kinds or (not kinds and not command and not measured):
        return None
    strong = [kind for kind in kinds if kind != "position"]  # joint_velocity_1 is a velocity
    return (strong or ["position"])[0], command, measured
