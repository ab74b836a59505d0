"""The first scenario of a table: which column is what, by the names that people give them."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from realitygap.files.errors import InputError
from realitygap.init.names import (
    COMMAND_WORDS,
    OF_TURNS,
    QUANTITIES,
    by_stem,
    meant,
    measured_joints,
    of_all,
    role_of,
    stands_alone,
    told_by,
    unmeasured,
    words,
)
from realitygap.init.other_shapes import told_shape
from realitygap.init.sections import (
    AS_FOLLOWED,
    ASKED_AND_MEASURED,
    COMMANDS_BY,
    FOLLOWED,
    FOLLOWED_ASKED,
    NOTHING_DRIVES,
    Motion,
    Sections,
    Units,
    current_line,
    current_told,
    no_motion,
    quoted,
    runs_of,
)
from realitygap.init.time_column import time_column, time_unit
from realitygap.recording.readers.table import FORMS, column_of, load
from realitygap.scenario.schema import Columns

LENGTHS = {
    **dict.fromkeys(("°", "deg", "degree", "degrees", "grad"), "deg"),
    **dict.fromkeys(("m°", "mdeg"), "mdeg"),
    **dict.fromkeys(("rev", "revs", "turn", "turns"), "rev"),
    **{name: name for name in ("mrad", "mm", "cm")},
}
RATES = LENGTHS | dict.fromkeys(OF_TURNS, "rpm")
NOT_SI = {
    "time": {name: name for name in ("ms", "us", "ns")},
    "position": LENGTHS,
    "velocity": RATES,
    "command": RATES,
}
"""Words of a signal's labels that say a unit, and how a scenario says it."""
NOT_NM = {"mNm": 1e-3, "Nmm": 1e-3, "Ncm": 1e-2}
"""Units of an effort that a label says, and N·m per unit."""
SAID_NM = {name: re.compile(rf"(?<![a-z]){name.replace('N', 'n[·.*]?', 1)}(?![a-z])", re.IGNORECASE) for name in NOT_NM}
"""How labels write them: also in lower case, and as mN·m."""
DEFAULTS = {key: key for key in ("time", "command", "position", "velocity", "effort", "torque_enabled")}
INDEX = re.compile(r"__index_level_\d+__")
"""What pandas calls an index without a name in Parquet."""
ANGLES = ("position", "velocity", "command")
"""Signals that are angles or angles per s, a command where it is a position or a velocity."""
Column = str | dict[str, str] | list[str]
"""A column by its stem, or by joint; a time of two columns."""


def table_sections(paths: list[Path], joints: Sequence[str], urdf: Path, out: Path) -> Sections:
    """Motion, recordings and runs of tables that are built like the first one.

    Joints of which the table holds no position, while it does of others, are held.

    Raises:
        InputError: for a table without time, or without the position of any joint of the robot.
    """
    path = paths[0]
    frame = load(path)
    labels = list(frame.columns)
    time = time_column(path, frame)
    rest = [label for label in labels if label not in time]
    chosen, meaning = _roles(rest, joints) if joints else ({}, "position")
    if joints and "position" not in chosen:
        part = measured_joints(labels, joints)
        if part and part != tuple(joints):
            held = tuple(joint for joint in joints if joint not in part)
            seen = unmeasured(labels, joints, held)
            return replace(table_sections(paths, part, urdf, out), held=held, unmeasured=seen)
        raise InputError(
            f"{path}: no column holds the position of {', '.join(joints)} of {urdf}; it has {', '.join(labels)}; "
            "expected one of position, pos, q, angle, measured, with the joint's name or number before or behind it: "
            f"rename columns, or write a scenario with recordings.columns.position: {{{joints[0]}: COLUMN}}"
            f"{told_shape(frame, joints, time)}"
        )
    columns: dict[str, Column] = {"time": time[0] if len(time) == 1 else time, **chosen}
    current = _current(chosen)
    unit_of_current = "recorded mA" if current and "ma" in _words(columns["effort"]) else "A"
    followed = "effort" in columns and ("command" not in columns or meaning == "effort")
    told = _told(labels, columns, joints)
    if current:
        label = _labels(columns["effort"])[0]
        told.append(current_told(f"column {label}", "", unit_of_current, followed=followed))
    if "command" in columns and "effort" in columns and meaning == "position":
        told.append(
            "where the controller is not known, `motion: {followed: true}` in place of motion and servos asks the "
            "model for the measured effort alone"
        )
    if followed and meaning == "effort":
        told.append(ASKED_AND_MEASURED)
    elif "command" not in columns and joints:
        told.append(AS_FOLLOWED.format("column") if followed else NOTHING_DRIVES.format("column"))
        told.append(COMMANDS_BY.format("column", COMMAND_WORDS))
    units, units_by = _units(columns), "as the names say"
    if "time" not in units and len(time) == 1 and (unit := time_unit(frame[time[0]])) != "s":
        units["time"], units_by = unit, f"GUESS: {time[0]} counts in {unit}, as its values show"
    lines = []
    if "effort" in columns:
        lines.append(current_line("", unit_of_current, followed=followed) if current else _effort(columns["effort"]))
    motion = _motion(columns, meaning, followed=followed)
    angles = tuple(s for s in ANGLES if s in columns and s not in units and (s != "command" or meaning in ANGLES))
    return Sections(
        motion,
        lines,
        runs_of(paths, out),
        meaning=meaning,
        told=told,
        followed=followed,
        columns=_columns(columns, joints),
        units=units,
        units_by=units_by,
        angles=angles,
    )


def _roles(labels: Sequence[str], joints: Sequence[str]) -> tuple[dict[str, Column], str]:
    """The columns of position, velocity, effort, torque_enabled and command, and what the command is."""
    stems = by_stem(labels, joints)
    roles = {stem: role for stem in stems if (role := role_of(stem)) is not None}
    columns: dict[str, Column] = {}
    if roles and (alone := next((stem for stem in stems if stands_alone(stem)), None)) is not None:
        columns["position"] = _written(stems[alone], labels, joints)  # as shoulder beside shoulder_cmd
    for key in ("position", "velocity", "effort", "current", "torque_enabled"):
        found = [s for s, (kind, command, _) in roles.items() if kind == key and not command]
        if found and (key != "current" or "effort" not in columns):
            best = max(found, key=lambda s: (s == (key,), roles[s][2], -len(s)))  # plain names, then what says measured
            columns["effort" if key == "current" else key] = _written(stems[best], labels, joints)
    if "torque_enabled" not in columns and (switch := of_all(labels, joints, "torque_enabled")) is not None:
        columns["torque_enabled"] = switch
    for kind in ("position", "velocity", "duty", "effort"):
        found = [s for s, (k, command, _) in roles.items() if k == kind and (command or kind == "duty")]
        if found:
            best = min(found, key=len)
            columns["command"] = _written(stems[best], labels, joints)
            return columns, kind
    return columns, "position"


def _written(found: dict[str, str], labels: Sequence[str], joints: Sequence[str]) -> Column:
    """The column as short as a scenario can say it: a stem where a reader finds every joint's column by it."""
    if len(joints) == 1:
        return found[joints[0]]
    for form in FORMS:
        before, after = form.format("", joints[0]), form.format(joints[0], "")
        name = found[joints[0]].removesuffix(before).removeprefix(after)
        if name and all(column_of(name, joint, labels) == found[joint] for joint in joints):
            return name
    return found


def _motion(columns: Mapping[str, Column], meaning: str, *, followed: bool) -> Motion:
    """The motion; of an effort that was both asked for and measured, following says more than playing it back."""
    if followed:
        return FOLLOWED if "command" not in columns else FOLLOWED_ASKED
    if "command" not in columns:
        return no_motion("COLUMN")
    name = columns["command"]
    kind = {} if meaning == "position" else {"as": meaning}
    plain = meaning == "position" and not meant(tuple(_words(name))) & QUANTITIES["position"]
    guess = "positions, as its name says nothing else; or as: effort, velocity or duty" if plain else ""
    return Motion({"recorded": quoted(name) if isinstance(name, str) else "command", **kind}, guess)


def _columns(columns: Mapping[str, Column], joints: Sequence[str]) -> list[str]:
    """The `columns` that are not called as a scenario expects by itself."""
    lines = []
    for key, name in columns.items():
        if isinstance(name, dict):
            inner = ", ".join(f"{quoted(j)}: {quoted(c)}" for j, c in name.items())
            lines.append(f"    {key}: {{{inner}}}  # GUESS: {told_by(name, joints)}")
        elif isinstance(name, list):
            lines.append(
                f"    {key}: [{', '.join(map(quoted, name))}]  # GUESS: seconds and nanoseconds, by their names"
            )
        elif name != DEFAULTS[key]:
            why = "the table's index" if INDEX.fullmatch(name) else "by its name"
            lines.append(f"    {key}: {quoted(name)}  # GUESS: {why}")
    return lines


def _current(columns: Mapping[str, Column]) -> bool:
    name = columns.get("effort")
    role = role_of(words(_labels(name)[0])) if name else None
    return role is not None and role[0] == "current"


def _effort(column: Column) -> str:
    """The line of a measured effort, with the factor that the names of all its columns say."""
    said = [{name for name, form in SAID_NM.items() if form.search(label)} for label in _labels(column)]
    if len(said[0]) != 1 or any(one != said[0] for one in said):
        return "  effort: motor  # GUESS: of the motor, before friction, in N·m or N"
    (name,) = said[0]
    why = f"of the motor, before friction; N·m per recorded {name}, as its name says"
    return f"  effort: {{measures: motor, factor: {NOT_NM[name]}}}  # GUESS: {why}"


def _told(labels: Sequence[str], columns: Mapping[str, Column], joints: Sequence[str]) -> list[str]:
    used = set()
    for name in (*columns.values(), Columns().temperature):  # by joint, it is called by their names
        stems = _labels(name)
        used |= {form.format(stem, joint) for stem in stems for joint in joints for form in FORMS} | set(stems)
    expected = Columns().model_dump(exclude={*DEFAULTS, "units", "base_angular_axes", "temperature"}).values()
    known = {name for names in expected for name in ([names] if isinstance(names, str) else names)}
    spare = [label for label in labels if label not in used | known]
    return [f"not used: {', '.join(spare)}{_way_to_use(spare, columns, joints)}"] if spare else []


def _way_to_use(spare: Sequence[str], columns: Mapping[str, Column], joints: Sequence[str]) -> str:
    """How a scenario names the columns that every joint has and whose names say nothing that is known."""
    found = (_written(labels, spare, joints) for labels in by_stem(spare, joints).values()) if len(joints) > 1 else ()
    stems = [name for name in found if isinstance(name, str)]
    angles = [name for name in stems if (role := role_of(words(name))) is not None and role[0] == "position"]
    if angles and "command" not in columns:  # the measured one is another
        return f" (where they are what was asked for, `motion: {{recorded: {quoted(angles[0])}}}` takes them)"
    stems = [name for name in stems if name not in angles]
    free = [key for key in ("velocity", "effort") if key not in columns]
    if not stems or not free:
        return ""
    effort = ", and an effort beside it `effort: motor`" if "effort" in free else ""
    return f" (recordings.columns takes them for all joints, as `{free[0]}: {stems[0]}`{effort})"


def _words(column: Column) -> set[str]:
    return {word for label in _labels(column) for word in words(label)}


def _labels(column: Column) -> list[str]:
    """The labels, or stems of labels, that say a column."""
    if isinstance(column, str):
        return [column]
    return list(column.values() if isinstance(column, dict) else column)


def _units(columns: Mapping[str, Column]) -> Units:
    """The units that the names of columns say, where they are not SI, by joint where joints differ."""
    out: Units = {}
    for key, column in columns.items():
        known = NOT_SI.get(key, {})
        said = [next((known[w] for w in words(label) if w in known), "rad") for label in _labels(column)]
        if len(set(said)) > 1 and isinstance(column, dict):
            out[key] = dict(zip(column, said, strict=True))
        elif said[0] in known.values():
            out[key] = said[0]
    return out
