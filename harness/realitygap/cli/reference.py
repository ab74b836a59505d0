"""The reference of all files that people write, made from their schemas: the second half of `scenarios/README.md`, and
the JSON Schemas for editors.
"""

import inspect
from types import NoneType
from typing import Annotated, Any, Literal, get_args, get_origin

import annotated_types
from pydantic import BaseModel, BeforeValidator
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from realitygap.bench.ground import GroundBench
from realitygap.bench.link_file import LinkBench
from realitygap.bench.quantity import Written
from realitygap.bench.servo_file import ServoBench
from realitygap.bench.supply_file import SupplyBench
from realitygap.matrix.matrix_file import Matrix
from realitygap.scenario.schema import Scenario
from realitygap.scenario.world import GROUNDS, GroundSpec

BEGIN = "<!-- made by realitygap.cli.reference: change the schema, then `make reference` -->"
WORDS = {str: "text", float: "number", int: "whole number", bool: "true or false", Any: "anything"}
FILES: dict[type[BaseModel], str] = {
    Scenario: "a scenario file",
    Matrix: "the file of `realitygap matrix`",
    ServoBench: "the file of `realitygap bench servo`",
    SupplyBench: "the file of `realitygap bench supply`",
    LinkBench: "the file of `realitygap bench links`",
    GroundBench: "the file of `realitygap bench ground`",
}
"""The files that people write."""


def reference() -> str:
    """The tables of all sections as Markdown: key, type, default and meaning, in the order of first use."""
    parts = [BEGIN, ""]
    for section in dict.fromkeys(section for file in FILES for section in _sections(file)):
        parts += [f"### {_title(section)}", "", inspect.cleandoc(section.__doc__ or ""), ""]
        parts += ["| key | type | default | meaning |", "|---|---|---|---|"]
        for name, field in section.model_fields.items():
            kind = _type(field.annotation, field.metadata)
            parts.append(f"| `{field.alias or name}` | {kind} | {_default(field)} | {field.description or ''} |")
        if section is GroundSpec:
            parts += ["", *_named_grounds()]
        parts.append("")
    return "\n".join(parts)


def with_reference(text: str) -> str:
    """A page with its reference made anew."""
    return text[: text.index(BEGIN)] + reference()


def _sections(start: type[BaseModel]) -> list[type[BaseModel]]:
    """A section and all that stand in it, each once, depth first."""
    found = [start]
    for field in start.model_fields.values():
        for model in _models(field.annotation):
            found += [section for section in _sections(model) if section not in found]
    return found


def _models(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _models(part)]


def _title(section: type[BaseModel]) -> str:
    return f"{section.__name__} (the top of {FILES[section]})" if section in FILES else section.__name__


def _type(annotation: Any, metadata: list[Any]) -> str:
    """A type in words, with its bounds."""
    written = next((m.words for m in metadata if isinstance(m, Written)), None)
    if written is not None:
        return written
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _type(parts[0], list(parts[1:]))
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return f"[{annotation.__name__}](#{annotation.__name__.lower()})"
    if origin is Literal:
        return ", ".join(f"`{p}`" for p in parts)
    if origin is list:
        single = f"{_type(parts[0], [])} or " if any(isinstance(m, BeforeValidator) for m in metadata) else ""
        return f"{single}list of {_type(parts[0], [])}"
    if origin is dict:
        return f"mapping of {_type(parts[0], [])} to {_type(parts[1], [])}"
    if origin is tuple:
        return f"[{', '.join(_type(p, []) for p in parts)}]"
    if parts:
        return " or ".join(_type(p, []) for p in parts if p is not NoneType)
    bounds = " and ".join(_bounds(metadata))
    return f"{WORDS[annotation]} {bounds}".rstrip()


def _bounds(metadata: list[Any]) -> list[str]:
    """Bounds in words; pydantic keeps them in fields or as they are."""
    found = []
    for constraint in metadata:
        if isinstance(constraint, FieldInfo):
            found += _bounds(constraint.metadata)
        elif isinstance(constraint, annotated_types.Gt):
            found.append(f"> {constraint.gt}")
        elif isinstance(constraint, annotated_types.Ge):
            found.append(f"≥ {constraint.ge}")
        elif isinstance(constraint, annotated_types.Le):
            found.append(f"≤ {constraint.le}")
    return found


def _default(field: FieldInfo) -> str:
    if field.default is PydanticUndefined:
        return "**needed**"
    if field.default in (None, [], {}) or isinstance(field.default, BaseModel):
        return ""
    value = field.default
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return f"`{text.lower() if isinstance(value, bool) else text}`".replace("'", "")


def _named_grounds() -> list[str]:
    lines = []
    for name, spec in GROUNDS.items():
        values = "nothing to stand on" if spec is None else str(spec.model_dump(exclude_none=True)).replace("'", "")
        lines.append(f"- `{name}`: {values}")
    return lines


def main() -> None:
    """Write the reference into scenarios/README.md of the repository, and the JSON Schemas into the package."""
    from pathlib import Path

    from realitygap.cli.json_schema import write_json_schemas
    from realitygap.files.whole import write_whole

    page = Path(__file__).parents[3] / "scenarios" / "README.md"
    write_whole(page, with_reference(page.read_text(encoding="utf-8")))
    write_json_schemas()


if __name__ == "__main__":
    main()
