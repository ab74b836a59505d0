"""Checking data against its schema; the first thing that is wrong becomes one sentence."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails
from realitygap_engines.errors import in_a_line

from realitygap.files.errors import InputError, did_you_mean
from realitygap.files.found import shown

Checked = TypeVar("Checked", bound=BaseModel)
Key = int | str
LONGEST = 120
"""Characters of a key that a sentence has room for."""
WORDS = {
    "a valid dictionary or object to extract fields from": "a mapping",
    "a valid dictionary": "a mapping",
    "a valid list": "a list",
    "a valid tuple": "a list of numbers",
    "a valid string": "text",
    "a valid number": "a number",
    "a valid integer": "a whole number",
    "a valid boolean": "true or false",
}
"""What pydantic says, in the words of a YAML file."""
COUNTED = re.compile(r"\w+ should have at (least|most) (\d+ \w+) after validation, not \d+")
UNPARSED = re.compile(r", unable to (parse string as an? \w+|interpret input)$")
SIMPLE = ("bool", "int", "float")
NUMBERS = ("int", "float")
COMMA = re.compile(r"[-+]?\d*,\d+")
"""A number with a decimal comma."""
QUOTED = re.compile(r"'([^']+)'")
INSTANCE = re.compile(r"(?<=a mapping) or instance of \w+")


def validate(path: Path | str, model: type[Checked], raw: Any) -> Checked:
    """Checked data; the path may go on with a key, where they are a part of a file.

    Raises:
        InputError: one sentence with the file, the key, what was found and what was expected.
    """
    try:
        return model.model_validate(raw)
    except ValidationError as error:
        # of several tries at a union, the one that got deepest is what was meant
        errors = error.errors(include_url=False)
        worst = max(errors, key=_depth)
        beside = [e for e in errors if e["loc"][:-1] == worst["loc"][:-1] and e is not worst]
        raise InputError(f"{path}: {_sentence(model, raw, worst, beside)}") from None


def _sentence(model: type[BaseModel], raw: dict[str, Any], error: ErrorDetails, beside: Sequence[ErrorDetails]) -> str:
    loc, kind, found = error["loc"], error["type"], error["input"]
    key = in_a_line(_key(raw, loc), LONGEST)
    if kind == "extra_forbidden":
        known = sorted(_fields(_sections_at(model, loc[:-1])))
        elsewhere = _elsewhere(model, loc)
        told = f"{key}: unknown key{elsewhere}"
        for type_, words in (("extra_forbidden", "unknown too"), ("missing", "missing")):
            if names := [str(e["loc"][-1]) for e in beside if e["type"] == type_]:
                told += f"; {words}: {', '.join(names)}"
        hint = "" if elsewhere else did_you_mean(str(loc[-1]), known)
        return f"{told}; known here: {', '.join(known)}{hint}"
    if kind == "missing":
        return f"{key}: is missing; expected {_meaning(model, loc) or 'a value'}"
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        chosen = found.get("kind") if isinstance(found, dict) else found
        expected = [tag for section in _sections_at(model, loc) if (tag := _tag(section))]
        return (
            f"{key}.kind: found {shown(chosen)}; expected one of {', '.join(expected)}{did_you_mean(chosen, expected)}"
        )
    if kind == "invalid_key":
        return f"{key or 'its top'}: found the key {shown(found)}, expected text"
    at = f"{key}: " if key else ""  # all of what is read
    said = f"{at}found {shown(found)}; {expectation(error)}{_others(error, beside)}{_example(model, error)}"
    if kind == "literal_error":
        return said + did_you_mean(found, QUOTED.findall(error["ctx"]["expected"]))
    meaning = None if kind == "value_error" else _meaning(model, loc)
    return said + (f" ({meaning})" if meaning else "")


def _elsewhere(model: type[BaseModel], loc: Sequence[Key]) -> str:
    """Of a key that another kind of section has: of which kind this one is, and of which kinds the key is."""
    own = [tag for section in _sections_at(model, loc[:-1]) if (tag := _tag(section))]
    others = [_tag(s) for s in _sections_at(model, loc[:-2]) if loc[-1] in _fields([s])]
    theirs = [tag for tag in others if tag and tag not in own]
    return f" of kind {own[0]}, which belongs to kind {' or '.join(theirs)}" if own and theirs else ""


def expectation(error: ErrorDetails) -> str:
    """What pydantic expected of a value, in the words of a YAML file."""
    message = error["msg"].removeprefix("Value error, ").replace("Input should be", "expected")
    for long, short in WORDS.items():
        message = message.replace(long, short)
    message = UNPARSED.sub("", INSTANCE.sub("", COUNTED.sub(r"expected at \1 \2", message)))
    return message[0].lower() + message[1:]


def _others(error: ErrorDetails, beside: Sequence[ErrorDetails]) -> str:
    """What else than a word the same place takes, as true or false; what a choice of sections takes is too much."""
    taken = [expectation(e).removeprefix("expected ") for e in beside if e["type"].startswith(SIMPLE)]
    return "".join(f" or {other}" for other in taken) if error["type"] == "literal_error" else ""


def _example(model: type[BaseModel], error: ErrorDetails) -> str:
    """Of a text in the place of a section, the section whose first key it is; of a number, how it is written."""
    found = error["input"]
    if not isinstance(found, str):
        return ""
    if error["type"].startswith("model") and len(sections := _sections_at(model, error["loc"])) == 1:
        name, field = next(iter(_fields(sections).items()))
        return f", as {{{name}: {found}}}" if str in (field.annotation, *get_args(field.annotation)) else ""
    if error["type"].startswith(NUMBERS) and COMMA.fullmatch(found.strip()):
        return f", as {found.strip().replace(',', '.')}"
    return ""


def _depth(error: ErrorDetails) -> tuple[bool, int, bool]:
    """How close one of several complaints about a union is to what the writer meant."""
    named = error["type"] == "literal_error" and isinstance(error["input"], str)
    return error["type"] == "extra_forbidden", len(error["loc"]), named


def _key(raw: Any, loc: Sequence[Key]) -> str:
    """The key as a person wrote it: parts of a location that are not in the data name a choice of the schema."""
    out = ""
    for i, part in enumerate(loc):
        inside = isinstance(raw, list) if isinstance(part, int) else isinstance(raw, dict)
        if inside and (part < len(raw) if isinstance(part, int) else part in raw):
            raw = raw[part]
        elif i < len(loc) - 1 or not inside:
            continue
        out += f"[{part}]" if isinstance(part, int) else f".{part}" if out else part
    return out


def _sections_at(model: type[BaseModel], loc: Sequence[Key]) -> list[type[BaseModel]]:
    """The sections of the schema that may stand at a location."""
    sections = [model]
    for part in loc:
        if isinstance(part, int):
            continue
        chosen = [s for s in sections if part in (s.__name__, _tag(s))]
        field = _fields(sections).get(part)
        if chosen:
            sections = chosen
        elif field is not None:
            sections = _sections(field.annotation)
    return sections


def _meaning(model: type[BaseModel], loc: Sequence[Key]) -> str | None:
    names = [part for part in loc if isinstance(part, str)]
    for i in range(len(names), 0, -1):  # the last names may be choices of a union
        field = _fields(_sections_at(model, names[: i - 1])).get(names[i - 1])
        if field is not None:
            return field.description
    return None


def _fields(sections: Sequence[type[BaseModel]]) -> dict[str, FieldInfo]:
    return {field.alias or name: field for s in sections for name, field in s.model_fields.items()}


def _sections(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [section for part in get_args(annotation) for section in _sections(part)]


def _tag(section: type[BaseModel]) -> str | None:
    """The `kind` that chooses a section among others."""
    kind = section.model_fields.get("kind")
    choices = get_args(kind.annotation) if kind else ()
    return str(choices[0]) if choices else None
