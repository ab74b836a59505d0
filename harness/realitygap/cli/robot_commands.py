"""Commands about engines, robots and effects: nothing here needs a motion but `init`."""

from pathlib import Path
from typing import Annotated

import typer

from realitygap.cli.options import Engines, file_argument, folder_for, out_option, say


def engines() -> None:
    """List the engines and what each can express."""
    from realitygap.cli.engines_table import engines_table

    typer.echo(engines_table())


def init(
    urdf: Annotated[Path, file_argument("the robot")],
    bags: Annotated[list[Path], file_argument("recordings: bags, tables, LeRobot data sets, or folders of them")],
    out: Annotated[Path, out_option("the one that one is in", "folder for the scenario")] = Path(),
    package: Annotated[
        list[str] | None, typer.Option("--package", help="NAME=DIR: where package://NAME/ lies; may be repeated")
    ] = None,
) -> None:
    """Write a first scenario from a URDF and recordings.

    With the topics, joints and runs that are found in them; every guess is marked as one.
    """
    from realitygap.init.draft import init as write
    from realitygap.init.draft import parse_packages

    say(write(urdf, bags, folder_for(out), parse_packages(package or [])).lines())


def audit(
    path: Annotated[Path | None, file_argument("a URDF or a scenario (default: test machines only)")] = None,
    engine: Engines = None,
    out: Annotated[Path | None, out_option("none, and nothing is written")] = None,
) -> None:
    """Certify that all engines run the same machine.

    Exits with 1 where they do not.
    """
    from realitygap.audit import audit as certify

    certificate = certify(path, engine or [], None if out is None else folder_for(out))
    typer.echo(certificate.text())
    if not certificate.passed:
        raise typer.Exit(1)


def effects(name: Annotated[str | None, typer.Argument(help="one effect")] = None) -> None:
    """List the effects, or explain one.

    Physics, equation, signature, and what it is confused with.
    """
    from realitygap.cli.effects_page import page, table

    typer.echo(page(name) if name else table())
