"""The command line. Engines and heavy libraries are imported when a command needs them."""

import sys
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(
    name="realitygap",
    help="One scenario through many physics engines, compared with recordings of the real robot.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

Engines = Annotated[list[str] | None, typer.Option("--engine", "-e", help="engine; may be repeated (default: all)")]
Out = Annotated[Path | None, typer.Option("--out", "-o", help="result folder")]
MaxGap = Annotated[
    list[str] | None,
    typer.Option("--max-gap", help="SIGNAL=VALUE: exit with 1 where the mean gap of moving joints is larger"),
]


@app.command()
def engines() -> None:
    """List the engines: what is installed, its version, what it can and cannot express."""
    from harness.engines_table import engines_table

    print(engines_table())


@app.command()
def init(
    urdf: Annotated[Path, typer.Argument(help="the robot")],
    bags: Annotated[list[Path], typer.Argument(help="recordings: bags, bag folders or tables")],
    out: Annotated[Path, typer.Option("--out", "-o", help="folder for the scenario")] = Path(),
) -> None:
    """Write a first scenario from a URDF and recordings: topics, joints and runs found in them."""
    from harness.init import init as write

    print(f"wrote {write(urdf, bags, out)}")


@app.command()
def run(
    scenario: Annotated[Path, typer.Argument(help="the scenario file")],
    engine: Engines = None,
    out: Out = None,
    max_gap: MaxGap = None,
) -> None:
    """Run one scenario in the engines: traces (MCAP), gap table, figures, page."""
    from harness.budget import over_budget, parse_budget
    from harness.progress import Progress
    from harness.run import run as work
    from harness.run import summary

    budget = parse_budget(max_gap or [])
    folder = out or Path("results/runs") / scenario.resolve().parent.name
    result = work(scenario, engine or [], folder, Progress())
    for line in summary(result.gaps):
        print(line)
    excess = over_budget(result.gaps, budget)
    for line in excess:
        print(line)
    print(f"report: {result.page}")
    if excess:
        raise typer.Exit(1)


@app.command()
def matrix(
    matrix: Annotated[Path, typer.Argument(help="the matrix file")],
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
    junit: Annotated[Path | None, typer.Option("--junit", help="write JUnit XML: every cell is a test")] = None,
    retry_crashed: Annotated[
        bool, typer.Option("--retry-crashed", help="try cells again that crashed or took too long")
    ] = False,
) -> None:
    """Run all cells of a matrix; what is there already is not computed again."""
    from harness.budget import parse_budget
    from harness.matrix.command import listed, matrix_command
    from harness.matrix.matrix import Settings

    budget = parse_budget(max_gap or [])
    folder = out or Path("results/runs") / f"{matrix.resolve().parent.name}_{matrix.stem}"
    settings = Settings(jobs, scheduler, cells, retry_crashed)
    lines, status = (
        listed(matrix, folder, settings) if dry_run else matrix_command(matrix, folder, settings, budget, junit)
    )
    for line in lines:
        print(line)
    if status:
        raise typer.Exit(status)


@app.command()
def audit(
    path: Annotated[Path | None, typer.Argument(help="a URDF or a scenario (default: test machines only)")] = None,
    engine: Engines = None,
    out: Out = None,
) -> None:
    """Certify that the engines simulate the same machine; exits with 1 where they do not."""
    from harness.audit import audit as certify
    from harness.run import engine_names

    certificate = certify(path, engine_names(engine or []), out)
    print(certificate.text())
    if not certificate.passed:
        raise typer.Exit(1)


@app.command()
def report(folder: Annotated[Path, typer.Argument(help="a result folder")]) -> None:
    """Make the page again, from the results alone."""
    from harness.report import write_page

    print(f"report: {write_page(folder)}")


@app.command()
def diagnose(
    scenario: Annotated[Path, typer.Argument(help="the scenario file")],
    engine: Engines = None,
    out: Out = None,
    jobs: Annotated[int | None, typer.Option("--jobs", "-j", help="worker processes (default: one per core)")] = None,
) -> None:
    """Find where simulation and measurement disagree, name the missing effect, add it, prove it on held-out runs."""
    from harness.diagnose.workflow import run_diagnosis, summary
    from harness.progress import Progress

    folder = out or Path("results/runs") / f"{scenario.resolve().parent.name}_diagnosis"
    result = run_diagnosis(scenario, engine or [], folder, Progress(), jobs)
    for line in summary(result):
        print(line)
    print(f"diagnosis: {folder / 'diagnosis.json'}")
    print(f"report: {folder / 'report.html'}")


@app.command()
def effects(name: Annotated[str | None, typer.Argument(help="one effect")] = None) -> None:
    """List the effects, or tell about one: physics, equation, signature, what it is confused with."""
    from harness.effects.show import page, table

    print(page(name) if name else table())


def main() -> None:
    """Entry point: bad input is one sentence on standard error and exit status 2."""
    from engines.model import ModelError
    from harness.errors import InputError

    try:
        app()
    except (InputError, ModelError) as error:
        print(f"realitygap: {error}", file=sys.stderr)
        raise SystemExit(2) from None
    except KeyboardInterrupt:
        print("realitygap: stopped", file=sys.stderr)
        raise SystemExit(130) from None


if __name__ == "__main__":
    main()
