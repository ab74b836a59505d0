"""Effects that a program adds to those of a scenario, checked as those of a file are."""

from collections.abc import Mapping, Sequence
from typing import Any

from realitygap.files.errors import InputError
from realitygap.files.found import shown
from realitygap.files.validation import validate
from realitygap.scenario.file import ScenarioFile
from realitygap.scenario.plain import plain
from realitygap.scenario.schema import EffectSpec

Effect = EffectSpec | Mapping[str, Any]
"""As `rg.effects` makes it, or a mapping that says the same."""


def added_effects(file: ScenarioFile, effects: Effect | Sequence[Effect]) -> list[EffectSpec]:
    """One effect, or several.

    Raises:
        InputError: for what is none.
    """
    if isinstance(effects, EffectSpec | Mapping):
        effects = [effects]
    if not isinstance(effects, list | tuple):
        raise InputError(f"{file.path}: effects: found {shown(effects)}; expected effects, as rg.effects makes them")
    return [
        e if isinstance(e, EffectSpec) else validate(f"{file.path}: effects[{k}]", EffectSpec, plain(e))
        for k, e in enumerate(effects)
    ]
