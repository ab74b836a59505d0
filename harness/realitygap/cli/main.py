"""The command line. Engines and heavy libraries are imported when a command needs them."""

from __future__ import annotations

import traceback
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

if TYPE_CHECKING:
    from realitygap.bench.summary import Summary

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
    typer.Option(
        "--max-gap",
        help="SIGNAL=VALUE: exit with 1 where the mean gap of moving joints is larger (°, °/s, N·m); may be repeated",
    ),
]
Junit = Annotated[Path | None, typer.Option("--junit", help="write JUnit XML: every cell is a test")]
Jobs = Annotated[int | None, typer.Option("--jobs", "-j", min=1, help="worker processes (default: one per core)")]
Bench = Annotated[Path, typer.Argument(help="the bench file")]


def _folder(out: Path | None, name: str = "") -> Path:
    """The folder to write to, checked before the work: `--out`, or one below results/runs."""
    from realitygap.files.whole import check_writable

    folder = out or Path("results/runs") / name
    check_writable(folder)
    return folder


@contextmanager
def _interruptible(left: str) -> Iterator[None]:
    """Ctrl-C ends the command with the status that shells give it, and a sentence on what it leaves behind."""
    try:
        yield
    except KeyboardInterrupt:
        typer.echo(f"realitygap: interrupted; {left}", err=True)
        raise typer.Exit(130) from None


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"realitygap {version('realitygap')}")
        raise typer.Exit


def _say(lines: Iterable[str]) -> None:
    for line in lines:
        typer.echo(line)


def _judged(said: tuple[list[str], int]) -> None:
    """Print the lines of a command and end with its status."""
    lines, status = said
    _say(lines)
    if status:
        raise typer.Exit(status)


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="show the version and exit")
    ] = False,
) -> None:
    """One scenario through many physics engines, compared with recordings of the real robot."""


@app.command()
def engines() -> None:
    """List the engines and what each can express."""
    from realitygap.cli.engines_table import engines_table

    typer.echo(engines_table())


@app.command()
def init(
    urdf: Annotated[Path, typer.Argument(help="the robot")],
    bags: Annotated[list[Path], typer.Argument(help="recordings: bags, bag folders or tables")],
    out: Annotated[Path, typer.Option("--out", "-o", help="folder for the scenario")] = Path(),
) -> None:
    """Write a first scenario from a URDF and recordings.

    With the topics, joints and runs that are found in them; every guess is marked as one.
    """
    from realitygap.init.draft import init as write

    typer.echo(f"wrote {write(urdf, bags, _folder(out))}")


@app.command()
def run(
    scenario: Annotated[Path, typer.Argument(help="the scenario file")],
    engine: Engines = None,
    out: Out = None,
    max_gap: MaxGap = None,
    junit: Junit = None,
) -> None:
    """Run one scenario in the engines.

    Writes traces (Parquet and MCAP), the gap table, figures and the page. Exits with 1 where a gap exceeds the budget
    that the scenario states; --max-gap replaces it for a signal.
    """
    from realitygap.cli import results
    from realitygap.compare.budget import parse_budget
    from realitygap.files.progress import Progress
    from realitygap.files.whole import check_writable

    budget = parse_budget(max_gap or [])
    if junit is not None:
        check_writable(junit.parent, "--junit")
    folder = _folder(out, scenario.resolve().parent.name)
    with _interruptible("nothing was written"):
        said = results.run(scenario, engine or [], folder, budget, junit, Progress())
    _judged(said)


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
    from realitygap.files.progress import Progress
    from realitygap.files.whole import check_writable
    from realitygap.matrix.matrix import Settings

    budget = parse_budget(max_gap or [])
    if junit is not None:
        check_writable(junit.parent, "--junit")
    folder = _folder(out, f"{matrix.resolve().parent.name}_{matrix.stem}")
    settings = Settings(jobs, scheduler, cells, retry_crashed=retry_crashed)
    with _interruptible("cells that are done are kept, and the same command goes on from there"):
        if dry_run:
            said = results.listed(matrix, folder, settings)
        else:
            said = results.matrix(matrix, folder, settings, budget, junit, Progress())
    _judged(said)


@app.command()
def audit(
    path: Annotated[Path | None, typer.Argument(help="a URDF or a scenario (default: test machines only)")] = None,
    engine: Engines = None,
    out: Out = None,
) -> None:
    """Certify that all engines run the same machine.

    Exits with 1 where they do not.
    """
    from realitygap.audit import audit as certify

    certificate = certify(path, engine or [], None if out is None else _folder(out))
    typer.echo(certificate.text())
    if not certificate.passed:
        raise typer.Exit(1)


@app.command()
def report(folder: Annotated[Path, typer.Argument(help="a result folder")]) -> None:
    """Make page and figures again from the results."""
    from realitygap.report import write_report

    typer.echo(f"report: {write_report(folder)}")


@app.command()
def diagnose(
    scenario: Annotated[Path, typer.Argument(help="the scenario file")],
    engine: Engines = None,
    out: Out = None,
    jobs: Jobs = None,
) -> None:
    """Find what a model lacks, add it, prove that it helps.

    Where simulation and measurement disagree, which effect explains it, and the gap on held-out runs.
    """
    from realitygap.diagnose.result.workflow import run_diagnosis, summary
    from realitygap.files.progress import Progress

    folder = _folder(out, f"{scenario.resolve().parent.name}_diagnosis")
    result = run_diagnosis(scenario, engine or [], folder, Progress(), jobs)
    _say([*summary(result), f"diagnosis: {folder / 'diagnosis.json'}", f"report: {folder / 'report.html'}"])


@app.command()
def rehearse(
    scenario: Annotated[Path, typer.Argument(help="the scenario file")],
    engine: Engines = None,
    out: Out = None,
    budget: Annotated[float, typer.Option("--budget", help="seconds that it may take, about")] = 300.0,
    jobs: Jobs = None,
) -> None:
    """Say which effects recordings could reveal.

    Each effect is planted in the scenario's own motions: from which size on it is seen, and what it is taken for.
    """
    from realitygap.diagnose.rehearse.files import summary
    from realitygap.diagnose.rehearse.rehearse import run_rehearsal
    from realitygap.files.progress import Progress

    folder = _folder(out, f"{scenario.resolve().parent.name}_rehearsal")
    result = run_rehearsal(scenario, engine or [], folder, Progress(), budget, jobs)
    _say([*summary(result), f"rehearsal: {folder / 'rehearsal.json'}", f"report: {folder / 'report.html'}"])


@app.command()
def effects(name: Annotated[str | None, typer.Argument(help="one effect")] = None) -> None:
    """List the effects, or explain one.

    Physics, equation, signature, and what it is confused with.
    """
    from realitygap.cli.effects_page import page, table

    typer.echo(page(name) if name else table())


bench = typer.Typer(
    help="Identify servos, supplies and links on the bench.", no_args_is_help=True, rich_markup_mode=None
)
app.add_typer(bench, name="bench")


@bench.command()
def servo(file: Bench, out: Out = None) -> None:
    """Identify servos: torque, speed, constants, friction.

    From load sweeps, static friction and recordings, beside the data sheet.
    """
    from realitygap.bench.servo import run as procedure

    _tell(procedure(file, _bench_folder(file, out)))


@bench.command()
def supply(file: Bench, out: Out = None) -> None:
    """Find how far a supply sags under current.

    And what that costs in torque and speed; written as an effect for the scenario.
    """
    from realitygap.bench.supply import run as procedure

    _tell(procedure(file, _bench_folder(file, out)))


@bench.command()
def links(file: Bench, out: Out = None) -> None:
    """Check the links of a URDF against the scales.

    Masses and centres of mass as weighed and balanced; writes the corrected URDF.
    """
    from realitygap.bench.links import run as procedure

    _tell(procedure(file, _bench_folder(file, out)))


@bench.command()
def ground(file: Bench, out: Out = None, jobs: Jobs = None) -> None:
    """Find friction and compliance of the ground from tosses.

    Fitted in every engine on tosses for training, judged on those held out.
    """
    from realitygap.bench.ground import run as procedure
    from realitygap.files.progress import Progress

    _tell(procedure(file, _bench_folder(file, out), Progress(), jobs))


def _bench_folder(file: Path, out: Path | None) -> Path:
    return _folder(out, f"{file.resolve().parent.name}_{file.stem}")


def _tell(summary: Summary) -> None:
    _say([*summary.lines, *(f"wrote {file}" for file in summary.files)])


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point: bad input is one sentence on standard error. Every error has status 2; 1 is a failed check."""
    try:
        app(arguments)
    except OSError as error:  # a folder that cannot be written, a full disk
        _fail(f"{error.filename or 'output'}: {error.strerror or error}")
    except MemoryError as error:
        _fail(f"the memory does not suffice ({error}); expected a lower physics.step_rate, or fewer cells at once")
    except Exception as error:
        from realitygap_engines.model.robot import ModelError  # imported here, because `--help` is to be quick

        from realitygap.files.errors import InputError

        if not isinstance(error, InputError | ModelError):
            traceback.print_exc()
            raise SystemExit(2) from None
        _fail(str(error))


def _fail(sentence: str) -> NoReturn:
    typer.echo(f"realitygap: {sentence}", err=True)
    raise SystemExit(2) from None


if __name__ == "__main__":
    main()
