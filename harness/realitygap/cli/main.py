"""The command line. Engines and heavy libraries are imported when a command needs them."""

import os
import sys
import traceback
from collections.abc import Sequence
from typing import Annotated, NoReturn

import typer

from realitygap.cli.bench_commands import bench
from realitygap.cli.check_command import check
from realitygap.cli.diagnose_commands import diagnose, propose, rehearse
from realitygap.cli.robot_commands import audit, effects, engines, init
from realitygap.cli.run_commands import matrix, report, run
from realitygap.cli.schema_commands import schema
from realitygap.files.interrupted import Interrupted, interruption, listening

MOST = 400
"""Characters of a sentence, paths and lists of names included."""
COMMANDS = (engines, init, check, run, matrix, audit, report, diagnose, rehearse, propose, effects, schema)
"""In the order in which they are listed; each tells itself by its docstring."""

app = typer.Typer(
    name="realitygap",
    help="One scenario through many physics engines, compared with recordings of the real robot.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["--help", "-h"]},
)

for command in COMMANDS:
    app.command()(command)
app.add_typer(bench, name="bench")


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"realitygap {version('realitygap')}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="show the version and exit")
    ] = False,
) -> None:
    """One scenario through many physics engines, compared with recordings of the real robot."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point: bad input is one sentence on standard error. Every error has status 2; 1 is a failed check."""
    # no command draws in MuJoCo, whose import otherwise starts another interpreter that looks for a window system
    os.environ.setdefault("MUJOCO_GL", "disable")
    try:
        with listening():
            app(arguments)
    except Interrupted as end:
        _end(end)
    except Exception as error:
        if (came := interruption()) is not None:
            _end(came)
        _tell(error)


def _tell(error: Exception) -> NoReturn:
    if isinstance(error, OSError):  # a folder that cannot be written, a full disk
        _fail(f"{error.filename or 'output'}: {error.strerror or error}")
    if isinstance(error, MemoryError):
        _fail(f"the memory does not suffice ({error}); expected a lower physics.step_rate, or fewer cells at once")
    from realitygap_engines import RealityGapError  # imported here, because `--help` is to be quick

    if not isinstance(error, RealityGapError):
        traceback.print_exception(error)
        raise SystemExit(2) from None
    _fail(str(error))


def _end(end: Interrupted) -> NoReturn:
    """Leave at once: an engine whose import was cut short may bring down an interpreter that ends in order."""
    typer.echo(f"realitygap: {end}", err=True)
    sys.stdout.flush()
    os._exit(end.status)


def _fail(sentence: str) -> NoReturn:
    from realitygap_engines.errors import in_a_line

    typer.echo(f"realitygap: {in_a_line(sentence, MOST)}", err=True)
    raise SystemExit(2) from None


if __name__ == "__main__":
    main()
