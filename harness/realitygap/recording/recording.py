"""A recording of a real robot in the harness's terms."""

from dataclasses import dataclass, field
from pathlib import Path

from realitygap.files.unpacked import plain_name
from realitygap.recording.lack import Lack
from realitygap.recording.outliers import Outlier
from realitygap.trace.trace import Array, Trace


@dataclass(frozen=True)
class Recording:
    """What was measured, on the clock of the joint states, and the commands at their own times.

    Time 0 is the recording's first message of any stream that is used.

    Attributes:
        path: the bag, bag folder, table or data set.
        trace: the measured signals on the clock of the joint states (of the base pose where there are no joints), with
            the command that was in force. Effort in N·m or N. A signal from another stream is interpolated to this
            clock, and NaN before that stream begins and after it ends.
        command_time: Shape (m,), strictly increasing [s]; empty where no command was recorded.
        command: Shape (m, n), held from its time until the next; NaN where the servo gives no torque.
        command_kind: what a command is: `position`, `duty` or `effort`; None where none was recorded.
        supply_time: Shape (k,) [s]; empty where no supply was recorded.
        supply: Shape (k,) [V].
        receive_time: Shape (t,) [s], when the recorder got the samples of the trace; None for tables.
        notes: sentences on what was found and decided while reading.
        outliers: readings that no motion explains, and that are not in the trace any more.
        episode: which one of a data set.
        files: what was read, where that is not all of the path.
        absent: the samples and readings that are absent or were dropped, and what else is not as it should be; notes
            tell them, too.
        dated: whether its times are dates, which are in no unit.
    """

    path: Path
    trace: Trace
    command_time: Array
    command: Array
    command_kind: str | None
    supply_time: Array
    supply: Array
    receive_time: Array | None = None
    notes: tuple[str, ...] = field(default=())
    outliers: tuple[Outlier, ...] = field(default=())
    episode: int | None = None
    files: tuple[Path, ...] = field(default=())
    absent: tuple[Lack, ...] = field(default=())
    dated: bool = False

    @property
    def source(self) -> tuple[Path, int | None]:
        """Where it came from: equal for two uses of the same recording."""
        return self.path, self.episode

    def __repr__(self) -> str:
        told = f", {len(self.command_time)} commands ({self.command_kind})" if len(self.command_time) else ""
        return f"<Recording {self.name}: {self.trace!r}{told}>"

    @property
    def place(self) -> str:
        """Where it lies, for messages to the user: the path, and the episode of a data set."""
        return str(self.path) if self.episode is None else f"{self.path}: episode {self.episode}"

    @property
    def name(self) -> str:
        """The recording's name: that of its file or folder, without suffix."""
        return self.path.name if self.path.is_dir() else plain_name(self.path).stem
