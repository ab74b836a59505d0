"""Tables of text (comma, semicolon, tab or white space between cells; point or comma in numbers) and Parquet."""

import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import overload

import numpy as np
import pandas as pd

from realitygap.files.errors import InputError
from realitygap.files.text_table import check_short, text_table
from realitygap.files.unpacked import unpacked
from realitygap.recording.frames import rotate, unit_quaternions
from realitygap.recording.lack import Lack
from realitygap.recording.readers.cells import Cells, Frame
from realitygap.recording.readers.dialect import dialect_of
from realitygap.recording.readers.echoed import by_joint
from realitygap.recording.readers.kind import check_kind
from realitygap.recording.readers.parquet_columns import WHOLE, ParquetColumns
from realitygap.recording.readers.rows import (
    APART,
    Mask,
    Rows,
    alike,
    last_of_each,
    out_of_order,
    repeats,
    rows_apart,
    rows_with,
)
from realitygap.recording.readers.table_time import rows_by_time
from realitygap.recording.readers.thousands import without_points
from realitygap.recording.readers.units import SECONDS, joint_factors
from realitygap.recording.streams import Request, Samples, Streams
from realitygap.scenario.schema import LEFT_OUT, Columns
from realitygap.trace.trace import Array

CUT_OFF = Lack("cut", "the last line is cut off and was left out")


def read(path: Path, request: Request) -> Streams:
    """The streams of a table that a scenario asks for, all on the clock of its rows.

    Raises:
        InputError: for a file that is not a table, a column or joint that is not there, a value that is not a number,
            or time that goes far back.
    """
    table = Table(path, load(path), request)
    (time, order), joints = table.times(), request.joints
    state = table.state() if joints else {}
    command, said = table.command() if joints else ({}, None)
    disorder = out_of_order(time)
    apart = said is not None and rows_apart(rows_with(np.isfinite(state["position"])), rows_with(said))
    cut = dict[tuple[int, int], bool]()  # rows that were kept and those there were: whether nothing is lost with them

    def samples(signals: dict[str, Array], named: tuple[str, ...] = (), present: Mask | None = None) -> Samples | None:
        if not signals:
            return None
        own = order
        if apart:
            held = [np.isfinite(value) for value in signals.values()] if present is None else [present]
            own = own[np.any([rows_with(mask) for mask in held], axis=0)[own]]
        if not len(own):
            return None
        keep = own[last_of_each(time[own])]
        if len(keep) < len(own):
            same = all(alike(value, own, keep) for value in signals.values())
            cut[len(keep), len(own)] = same and cut.get((len(keep), len(own)), True)
        whole = len(keep) == len(time) and disorder is None
        kept = signals if whole else {name: value[keep] for name, value in signals.items()}
        return Samples(str(path), time[keep], kept, named, None if present is None else present[keep])

    return Streams(
        state=samples(state, joints),
        command=samples(command, joints, said if apart else None),
        effort=samples(table.effort(), joints) if joints else None,
        pose=samples(table.base()) if request.base else None,
        supply=samples(table.supply()),
        temperature=_where_known(samples(table.temperature(), joints)) if joints else None,
        notes=(*([table.frame.attrs["note"]] if "note" in table.frame.attrs else []), *([APART] if apart else [])),
        dropped=(
            *table.dropped,
            *([disorder] if disorder else []),
            *(repeats(*counts, alike=same) for counts, same in cut.items()),
        ),
        dated=table.dated,
    )


def _where_known(slow: Samples | None) -> Samples | None:
    """A stream without the rows in which it was not read: a sensor may be slower than its table."""
    if slow is None:
        return None
    (name, value), *_ = slow.signals.items()
    known = ~np.isnan(value).any(axis=1)
    return replace(slow, time=slow.time[known], signals={name: value[known]}) if known.any() else None


def load(path: Path) -> Frame:
    """The table in a file.

    Raises:
        InputError: for a file that is not a table with a header and at least one row.
    """
    with unpacked(path) as plain:
        try:
            check_kind(path, plain)
            if plain.suffix.lower() == ".parquet":
                frame: Frame = ParquetColumns(path, plain)
            else:
                frame = _of_text(plain)
        except InputError:
            raise
        except Exception as error:  # pandas and pyarrow raise many kinds for a broken file
            what = " ".join(str(error).split()) or type(error).__name__
            text = f"columns with a header line{', saved as UTF-8' if isinstance(error, UnicodeError) else ''}"
            expected = WHOLE if plain.suffix.lower() == ".parquet" else text
            raise InputError(f"{path}: is not a table ({what}); expected {expected}") from None
    if not len(frame) or not len(frame.columns):
        raise InputError(f"{path}: the table holds no rows; it has the columns {', '.join(frame.columns)}")
    numbers = [name for name in frame.columns if NUMBER_LIKE.fullmatch(name)]
    if len(numbers) == len(frame.columns) or (2 * len(numbers) > len(frame.columns) and any("." in n for n in numbers)):
        raise InputError(f"{path}: begins with numbers; expected a line with the names of the columns above them")
    return frame


def _of_text(path: Path) -> pd.DataFrame:
    dialect = dialect_of(path)
    frame = text_table(path, **dialect.arguments())
    frame.columns = [str(name).strip() for name in frame.columns]
    spare = [name for name in frame.columns if name.startswith("Unnamed: ") and frame[name].isna().all()]
    width = max((i + 1 for i, name in enumerate(frame.columns) if name not in spare), default=0)
    if width and frame.iloc[:-1, width - 1].isna().any():  # only then may a line be short, and all are looked at
        check_short(path, width, **dialect.arguments())
    frame = frame.drop(columns=spare) if spare else frame  # every line ended with a separator
    if dialect.cut_off(path, len(frame.columns) + len(spare)):
        frame = frame[:-1]
        frame.attrs["cut_off"] = 1
    frame.attrs |= {"first_line": dialect.first_line, "decimal": dialect.decimal}
    return by_joint(without_points(frame) if dialect.decimal == "," else frame)


class Table(Cells):
    """A table, and which of its columns are what."""

    def __init__(self, path: Path, frame: Frame, request: Request) -> None:
        super().__init__(path, frame, request)
        self.columns: Columns = request.recordings.columns
        self.names = dict(zip(request.joints, request.names, strict=True))
        self.dropped: tuple[Lack, ...] = (CUT_OFF,) if frame.attrs.get("cut_off") else ()

    def times(self) -> tuple[Array, Rows]:
        """The times [s] of the rows from the first one, and the rows in their order."""
        names = self.columns.time if isinstance(self.columns.time, list) else [self.columns.time]
        label = " and ".join(names)
        if len(names) == 1:
            time = self._time(names[0])
        else:
            whole, rest = self._columns(names, "time", 2).T
            time = (whole - whole[0]) + rest * SECONDS["ns"]
        if np.isnan(time).any():
            line = self._line(int(np.flatnonzero(np.isnan(time))[0]))
            raise InputError(f"{self.path}: {label} is empty in line {line}, expected a time in s")
        order, far = rows_by_time(time)
        if far is not None:
            raise InputError(
                f"{self.path}: {label} goes back from {time[:far].max():g} to {time[far]:g} s in line "
                f"{self._line(far)}, expected times that increase: sort the rows by time, or cut the recording there"
            )
        if len(time) > 1 and np.ptp(time) == 0.0:
            raise InputError(
                f"{self.path}: {label} is {time[0]:g} s in all of its {len(time)} rows; expected times that increase"
            )
        return np.asarray(time - time[order[0]]), order

    def state(self) -> dict[str, Array]:
        """Position and, where it is there, velocity and effort."""
        stated = self.columns.model_fields_set
        left_out = self.columns.velocity == LEFT_OUT
        velocity = None if left_out else self._joints("velocity", required="velocity" in stated)
        found = {
            "position": self._si("position", self._joints("position", required=True)),
            "velocity": self._si("velocity", velocity),
            "effort": self._joints("effort", required="effort" in stated),
        }
        return {name: value for name, value in found.items() if value is not None}

    def effort(self) -> dict[str, Array]:
        """An effort in a column of its own name."""
        topic = self.request.effort_topic
        if topic is None:
            return {}
        found = self._joints("effort", stem=topic, required=True)
        assert found is not None
        return {"effort": found}

    def command(self) -> tuple[dict[str, Array], Mask | None]:
        """The command, NaN where there is none or the servo is off, and what of it a row says (t, n)."""
        motion = self.request.motion
        recorded = None if motion is None else motion.recorded
        if recorded is None:
            command = self._joints("command", required=False)
            kind = "position"
        else:
            stem = recorded if isinstance(recorded, str) and not self._by_columns(recorded) else None
            command = self._joints("command", stem=stem, required=True)
            kind = self.request.command_signal
        if command is None:
            return {}, None
        if kind != "effort":
            command = self._si("command", command)
        said: Mask = ~np.isnan(command)
        enabled = self._enabled()
        if enabled is not None:
            command = np.where(enabled == 0, np.nan, command)
            said |= enabled == 0
        return {kind: command}, said

    def _enabled(self) -> Array | None:
        """Whether servos are on: a column for each joint (t, n), or one for all (t, 1); None where nothing says it."""
        named, stated = self.columns.torque_enabled, "torque_enabled" in self.columns.model_fields_set
        if isinstance(named, str) and named in self.frame:
            return self._column(named, "torque_enabled")[:, None]
        return self._joints("torque_enabled", required=stated)

    def _by_columns(self, recorded: str) -> bool:
        """Whether `columns.command` says which columns the recorded command is: by the key's own name, or of a topic
        that other runs of the scenario hold in bags.
        """
        if any(self._of_joint(recorded, joint) is not None for joint in self.request.joints):
            return False
        return recorded == "command" or recorded.startswith("/")

    @overload
    def _si(self, signal: str, value: Array) -> Array: ...
    @overload
    def _si(self, signal: str, value: Array | None) -> Array | None: ...
    def _si(self, signal: str, value: Array | None) -> Array | None:
        """A position or velocity in SI units."""
        units, key = getattr(self.columns.units, signal), f"recordings.columns.units.{signal}"
        return None if value is None else value * joint_factors(units, self.request.joints, key, self.request.file)

    def supply(self) -> dict[str, Array]:
        """The supply voltage."""
        named = self.request.supply
        column = named or self.columns.supply
        if column not in self.frame and named is None and "supply" not in self.columns.model_fields_set:
            return {}
        return {"supply": self._column(column, "supply")}

    def temperature(self) -> dict[str, Array]:
        """The temperature of the motors: a column for each joint, or one for all."""
        named, stated = self.columns.temperature, "temperature" in self.columns.model_fields_set
        if isinstance(named, str) and named in self.frame:
            return {"temperature": self._column(named, "temperature")[:, None]}
        found = self._joints("temperature", required=stated)
        return {} if found is None else {"temperature": found}

    def base(self) -> dict[str, Array]:
        """Pose and velocity of the base, in world axes."""
        c = self.columns
        stated = bool({"base_position", "base_quaternion"} & c.model_fields_set)
        pose = [*c.base_position, *c.base_quaternion]
        if not stated and not all(name in self.frame for name in pose):
            if self.request.joints:
                return {}
            raise InputError(
                f"{self.path}: holds no pose of the robot, which has no joints that move (all are fixed, or in "
                f"robot.hold); it has {self._listing()}; expected {', '.join(pose)}, or their names in recordings."
                "columns.base_position and base_quaternion, or a robot's file with joints that move"
            )
        found = {
            "base_position": self._columns(c.base_position, "base_position", 3),
            "base_quaternion": self._columns(c.base_quaternion, "base_quaternion", 4),
        }
        for key, names in (("base_linear", c.base_linear), ("base_angular", c.base_angular)):
            if key in c.model_fields_set or all(name in self.frame for name in names):
                found[key] = self._columns(names, key, 3)
        if "base_angular" in found and c.base_angular_axes == "body":
            found["base_angular"] = rotate(unit_quaternions(found["base_quaternion"]), found["base_angular"])
        return found

    def _joints(self, signal: str, *, required: bool, stem: str | None = None) -> Array | None:
        """A joint signal as (t, n); None where it is not there and need not be."""
        named = getattr(self.columns, signal)
        joints = self.request.joints
        if isinstance(named, dict) and (stem is None or stem not in self.frame):
            missing = [joint for joint in joints if joint not in named]
            if missing:
                raise InputError(
                    f"{self.request.file}: recordings.columns.{signal}: names no column for joint {missing[0]}; it has "
                    f"{', '.join(named)}"
                )
            return np.column_stack([self._column(named[joint], signal) for joint in joints])
        base = stem or str(named)
        found = [self._of_joint(base, joint) for joint in joints]
        if all(name is not None for name in found):
            return np.column_stack([self._column(str(name), signal) for name in found])
        if not required:
            return None
        missing = [joint for joint, name in zip(joints, found, strict=True) if name is None]
        options = [base] if len(joints) == 1 else []
        options += [form.format(base, self.names[missing[0]]) for form in FORMS]
        named = signal == "command" and stem is not None
        elsewhere = f"as motion.recorded names {stem}" if named else f"or the names in recordings.columns.{signal}"
        if signal == "position" and len(joints) > 1:
            elsewhere += "; a joint that was not recorded is welded by robot.hold"
        raise InputError(
            f"{self.path}: has no {signal} of joint {missing[0]}; it has the columns {self._listing()}; expected "
            f"{', '.join(options)}, {elsewhere}"
        )

    def _of_joint(self, stem: str, joint: str) -> str | None:
        """The column of one joint's signal."""
        if len(self.request.joints) == 1 and stem in self.frame:
            return stem
        return column_of(stem, self.names[joint], self.frame.columns)


NUMBER_LIKE = re.compile(r"[-+]?[\d.][-+.\deE]*")
"""A number, also where pandas tells it from another one like it."""
FORMS = ("{0}_{1}", "{1}_{0}", "{0}.{1}", "{0}/{1}")
"""How the column of one joint's signal is called."""


def column_of(stem: str, joint: str, columns: Iterable[str]) -> str | None:
    """The column that holds a signal of a joint; None where there is none."""
    there = set(columns)
    return next((name for form in FORMS if (name := form.format(stem, joint)) in there), None)
