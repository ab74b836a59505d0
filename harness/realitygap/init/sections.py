"""What a kind of recording contributes to a first scenario."""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from realitygap.init.measured_gains import Gains

Units = dict[str, str | dict[str, str]]
"""Units of a table's columns by signal, and where joints differ by joint."""


@dataclass(frozen=True)
class Motion:
    """What `motion` says, item by item as YAML writes them, and what is guessed of it; without items, a comment."""

    items: dict[str, str]
    guess: str = ""

    @property
    def line(self) -> str:
        """As it stands in a scenario."""
        if not self.items:
            return f"# {self.guess}"
        guess = f"  # GUESS: {self.guess}" if self.guess else ""
        return f"motion: {_flow(self.items)}{guess}"

    @property
    def holds(self) -> bool:
        """Whether recorded positions are told, and held until the next ones."""
        return "recorded" in self.items and not {"as", "held"} & self.items.keys()

    def between(self, why: str) -> "Motion":
        """The same with commands that are samples of a trajectory."""
        return Motion({**self.items, "held": "false"}, "; ".join(filter(None, (self.guess, why))))


FOLLOWED = Motion({"followed": "true"}, "no command was found, so the model has to explain the measured effort")
FOLLOWED_ASKED = Motion(
    {"followed": "true"}, "efforts were both asked for and measured; or {recorded: command, as: effort}"
)


def no_motion(kind: str) -> Motion:
    """Where no commands were found in a TOPIC, COLUMN or FEATURE."""
    return Motion(
        {}, f"No command was found: motion: {{recorded: {kind}}} or {{keyframes: FILE}} says what the servos are told."
    )


ASKED_AND_MEASURED = (
    "efforts were both asked for and measured: the measured motion is followed; `motion: {recorded: command, as: "
    "effort}` with servos of `kind: effort` plays back what was asked for"
)
NOTHING_DRIVES = "no {} of commands was found: without motion, nothing drives the joints"
AS_FOLLOWED = "no {} of commands was found: the measured motion is followed, and the effort that it takes is compared"
COMMANDS_BY = "a {} of commands is told by its name, which has one of {}"
CURRENT_LEFT_OUT = (
    "the {0} holds a current, which is not compared: `effort: {1}` under recordings takes it, where FACTOR is N·m per "
    "{2} at the joint (torque constant times gear ratio)"
)
CURRENT_GUESSED = (
    "the {0} holds a current: efforts mean nothing before recordings.effort.factor says N·m per {1} at the joint "
    "(torque constant times gear ratio), a number, or numbers by joint pattern; `fit` takes it from the robot's own "
    "weight, and a run refuses where that does not tell it"
)


def current_line(stream: str, unit: str, *, followed: bool) -> str:
    """The line of an effort that is a current: left out, since with a factor of 1 amperes would be compared with N·m,
    and told as a gap of the model. Of a motion that is followed nothing else is compared, so that one is guessed.
    """
    if followed:
        factor = "1.0" if unit == "A" else "0.001"
        return f"  effort: {{{stream}measures: motor, factor: {factor}}}  # GUESS: N·m per {unit} is nowhere stated"
    return f"  effort: none  # a current: {{{stream}measures: motor, factor: FACTOR}} with N·m per {unit} compares it"


def current_told(name: str, stream: str, unit: str, *, followed: bool) -> str:
    """What the terminal says of it."""
    if followed:
        return CURRENT_GUESSED.format(name, unit)
    return CURRENT_LEFT_OUT.format(name, f"{{{stream}measures: motor, factor: FACTOR}}", unit)


@dataclass(frozen=True)
class Sections:
    """Lines of a scenario file, and what they imply.

    Attributes:
        motion: what the servos are told.
        recordings: the lines below `recordings`, without the runs.
        runs: the lines below `runs`.
        meaning: what a recorded command is: position, velocity, duty or effort.
        moving_base: the stream that only a robot with a moving base has.
        robot: what the recording calls the robot.
        told: sentences for the terminal: what was seen and not used, and what is missing.
        followed: whether the measured motion is followed, for which there are no servos.
        columns: the lines below `recordings.columns`, without the units.
        units: of columns, where they are not SI, by signal and, where they differ, by joint; and how they were found.
        angles: the signals in angles whose unit no name says.
        gains: of servos, by joint, as far as measured efforts tell them.
        held: the joints that were not recorded.
        followers: joints that were not recorded, either, and mimic others.
        unmeasured: of these, the ones of which something else than a position was recorded, and in which columns or
            topics.
    """

    motion: Motion
    recordings: list[str]
    runs: list[str]
    meaning: str = "position"
    moving_base: str | None = None
    robot: str = ""
    told: list[str] = field(default_factory=list)
    followed: bool = False
    columns: list[str] = field(default_factory=list)
    units: Units = field(default_factory=dict)
    units_by: str = "as the names say"
    angles: tuple[str, ...] = ()
    gains: Mapping[str, Gains] = field(default_factory=dict)
    held: tuple[str, ...] = ()
    followers: tuple[str, ...] = ()
    unmeasured: dict[str, list[str]] = field(default_factory=dict)

    @property
    def unsure(self) -> list[str]:
        """What is to be said of joints that are held and may have moved."""
        return [
            f"{joint} is held where robot.hold says, as its position was not recorded, but it may have moved: it has "
            f"{', '.join(where)}; add its position, or check where it stood"
            for joint, where in self.unmeasured.items()
        ]

    @property
    def table(self) -> list[str]:
        """`recordings.columns` with its units; nothing where all of it is as a scenario expects by itself."""
        units = f"    units: {_flow(self.units)}  # {self.units_by}"
        lines = [*self.columns, *([units] if self.units else [])]
        return ["  columns:", *lines] if lines else []


def _flow(value: str | Mapping[str, str | dict[str, str]] | dict[str, str]) -> str:
    """A mapping on one line of YAML; words are bare, patterns over joints quoted."""
    if isinstance(value, str):
        return value
    return f"{{{', '.join(f'{k if k.isidentifier() else quoted(k)}: {_flow(v)}' for k, v in value.items())}}}"


def runs_of(recordings: list[Path], out: Path) -> list[str]:
    """One run per file or folder."""
    return [f"    - {{path: {quoted(relative(path, out))}}}" for path in recordings]


def relative(path: Path, folder: Path) -> str:
    """A path as a scenario in a folder writes it; where a link leads to the folder, from where it leads."""
    return Path(os.path.relpath(path.parent.resolve() / path.name, folder.resolve())).as_posix()


def quoted(text: str) -> str:
    """Text as YAML writes it safely."""
    return json.dumps(text, ensure_ascii=False)
