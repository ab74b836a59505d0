"""Commands that identify servos, supplies, links and ground on the bench."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from realitygap.cli.options import Jobs, Out, folder_for, say

if TYPE_CHECKING:
    from realitygap.bench.summary import Summary

Bench = Annotated[Path, typer.Argument(help="the bench file")]

bench = typer.Typer(
    help="Identify servos, supplies and links on the bench.", no_args_is_help=True, rich_markup_mode=None
)


@bench.command()
def servo(file: Bench, out: Out = None) -> None:
    """Identify servos: torque, speed, constants, friction.

    From load sweeps, static friction and recordings, beside the data sheet.
    """
    from realitygap.bench.servo import run as procedure

    folder = _bench_folder(file, out)
    _tell(file, folder, procedure(file, folder))


@bench.command()
def supply(file: Bench, out: Out = None) -> None:
    """Find how far a supply sags under current.

    And what that costs in torque and speed; written as an effect for the scenario.
    """
    from realitygap.bench.supply import run as procedure

    folder = _bench_folder(file, out)
    _tell(file, folder, procedure(file, folder))


@bench.command()
def links(file: Bench, out: Out = None) -> None:
    """Check the links of a URDF against the scales.

    Masses and centres of mass as weighed and balanced; writes the corrected URDF.
    """
    from realitygap.bench.links import run as procedure

    folder = _bench_folder(file, out)
    _tell(file, folder, procedure(file, folder))


@bench.command()
def ground(file: Bench, out: Out = None, jobs: Jobs = None) -> None:
    """Find friction and compliance of the ground from tosses.

    Fitted in every engine on tosses for training, judged on those held out.
    """
    from realitygap.bench.ground import run as procedure
    from realitygap.files.progress import Progress

    folder = _bench_folder(file, out)
    _tell(file, folder, procedure(file, folder, Progress(), jobs))


def _tell(file: Path, out: Path, summary: Summary) -> None:
    """Print what was found and write its page."""
    from realitygap.bench.page import write_page

    page = write_page(summary, f"{file.resolve().parent.name} {file.stem}", out)
    say([*summary.lines, *(f"wrote {written}" for written in summary.files), f"report: {page}"])


def _bench_folder(file: Path, out: Path | None) -> Path:
    return folder_for(out, f"{file.resolve().parent.name}_{file.stem}")
