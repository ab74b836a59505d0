"""What is not on the list of effects but looks like one: a dead band of the controller, a joint stop.

A diagnosis tries these beside the effects, so that a dead band is not named friction. What is explained by one of them
is said in a note and never named as a finding, because no model can be mended with it here.
"""

from __future__ import annotations

import math
from dataclasses import replace

from realitygap.robot.effects import EFFECTS, Effect, Page, Parameter, Values
from realitygap.robot.effects.joint import has_servo
from realitygap.robot.plant import Plant


def _own_band(plant: Plant, index: int) -> dict[str, float]:
    return {"width": float(plant.drive["dead_band"][index])}


def _band(plant: Plant, indices: list[int], values: Values) -> None:
    plant.drive["dead_band"][indices] = values["width"]


def _page(physics: str) -> Page:
    return Page(physics=physics, equation="", signature="", confused_with="", source="")


CONTROLLER_DEAD_BAND = Effect(
    name="controller_dead_band",
    changes="torque",
    sits_at="joint",
    parameters=(Parameter("width", "rad", 0.0, 0.5, 0.01, absent=0.0),),
    signals=("position", "effort"),
    own=_own_band,
    apply=_band,
    possible=has_servo,
    page=_page("A controller that ignores a position error smaller than a width."),
)


def _anywhere(_plant: Plant, _index: int) -> str | None:
    return None


def _stop(upper: bool) -> Effect:
    field = "upper" if upper else "lower"

    def own(_plant: Plant, _index: int) -> dict[str, float]:
        return {"angle": math.inf if upper else -math.inf}

    def apply(plant: Plant, indices: list[int], values: Values) -> None:
        joints = list(plant.model.joints)
        for i in indices:
            limit = values["angle"]
            joints[i] = replace(joints[i], upper=limit) if upper else replace(joints[i], lower=limit)
        plant.model = replace(plant.model, joints=tuple(joints))

    return Effect(
        name=f"{field}_joint_stop",
        changes="model",
        sits_at="joint",
        parameters=(Parameter("angle", "rad", -100.0, 100.0, 1.0, absent=math.inf if upper else -math.inf),),
        signals=("position",),
        own=own,
        apply=apply,
        possible=_anywhere,
        page=_page("Something that the joint runs against."),
    )


DECOYS: dict[str, Effect] = {e.name: e for e in (CONTROLLER_DEAD_BAND, _stop(True), _stop(False))}
KNOWN: dict[str, Effect] = EFFECTS | DECOYS
"""All that a diagnosis tries: the effects in the order of their table, then what must not be taken for them."""
