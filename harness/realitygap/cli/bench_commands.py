"""Commands that identify servos, supplies, links and ground on the bench."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from realitygap.cli.options import Jobs, Out, file_argument, folder_for, helped, named_after, say

if TYPE_CHECKING:
    from realitygap.bench.summary import Summary

Bench = Annotated[Path, file_argument("the bench file")]

bench = typer.Typer(
    help="Identify servos, supplies, links and ground on the bench.",
    callback=helped,
    invoke_without_command=True,
    rich_markup_mode=None,
)


@bench.command()
def servo(file: Bench, out: Out = None) -> None:
    """Identify servos: torque, speed, constants, friction.

    From load sweeps, static friction and recordings, beside the data sheet.
    """
    from realitygap.bench.servo import run as procedure

    _do(procedure, file, out)


@bench.command()
def supply(file: Bench, out: Out = None) -> None:
    """Find how far a supply sags under current.

    And what that costs in torque and speed; written as an effect for the scenario.
    """
    from realitygap.bench.supply import run as procedure

    _do(procedure, file, out)


@bench.command()
def links(file: Bench, out: Out = None) -> None:
    """Check the links of a URDF against the scales.

    Masses and centres of mass as weighed and balanced; writes the corrected URDF.
    """
    from realitygap.bench.links import run as procedure

    _do(procedure, file, out)


@bench.command()
def ground(file: Bench, out: Out = None, jobs: Jobs = None) -> None:
    """Find friction and compliance of the ground from tosses.

    Fitted in every engine on tosses for training, judged on those held out.
    """
    from realitygap.bench.ground import run as procedure
    from realitygap.files.progress import Progress

    _do(lambda bench, folder: procedure(bench, folder, Progress(), jobs), file, out)


def _do(procedure: Callable[[Path, Path], Summary], file: Path, out: Path | None) -> None:
    """Follow a procedure, write its page and print what was found; interrupted, the folder stays as it was."""
    from realitygap.bench.page import write_page
    from realitygap.files.result_folder import written_whole

    folder = folder_for(out, named_after(file), "bench")
    with written_whole(folder) as aside:
        summary = procedure(file, aside)
        page = write_page(summary, f"{file.resolve().parent.name} {file.stem}", aside)
    written = [folder / path.relative_to(aside) for path in summary.files]
    say([*summary.lines, *(f"wrote {path}" for path in written), f"report: {folder / page.name}"])
