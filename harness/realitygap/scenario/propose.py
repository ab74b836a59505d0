"""The section of a scenario on what may be proposed to record: the owner's limits, and what the owner has at hand."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, model_validator

from realitygap.scenario.section import Finite, NotNegative, Positive, Section

SegmentKind = Literal["hold", "triangle", "step", "chirp", "multisine", "reversal", "release"]


class JointLimits(Section):
    """How far a joint may go in a proposed motion, where that is not what robot file and recordings say."""

    position: tuple[Finite, Finite] | None = Field(default=None, description="lowest and highest position [rad or m]")
    speed: Positive | None = Field(default=None, description="largest speed [rad/s or m/s]")
    effort: Positive | None = Field(default=None, description="largest effort of the motor [N·m or N]")

    @model_validator(mode="after")
    def _ordered(self) -> JointLimits:
        if self.position is not None and not self.position[0] < self.position[1]:
            raise ValueError(f"position {list(self.position)} ends below where it begins")
        return self


class LoadPlace(Section):
    """Where a second load is fixed."""

    link: str | None = Field(default=None, description="the link (default: the last one)")
    place: tuple[Finite, Finite, Finite] | None = Field(
        default=None, description="in the link's frame [m] (default: its centre of mass)"
    )


class ProposeSpec(Section):
    """What `realitygap propose` may ask for."""

    pose: dict[str, Finite] = Field(
        default={}, description="where motions start and end at rest [rad or m] (default: where the recordings start)"
    )
    limits: dict[str, JointLimits] = Field(default={}, description="by patterns over joint names (the first matches)")
    forbid: list[SegmentKind] = Field(default=[], description="kinds of motion that are not to be proposed")
    release: bool | None = Field(
        default=None,
        description="whether servos may be switched off while a joint is raised (default: where a recording has it)",
    )
    loads: list[NotNegative] = Field(default=[], description="masses that can be fixed to the robot [kg]; 0 is none")
    load_at: LoadPlace = Field(default=LoadPlace(), description="where they are fixed")
    overrides: list[dict[str, Any]] = Field(
        default=[],
        alias="with",
        description="further conditions that can be had, each as the `with` of a run: another gain, another supply",
    )
