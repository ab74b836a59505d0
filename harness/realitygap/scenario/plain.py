"""What a program says of a scenario, as a YAML file would say it: text, numbers, lists and mappings of them."""

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import BaseModel


def plain(value: Any) -> Any:
    """The same value without anything that a YAML file cannot hold, and with nothing shared.

    Paths become text, arrays and tuples lists, numpy's numbers Python's, sections of the schema (an effect) mappings of
    what was said in them. What has no such form stays, for the schema to complain about.
    """
    if isinstance(value, BaseModel):
        return plain(value.model_dump(by_alias=True, exclude_unset=True))
    if isinstance(value, Mapping):
        return {plain(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return value
