"""`manifest.json` of a result folder, read and checked: it may come from anywhere."""

import json
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel

from realitygap.files.errors import InputError
from realitygap.files.found import kind_of
from realitygap.files.validation import validate


class _Ability(BaseModel):
    level: Literal["native", "emulated", "no"]
    how: str


class _Manifest(BaseModel):
    """What a page is made of; other keys are left alone. Their meaning stands where they are written."""

    scenario: str | None = None
    command_line: list[str] | str = []
    python: str | None = None
    platform: str | None = None
    versions: dict[str, str | None] = {}
    settings: dict[str, dict[str, Any]] = {}
    capabilities: dict[str, dict[str, _Ability]] = {}
    inputs: dict[str, str] = {}
    notes: dict[str, list[str]] = {}
    virtual: bool = False
    failures: dict[str, str] = {}
    traces: dict[str, str] | None = None


def read_manifest(folder: Path) -> dict[str, Any]:
    """The manifest of a result folder; empty where there is none.

    Raises:
        InputError: for one that is damaged.
    """
    path = folder / "manifest.json"
    if not path.is_file():
        return {}
    try:
        raw = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: is not valid JSON ({type(error).__name__}); expected what a run wrote") from None
    if not isinstance(raw, dict):
        raise InputError(f"{path}: holds {kind_of(raw)}, expected what a run wrote")
    return validate(path, _Manifest, raw).model_dump(exclude_unset=True)
