"""Which of the files that people write one is, where another was wanted: the command for it is told."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from realitygap.files.errors import InputError
from realitygap.files.unpacked import plain_name


@dataclass(frozen=True)
class _Kind:
    """A kind of file: keys of its top that no other kind has, and the command that takes it."""

    keys: tuple[str, ...]
    command: str


KINDS = {
    "a scenario": _Kind(("robot",), "run"),
    "a matrix": _Kind(("scenarios", "axes"), "matrix"),
    "a bench of servos": _Kind(("torque_speed", "static_friction", "regression"), "bench servo"),
    "a bench of a supply": _Kind(("chains",), "bench supply"),
    "a bench of links": _Kind(("masses", "centers", "parts"), "bench links"),
    "a bench of a ground": _Kind(("scenario", "tosses"), "bench ground"),
}
ROBOTS = (".urdf", ".xacro", ".sdf", ".xml")
RECORDINGS = (".bag", ".csv", ".db3", ".mcap", ".parquet", ".tsv")


def check_kind(path: Path, wanted: str, raw: Mapping[str, Any]) -> None:
    """Make sure that a file is not plainly one of another kind; whatever else is wrong is for its schema to tell.

    Args:
        path: the file.
        wanted: what it should be, of `KINDS`.
        raw: what it holds.

    Raises:
        InputError: for a file that has the keys of another kind and none of this one.
    """
    if any(key in raw for key in KINDS[wanted].keys):
        return
    for name, kind in KINDS.items():
        key = next((key for key in kind.keys if key in raw), None)
        if key is not None:
            raise InputError(
                f"{path}: is {name}, by its key {key}; expected {wanted}, with {' or '.join(KINDS[wanted].keys)}: "
                f"{name} is for `realitygap {kind.command} {path}`"
            )


def check_scenario_name(path: Path) -> None:
    """Make sure that a file is not plainly the robot's or a recording, and no folder.

    Raises:
        InputError: for one that is, by its name.
    """
    if path.is_dir():
        files = sorted(path.glob("*.y*ml"))
        there = f"as {files[0]}" if files else f"which `realitygap init ROBOT RECORDING --out {path}` writes"
        raise InputError(f"{path}: is a folder; expected a scenario file, {there}")
    suffix = plain_name(path).suffix.lower()
    what = "a robot's file" if suffix in ROBOTS else "a recording" if suffix in RECORDINGS else None
    if what is not None and path.is_file():
        raise InputError(
            f"{path}: is {what}; expected a scenario in YAML: `realitygap init ROBOT RECORDING` writes a first one"
        )
