"""What the sections of every file that people write are made of."""

from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema

Finite = Annotated[float, Field(strict=True, allow_inf_nan=False)]  # strict: `true` and "5" are no numbers
Positive = Annotated[Finite, Field(gt=0)]
NotNegative = Annotated[Finite, Field(ge=0)]
Fraction = Annotated[Finite, Field(gt=0, le=1)]
Count = Annotated[int, Field(strict=True, gt=0)]


def _listed(value: object) -> object:
    return [value] if isinstance(value, str) else value


ONE_OR_MORE = {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}, "minItems": 1}]}
"""What editors are told: one pattern, or a list of them."""
Patterns = Annotated[list[str], BeforeValidator(_listed), Field(min_length=1), WithJsonSchema(ONE_OR_MORE)]


class Section(BaseModel):
    """A part of a file: unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)
