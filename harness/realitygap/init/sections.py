"""What a kind of recording contributes to a first scenario."""

import json
import os
from dataclasses import dataclass, field
from pathlib import Path

FOLLOWED = "motion: {followed: true}  # GUESS: no command was found, so the model has to explain the measured effort"
FOLLOWED_ASKED = (
    "motion: {followed: true}  # GUESS: efforts were both asked for and measured; or {recorded: command, as: effort}"
)
ASKED_AND_MEASURED = (
    "efforts were both asked for and measured: the measured motion is followed; `motion: {recorded: command, as: "
    "effort}` with servos of `kind: effort` plays back what was asked for"
)
NOTHING_DRIVES = "no {} of commands was found: without motion, nothing drives the joints"
AS_FOLLOWED = "no {} of commands was found: the measured motion is followed, and the effort that it takes is compared"


@dataclass(frozen=True)
class Sections:
    """Lines of a scenario file, and what they imply.

    Attributes:
        motion: the lines of `motion`.
        recordings: the lines below `recordings`, without the runs.
        runs: the lines below `runs`.
        meaning: what a recorded command is: position, velocity, duty or effort.
        moving_base: the stream that only a robot with a moving base has.
        robot: what the recording calls the robot.
        told: sentences for the terminal: what was seen and not used, and what is missing.
        followed: whether the measured motion is followed, for which there are no servos.
    """

    motion: list[str]
    recordings: list[str]
    runs: list[str]
    meaning: str = "position"
    moving_base: str | None = None
    robot: str = ""
    told: list[str] = field(default_factory=list)
    followed: bool = False


def runs_of(recordings: list[Path], out: Path) -> list[str]:
    """One run per file or folder."""
    return [f"    - {{path: {quoted(relative(path, out))}}}" for path in recordings]


def relative(path: Path, folder: Path) -> str:
    """A path as a scenario in a folder writes it; where a link leads to the folder, from where it leads."""
    return Path(os.path.relpath(path.parent.resolve() / path.name, folder.resolve())).as_posix()


def quoted(text: str) -> str:
    """Text as YAML writes it safely."""
    return json.dumps(text, ensure_ascii=False)
