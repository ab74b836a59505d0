"""The command that helps editors."""

from typing import Annotated

import typer


def schema(name: Annotated[str, typer.Argument(help="scenario, matrix or bench")] = "scenario") -> None:
    """Print the JSON Schema of a file that people write.

    Of a scenario, a matrix or a bench: with it, editors complete keys and check them.
    """
    from realitygap.cli.schema_files import SCHEMA_FILES

    if name not in SCHEMA_FILES:
        from realitygap.files.errors import InputError, did_you_mean

        hint = did_you_mean(name, SCHEMA_FILES)
        raise InputError(f"schema: found {name}; expected one of {', '.join(SCHEMA_FILES)}{hint}")
    typer.echo(SCHEMA_FILES[name].read_text(encoding="utf-8"), nl=False)
