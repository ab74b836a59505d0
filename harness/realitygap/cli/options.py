"""What commands share: options with one meaning, the folder to write to, and what is said."""

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any

import typer

from realitygap.files.home import at_home

Engines = Annotated[list[str] | None, typer.Option("--engine", "-e", help="engine; may be repeated (default: all)")]


def named_folder(name: str) -> Path:
    """A folder that is named; an empty name, as of a shell variable that is not set, is not the one where one is."""
    if not name:
        raise typer.BadParameter("found an empty name, expected a folder")
    return at_home(name)


def named_file(name: str) -> Path:
    """A file that is named, likewise: an empty name would be the folder that one is in."""
    if not name:
        raise typer.BadParameter("found an empty name, expected a file; is a variable of the shell not set?")
    return at_home(name)


def file_argument(said: str) -> Any:
    """An argument that is a path."""
    return typer.Argument(help=said, parser=named_file)


def out_option(default: str, what: str = "result folder") -> Any:
    """The option `--out`; its default is said, as what is done without it is no value that typer could show."""
    said = f"{what} (default: {default})"
    return typer.Option("--out", "-o", help=said, parser=named_folder, metavar="<path>", show_default=False)


RUNS = "results/runs"
"""Where results go without `--out`, below the folder that one is in."""
Out = Annotated[Path | None, out_option(f"{RUNS}/NAME, after the file's folder")]
MaxGap = Annotated[
    list[str] | None,
    typer.Option(
        "--max-gap",
        help="SIGNAL=VALUE: exit with 1 where the mean gap of moving joints is larger (°, °/s, N·m); may be repeated",
    ),
]
Junit = Annotated[
    Path | None,
    typer.Option("--junit", help="write JUnit XML: every cell is a test", parser=named_file, metavar="<path>"),
]
Jobs = Annotated[int | None, typer.Option("--jobs", "-j", min=1, help="worker processes (default: one per core)")]


def folder_for(out: Path | None, name: str = "", command: str | None = None) -> Path:
    """The folder to write to, checked before the work: `--out`, or one below results/runs; with a `command`, also that
    it holds no manifest, table or page but of an earlier result of this one.

    What a command left there that was killed is removed, or, where it was whole, put in its place.
    """
    from realitygap.files.result_kind import check_free
    from realitygap.files.unfinished import sweep
    from realitygap.files.whole import check_writable

    folder = out or Path(RUNS) / name
    check_writable(folder)
    if command is not None:
        check_free(folder, command)
    sweep(folder)
    return folder


ALONE = ("scenario", "diagnosis")
"""Names of files that their folder is known by."""


def named_after(file: Path) -> str:
    """What results of a file are called: as its folder, and as itself where that could hold others beside it, so that
    two of a folder stay apart.
    """
    folder = file.resolve().parent.name
    return folder if file.stem in ALONE else f"{folder}_{file.stem}"


def say(lines: Iterable[str]) -> None:
    """Lines on standard output."""
    for line in lines:
        typer.echo(line)


def helped(context: typer.Context) -> None:
    """A group of commands that is called alone: its help on standard error, as for what is wrong."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help(), err=True)
        raise typer.Exit(2)
