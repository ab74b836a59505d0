"""What every reader gets and gives: the streams of one recording, each on its own clock."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from realitygap.files.errors import InputError
from realitygap.recording.lack import Lack
from realitygap.scenario.effort import effort_factors
from realitygap.scenario.joint_names import recorded_names
from realitygap.scenario.schema import EffortStream, Motion, Recordings, Scenario, Stream
from realitygap.scenario.servos import DcServo, RecordedSupply
from realitygap.trace.trace import Array

COMMAND_SIGNAL = {"position": "position", "velocity": "velocity", "duty": "effort", "effort": "effort"}
"""The signal that holds a command, by what the command is."""


@dataclass(frozen=True)
class Samples:
    """One stream: signals by name at its own times.

    `time` (m,) [s] strictly increases; joint signals are (m, n) in the order of `joints`, others (m,) or (m, k).
    `present` (m, n) says which joints a message named; None: all of them. `receive` (m,) [s] is when the recorder got
    the messages. `source` names the stream in messages to the user.
    """

    source: str
    time: Array
    signals: dict[str, Array]
    joints: tuple[str, ...] = ()
    present: NDArray[np.bool_] | None = None
    receive: Array | None = None


@dataclass(frozen=True)
class Streams:
    """The streams of one recording on one origin of time; what was not asked for or not recorded is None. `files` are
    those that were read of a larger whole, `episode` which one of a data set, `dropped` the samples that are in the
    recording and not in the streams, `dated` whether the times are dates.
    """

    state: Samples | None = None
    command: Samples | None = None
    effort: Samples | None = None
    pose: Samples | None = None
    imu: Samples | None = None
    supply: Samples | None = None
    temperature: Samples | None = None
    notes: tuple[str, ...] = field(default=())
    dropped: tuple[Lack, ...] = field(default=())
    episode: int | None = None
    files: tuple[Path, ...] = field(default=())
    dated: bool = False

    def all(self) -> list[Samples]:
        """The streams that are there."""
        found = (self.state, self.command, self.effort, self.pose, self.imu, self.supply, self.temperature)
        return [s for s in found if s is not None]


@dataclass(frozen=True)
class Request:
    """What a scenario asks of a recording: `supply` is a topic or column, `base` whether a base pose is of use.

    `limits` are the lower and the upper one [rad] of joints that turn, by their names.
    """

    file: Path
    recordings: Recordings
    motion: Motion | None
    joints: tuple[str, ...]
    supply: str | None = None
    base: bool = True
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """What the recording calls the joints, in their order.

        Raises:
            InputError: for a pattern that matches no joint, or a name that two joints get.
        """
        return recorded_names(self.recordings.joints, self.joints, self.file)

    @property
    def effort_topic(self) -> str | None:
        """Topic or column of an effort that is not part of the state."""
        effort = self.recordings.effort
        return effort.topic if isinstance(effort, EffortStream) else None

    @property
    def command_signal(self) -> str:
        """The signal that holds the command."""
        return COMMAND_SIGNAL[self.motion.meaning if self.motion is not None else "position"]

    @property
    def command_factor(self) -> Array | None:
        """N·m (or N) per unit of a command that is the measured effort itself, shape (n,); None for other commands."""
        if self.motion is None or self.motion.meaning != "effort" or not isinstance(self.motion.recorded, str):
            return None
        state, columns = self.recordings.state, self.recordings.columns.effort
        source = self.effort_topic or (state.topic if isinstance(state, Stream) else state)
        named = {source, columns} if isinstance(columns, str) and self.effort_topic is None else {source}
        return self.effort_factor if self.motion.recorded in named else None

    @property
    def effort_factor(self) -> Array | None:
        """N·m (or N) per recorded unit of every joint, shape (n,); None where no effort was measured.

        Raises:
            InputError: for a pattern that matches no joint, or a joint that none matches.
        """
        effort = self.recordings.effort
        if isinstance(effort, EffortStream):
            return effort_factors(effort, self.joints, self.file)
        return None if effort == "none" else np.ones(len(self.joints))


def request_of(
    scenario: Scenario,
    joints: tuple[str, ...],
    file: Path,
    limits: Mapping[str, tuple[float, float]] | None = None,
) -> Request:
    """What a scenario asks of its recordings.

    Raises:
        InputError: where servos name two different recorded supplies, or commands in rpm are no velocities.
    """
    recordings = scenario.recordings or Recordings()
    servos = [s for s in scenario.servos if isinstance(s, DcServo)]
    named = {s.supply.recorded for s in servos if isinstance(s.supply, RecordedSupply)}
    if recordings.battery is not None:
        named.add(recordings.battery)
    if len(named) > 1:
        found = ", ".join(sorted(named))
        raise InputError(f"{file}: servos: the supply is recorded in {found}; expected one topic or column for all")
    told = recordings.columns.units.command
    if "rpm" in ([told] if isinstance(told, str) else told.values()):
        meaning = None if scenario.motion is None else scenario.motion.meaning
        if meaning not in (None, "velocity"):
            raise InputError(
                f"{file}: recordings.columns.units.command: found rpm of commands that are `as: {meaning}`; expected "
                "`as: velocity` in motion, or a unit of positions"
            )
    base = scenario.robot.base != "fixed"
    return Request(file, recordings, scenario.motion, joints, next(iter(named), None), base, limits or {})
