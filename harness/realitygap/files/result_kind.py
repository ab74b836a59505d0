"""Which commands' results a folder holds: told by the files of ours that they write."""

from pathlib import Path

from realitygap.files.errors import InputError
from realitygap.files.own_files import content
from realitygap.files.result_folder import FILES, MANIFEST

WRITTEN = {
    "run": (MANIFEST, FILES),
    "diagnose": ("diagnosis.json", "verdict"),
    "rehearse": ("rehearsal.json", "detection"),
    "propose": ("proposal.json", "motions"),
}
"""By command: a file that it writes, and a key of that; a matrix writes what a run does."""


def held_results(folder: Path) -> list[str]:
    """The commands whose results a folder holds."""
    return [command for command, (name, key) in WRITTEN.items() if key in content(folder / name)]


def held_scenario(folder: Path) -> str | None:
    """The name of the scenario or matrix whose results a folder holds; None where it holds none."""
    name = content(folder / MANIFEST).get("scenario")
    return name if isinstance(name, str) else None


def check_free(folder: Path, command: str, option: str = "--out") -> None:
    """Make sure that a folder holds no other command's result: each writes its own `report.html`.

    Raises:
        InputError: where it does.
    """
    others = [held for held in held_results(folder) if held != command]
    if others:
        raise InputError(
            f"{option}: {folder} holds the result of `{others[0]}`, whose report.html `{command}` would write over; "
            "expected another folder"
        )
