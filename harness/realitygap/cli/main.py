"""The command line. Engines and heavy libraries are imported when a command needs them."""

import os
import select
import signal
import sys
import traceback
from collections.abc import Sequence
from contextlib import suppress
from typing import Annotated, NoReturn

import typer
from typer.main import get_command

from realitygap.cli.bench_commands import bench
from realitygap.cli.check_command import check
from realitygap.cli.diagnose_commands import diagnose, propose, rehearse
from realitygap.cli.options import helped
from realitygap.cli.robot_commands import audit, effects, engines, init
from realitygap.cli.run_commands import matrix, report, run
from realitygap.cli.schema_commands import schema
from realitygap.files.interrupted import Interrupted, interruption, listening

MOST = 1000
"""Characters of a sentence, paths and lists of names included: all effects and quantities take 710."""
COMMANDS = (engines, init, check, run, matrix, audit, report, diagnose, rehearse, propose, effects, schema)
"""In the order in which they are listed; each tells itself by its docstring."""

app = typer.Typer(
    name="realitygap",
    help="One scenario through many physics engines, compared with recordings of the real robot.",
    add_completion=False,
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


@app.callback(invoke_without_command=True)
def options(
    context: typer.Context,
    _asked: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="show the version and exit")
    ] = False,
) -> None:
    """One scenario through many physics engines, compared with recordings of the real robot."""
    helped(context)


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point: bad input is one sentence on standard error. Every error has status 2; 1 is a failed check."""
    # no command draws in MuJoCo, whose import otherwise starts another interpreter that looks for a window system
    os.environ.setdefault("MUJOCO_GL", "disable")
    try:
        with listening():
            _follow(sys.argv[1:] if arguments is None else arguments)
    except Interrupted as end:
        _end(end)
    except Exception as error:
        if (came := interruption()) is not None:
            _end(came)
        _tell(error)


def _follow(arguments: Sequence[str]) -> NoReturn:
    """What typer does where it is called, but for its words and statuses: output that nobody reads has 1 there."""
    try:
        with get_command(app).make_context("realitygap", list(arguments)) as context:
            context.command.invoke(context)
    except typer.Exit as end:
        raise SystemExit(end.exit_code) from None
    raise SystemExit(0)


def _tell(error: Exception) -> NoReturn:
    if isinstance(error, BrokenPipeError) and _unread():
        os._exit(128 + signal.SIGPIPE)  # at once: what is still to be printed has nowhere to go
    if isinstance(error, typer.TyperException):
        from realitygap.cli.usage import sentence

        _fail(sentence(error))
    if isinstance(error, OSError):  # a folder that cannot be written, a full disk
        _fail(f"{error.filename or 'output'}: {error.strerror or error}")
    if isinstance(error, MemoryError):
        _fail(f"the memory does not suffice ({error}); expected a lower physics.step_rate, or fewer cells at once")
    from realitygap_engines import RealityGapError  # imported here, because `--help` is to be quick

    if not isinstance(error, RealityGapError):
        _say("".join(traceback.format_exception(error)).rstrip())
        raise SystemExit(2) from None
    _fail(str(error))


def _unread() -> bool:
    """Whether nobody reads what the command prints, as after `| head -1`: a pipe to a worker may break, too."""
    streams = select.poll()
    for descriptor in (1, 2):
        streams.register(descriptor, 0)
    return any(event & (select.POLLERR | select.POLLHUP) for _, event in streams.poll(0))


def _end(end: Interrupted) -> NoReturn:
    """Leave at once: an engine whose import was cut short may bring down an interpreter that ends in order."""
    with suppress(BrokenPipeError):
        typer.echo(f"realitygap: {end}", err=True)
        sys.stdout.flush()
    os._exit(end.status)


def _fail(sentence: str) -> NoReturn:
    from realitygap_engines.errors import in_a_line

    _say(f"realitygap: {in_a_line(sentence, MOST)}")
    raise SystemExit(2) from None


def _say(words: str) -> None:
    """What is wrong, where somebody reads it; an interpreter that ends in order tries again, with its own status."""
    try:
        typer.echo(words, err=True)
    except BrokenPipeError:
        os._exit(2)


if __name__ == "__main__":
    main()
