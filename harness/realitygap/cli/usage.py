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
    parts = error.format_message().rstrip(".").split(". ")
    return f"{'; '.join(part[0].lower() + part[1:] for part in parts)} (--help tells what is expected)"
