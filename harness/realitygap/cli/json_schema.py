"""JSON Schemas of the files that people write, for editors that complete and check while they are written.

They are made from the same classes that check the files, and lie in the wheel beside these.
"""

import json
import math
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema, models_json_schema
from pydantic_core import CoreSchema

from realitygap.bench.ground import GroundBench
from realitygap.bench.link_file import LinkBench
from realitygap.bench.servo_file import ServoBench
from realitygap.bench.supply_file import SupplyBench
from realitygap.cli.schema_files import SCHEMA_FILES
from realitygap.files.whole import write_whole
from realitygap.matrix.matrix_file import Matrix
from realitygap.robot.effects import WRITABLE, Effect, Parameter
from realitygap.scenario.plain import plain
from realitygap.scenario.schema import EffectSpec, Scenario

FILES: dict[str, tuple[type[BaseModel], ...]] = {
    "scenario": (Scenario,),
    "matrix": (Matrix,),
    "bench": (ServoBench, SupplyBench, LinkBench, GroundBench),
}
"""What may stand at the top of each file."""


class _Schema(GenerateJsonSchema):
    """Without titles of keys, which would repeat their names."""

    def field_title_should_be_set(self, schema: CoreSchema | Any) -> bool:
        del schema
        return False


def json_schema(name: str) -> dict[str, Any]:
    """The schema of one of `FILES`, keys as people write them."""
    models = FILES[name]
    places, schema = models_json_schema(
        [(model, "validation") for model in models], by_alias=True, schema_generator=_Schema
    )
    definitions = schema["$defs"]
    if EffectSpec.__name__ in definitions:
        definitions[EffectSpec.__name__] = _effects(definitions[EffectSpec.__name__])
    tops = [places[model, "validation"] for model in models]
    return {
        "$schema": GenerateJsonSchema.schema_dialect,
        "title": f"{name} of realitygap",
        **(tops[0] if len(tops) == 1 else {"anyOf": tops}),
        "$defs": definitions,
    }


def json_schema_text(name: str) -> str:
    """The same as the content of a file."""
    return json.dumps(json_schema(name), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def write_json_schemas() -> list[Path]:
    """Write the schemas of all files into the package."""
    for name, path in SCHEMA_FILES.items():
        write_whole(path, json_schema_text(name))
    return list(SCHEMA_FILES.values())


def _effects(spec: dict[str, Any]) -> dict[str, Any]:
    """An effect of a scenario: its name decides which parameters it has."""
    known = {**spec["properties"]["effect"], "enum": list(WRITABLE)}
    return {
        "type": "object",
        "description": spec["description"],
        "properties": {**spec["properties"], "effect": known},
        "required": ["effect"],
        "allOf": [_effect(effect) for effect in WRITABLE.values()],
    }


def _effect(effect: Effect) -> dict[str, Any]:
    own = {"properties": {"effect": {"const": effect.name}}, "required": ["effect"]}
    lists = {name: {"examples": [plain(value)]} for name, value in effect.example.items()}
    numbers = {p.name: _parameter(p) for p in effect.parameters}
    return {
        "if": own,
        "then": {
            "description": effect.page.physics,
            "properties": {"effect": True, "target": True, **lists, **numbers},
            "required": [*lists, *(p.name for p in effect.parameters if p.default is None)],
            "additionalProperties": False,
        },
    }


def _parameter(p: Parameter) -> dict[str, Any]:
    """A number within bounds, or the neutral value, wherever that lies. JSON knows no infinity: it is no bound."""
    number: dict[str, Any] = {"type": "number"}
    if p.absent != -math.inf:
        number["minimum"] = p.low
    if p.absent != math.inf:
        number["maximum"] = p.high
    out = dict(number)
    if p.absent is not None and math.isfinite(p.absent) and not p.low <= p.absent <= p.high:
        out = {"anyOf": [number, {"const": p.absent}]}
    if p.unit:
        out["description"] = f"[{p.unit}]"
    if p.default is not None and math.isfinite(p.default):
        out["default"] = p.default
    return out
