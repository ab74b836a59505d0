"""What the parser of the command line refuses, as one sentence."""

import typer
from pydantic import ValidationError

from realitygap.files.validation import expectation


def sentence(error: typer.TyperException) -> str:
    """Of a value what was found and expected, as the commands say it of theirs; of all else the parser's own words."""
    cause = error.__cause__
    if isinstance(error, typer.BadParameter) and error.param is not None and isinstance(cause, ValidationError):
        worst = cause.errors(include_url=False)[0]
        return f"{error.param.opts[0]}: found {worst['input']}; {expectation(worst)}"
    context = getattr(error, "ctx", None)
    commands = getattr(context and context.command, "commands", None)
    parts = error.format_message().rstrip(".").split(". ")
    said = "; ".join(part[0].lower() + part[1:] for part in parts)
    if commands and said.startswith("no such command") and len(parts) == 1:  # nothing was meant that is alike
        return f"{said} (expected one of {', '.join(commands)})"
    return f"{said} (--help tells what is expected)"
