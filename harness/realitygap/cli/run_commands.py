"""Commands that simulate and compare: a scenario, a matrix, and the page again."""

from pathlib import Path
from typing import Annotated

import typer

from realitygap.cli.options import Engines, Junit, MaxGap, Out, file_argument, folder_for, named_after, say


def run(
    scenario: Annotated[Path, file_argument("the scenario file")],
    engine: Engines = None,
    out: Out = None,
    max_gap: MaxGap = None,
    junit: Junit = None,
    missing_effort: Annotated[
        bool, typer.Option("--missing-effort", help="also what the model lacks, as efforts, and what they depend on")
    ] = False,
    whole_traces: Annotated[
        bool, typer.Option("--whole-traces", help="every step in the traces, also where they are above 500 MB")
    ] = False,
) -> None:
    """Run one scenario in the engines.

    Writes traces (Parquet and MCAP), the gap table, figures and the page. Exits with 1 where a gap exceeds the budget
    that the scenario states; --max-gap replaces it for a signal.
    """
    from realitygap.cli import results
    from realitygap.compare.budget import parse_budget
    from realitygap.files.progress import Progress
    from realitygap.files.whole import check_writable_file

    budget = parse_budget(max_gap or [])
    if junit is not None:
        check_writable_file(junit, "--junit")
    folder = folder_for(out, named_after(scenario), "run")
    _judged(
        results.run(
            scenario, engine or [], folder, budget, junit, Progress(), missing=missing_effort, whole=whole_traces
        )
    )


def matrix(
    matrix: Annotated[Path, file_argument("the matrix file")],
    jobs: Annotated[int, typer.Option("--jobs", "-j", min=1, help="processes on this machine")] = 1,
    scheduler: Annotated[
        str | None, typer.Option("--scheduler", help="address of a Dask scheduler that computes the cells")
    ] = None,
    out: Out = None,
    cells: Annotated[
        str | None,
        typer.Option("--cells", help="where finished cells are kept: a folder or a URL (default: OUT/cells)"),
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="list the cells and estimate the time")] = False,
    max_gap: MaxGap = None,
    junit: Junit = None,
    retry_crashed: Annotated[
        bool, typer.Option("--retry-crashed", help="try cells again that crashed or took too long")
    ] = False,
) -> None:
    """Run all cells of a matrix.

    What is there already is not computed again.
    """
    from realitygap.cli import results
    from realitygap.compare.budget import parse_budget
    from realitygap.files.interrupted import leaving
    from realitygap.files.progress import Progress
    from realitygap.files.whole import check_writable_file
    from realitygap.matrix.matrix import Settings

    budget = parse_budget(max_gap or [])
    if junit is not None:
        check_writable_file(junit, "--junit")
    folder = folder_for(out, named_after(matrix), "run")
    settings = Settings(jobs, scheduler, cells, retry_crashed=retry_crashed)
    with leaving("cells that are done are kept, and the same command goes on from there"):
        if dry_run:
            said = results.listed(matrix, folder, settings)
        else:
            said = results.matrix(matrix, folder, settings, budget, junit, Progress())
    _judged(said)


def report(folder: Annotated[Path, file_argument("a folder that `run` or `matrix` wrote")]) -> None:
    """Make page and figures again from the results."""
    from realitygap.report import remake

    say([*remake(folder), f"report: {folder / 'report.html'}"])


def _judged(said: tuple[list[str], int]) -> None:
    """Print the lines of a command and end with its status."""
    lines, status = said
    say(lines)
    if status:
        raise typer.Exit(status)
