"""Effects that a program adds to those of a scenario, checked as those of a file are."""

from collections.abc import Mapping, Sequence
from typing import Any

from realitygap.files.validation import validate
from realitygap.scenario.file import ScenarioFile
from realitygap.scenario.plain import plain
from realitygap.scenario.schema import EffectSpec


def added_effects(file: ScenarioFile, effects: Sequence[EffectSpec | Mapping[str, Any]]) -> list[EffectSpec]:
    """Effects as `rg.effects` makes them, or mappings that say the same.

    Raises:
        InputError: for what is neither.
    """
    return [
        e if isinstance(e, EffectSpec) else validate(f"{file.path}: effects[{k}]", EffectSpec, plain(e))
        for k, e in enumerate(effects)
    ]
