"""What commands share: options with one meaning, the folder to write to, and what is said."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

Engines = Annotated[list[str] | None, typer.Option("--engine", "-e", help="engine; may be repeated (default: all)")]
Out = Annotated[Path | None, typer.Option("--out", "-o", help="result folder")]
MaxGap = Annotated[
    list[str] | None,
    typer.Option(
        "--max-gap",
        help="SIGNAL=VALUE: exit with 1 where the mean gap of moving joints is larger (°, °/s, N·m); may be repeated",
    ),
]
Junit = Annotated[Path | None, typer.Option("--junit", help="write JUnit XML: every cell is a test")]
Jobs = Annotated[int | None, typer.Option("--jobs", "-j", min=1, help="worker processes (default: one per core)")]


def folder_for(out: Path | None, name: str = "") -> Path:
    """The folder to write to, checked before the work: `--out`, or one below results/runs."""
    from realitygap.files.whole import check_writable

    folder = out or Path("results/runs") / name
    check_writable(folder)
    return folder


@contextmanager
def interruptible(left: str) -> Iterator[None]:
    """Ctrl-C ends the command with the status that shells give it, and a sentence on what it leaves behind."""
    try:
        yield
    except KeyboardInterrupt:
        typer.echo(f"realitygap: interrupted; {left}", err=True)
        raise typer.Exit(130) from None


def say(lines: Iterable[str]) -> None:
    """Lines on standard output."""
    for line in lines:
        typer.echo(line)
