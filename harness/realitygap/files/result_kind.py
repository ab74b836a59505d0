"""Which commands' results a folder holds: told by the files of ours that they write."""

from pathlib import Path
from shlex import join

from realitygap.files.errors import InputError
from realitygap.files.own_files import content
from realitygap.files.result_folder import FILES, MANIFEST, settle

WRITTEN = {
    "run": (MANIFEST, FILES),
    "diagnose": ("diagnosis.json", "verdict"),
    "rehearse": ("rehearsal.json", "detection"),
    "propose": ("proposal.json", "motions"),
}
"""By command: a file that it writes, and a key of that; a matrix writes what a run does."""
TABLES = {
    "run": ("gaps.csv", "timings.csv", "missing_effort.json", "missing_effort.yaml"),
    "rehearse": ("rehearsal.csv",),
}
"""By command: files that it writes beside that one."""
PAGE = "report.html"
TITLE = b"reality gap</title>"
"""How the title of every page of ours ends, near its beginning."""
HEAD = 4096
"""Bytes in which that stands."""


def held_results(folder: Path) -> list[str]:
    """The commands whose results a folder holds."""
    return [command for command, (name, key) in WRITTEN.items() if key in content(folder / name)]


def command_of(folder: Path, command: str) -> str:
    """What to type for the result of a command anew, in its folder: of the scenario and in the engines that it tells
    of, as far as it does.
    """
    told = content(folder / WRITTEN[command][0])
    file, engines = told.get("scenario_file"), told.get("engines")
    named = [e for engine in engines for e in ("--engine", str(engine))] if isinstance(engines, list) else []
    return join(["realitygap", command, str(file or "SCENARIO"), *named, "--out", str(folder)])


def held_scenario(folder: Path) -> str | None:
    """The name of the scenario or matrix whose results a folder holds; None where it holds none."""
    name = content(folder / MANIFEST).get("scenario")
    return name if isinstance(name, str) else None


def check_free(folder: Path, command: str, option: str = "--out") -> None:
    """Make sure that a folder holds nothing that a command would write over: no other command's result, as each writes
    its own page, and no manifest, table or page of somebody else's. What a killed run had on its way there is put in
    its place first, as it tells whose the files are.

    Raises:
        InputError: where it does.
    """
    settle(folder)
    others = [held for held in held_results(folder) if held != command]
    if others:
        raise InputError(
            f"{option}: {folder} holds the result of `{others[0]}`, whose {PAGE} `{command}` would write over; "
            "expected another folder"
        )
    foreign = _foreign(folder, command)
    if foreign:
        raise InputError(
            f"{option}: {folder} holds {', '.join(foreign)}, which no `{command}` has written and this one would write "
            "over; expected another folder"
        )


def _foreign(folder: Path, command: str) -> list[str]:
    """The files of somebody else's that have names of files which a command writes."""
    found = []
    if command in WRITTEN:
        name, key = WRITTEN[command]
        if key not in content(folder / name):
            found = [n for n in (name, *TABLES.get(command, ())) if (folder / n).exists()]
    page = folder / PAGE
    return [*found, PAGE] if page.exists() and not _our_page(page) else found


def _our_page(page: Path) -> bool:
    try:
        with page.open("rb") as file:
            return TITLE in file.read(HEAD)
    except OSError:
        return False
