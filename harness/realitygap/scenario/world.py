"""The sections of a scenario on what surrounds the robot: the ground, and how time is stepped."""

from __future__ import annotations

import math

from pydantic import Field, ValidationInfo, field_validator

from realitygap.scenario.section import Count, Finite, NotNegative, Positive, Section


class GroundSpec(Section):
    """A ground by its numbers."""

    friction: NotNegative = Field(default=0.8, description="coefficient of the pair robot-ground")
    stiffness: Positive | None = Field(default=None, description="per contact point [N/m]; rigid where absent")
    damping: NotNegative | None = Field(default=None, description="per contact point [N·s/m], with a stiffness")

    @field_validator("damping")
    @classmethod
    def _of_a_soft_one(cls, damping: float | None, others: ValidationInfo) -> float | None:
        if damping and others.data.get("stiffness", math.nan) is None:  # NaN: it is there and wrong itself
            raise ValueError("expected a stiffness beside it: without one the ground is rigid, and has no damping")
        return damping


GROUNDS = {
    "none": None,
    "flat": GroundSpec(friction=0.8),
    "grass": GroundSpec(friction=0.8, stiffness=3000.0, damping=100.0),
}


class PhysicsSpec(Section):
    """How to simulate."""

    step_rate: Finite = Field(default=1000.0, ge=10, description="steps per second [Hz]")
    solver_iterations: Count | None = Field(default=None, description="solver iterations, where the engine has them")
