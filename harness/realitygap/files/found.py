"""What stands in a file, in the words of a person who writes one: no word of Python."""

KINDS = {bool: "true or false", int: "a number", float: "a number", str: "text", list: "a list", dict: "a mapping"}
"""Types that YAML and JSON have, and what people call them."""
LONGEST = 80
"""Characters of a value that a sentence has room for."""


def kind_of(value: object) -> str:
    """What kind of value was found."""
    return "nothing" if value is None else KINDS.get(type(value), "something else")


def shown(value: object) -> str:
    """A value as it is written, not longer than a sentence bears."""
    text = _written(value)
    return text if len(text) < LONGEST else f"{text[: LONGEST - 3]}..."


def counted(count: int, noun: str) -> str:
    """How many of something there are: `1 sample`, `2 samples`."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def part_of(count: int, all_: int, noun: str) -> str:
    """How many of all there are: `1 of 2 cells`, `its only cell`."""
    return f"its only {noun}" if all_ == 1 else f"{count} of {counted(all_, noun)}"


def _written(value: object) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_written, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{k}: {_written(v)}' for k, v in value.items())}}}"
    return repr(value)
