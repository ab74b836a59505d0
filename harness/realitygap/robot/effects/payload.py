"""A load that is fixed to a link: its mass and its place are one finding."""

import math

from realitygap.robot.effects.body import moves
from realitygap.robot.effects.effect import Effect, Page, Parameter, Values
from realitygap.robot.plant import Plant
from realitygap.robot.reach import extent, reach

WHERE = 1.0
"""A load lies no further than this from the link's frame [m]."""
FURTHER = 2.0
"""Nor further than its link itself reaches, so many times, or the whole robot once, where that is more: a load is as
long as what carries it, and a tool at a small wrist no longer than the arm. What turned too slowly was told as a load
of 7.6 g at 0.71 m, of two links of 0.2 m, for a link's inertia; what motors lost as one of 4 g at 1 m."""


def _own(plant: Plant, index: int) -> dict[str, float]:
    return dict(zip(("mass", "x", "y", "z"), plant.payloads.get(index, (0.0, 0.0, 0.0, 0.0)), strict=True))


def _apply(plant: Plant, indices: list[int], values: Values) -> None:
    for i in indices:
        if values["mass"] > 0:
            plant.payloads[i] = (values["mass"], values["x"], values["y"], values["z"])
        else:
            plant.payloads.pop(i, None)


def _first(plant: Plant, index: int) -> dict[str, float]:
    """A twentieth of what moves of the robot, at the link's centre of mass: arms carry a tenth to a third of that."""
    link, moving = plant.model.links[index], plant.model.links[0 if plant.model.floating else 1 :]
    x, y, z = (float(v) for v in link.com)
    return {"mass": max(0.05 * sum(m.mass for m in moving), 0.2 * link.mass), "x": x, "y": y, "z": z}


def _none(plant: Plant, index: int, values: Values) -> str | None:
    if not (math.isfinite(values["mass"]) and values["mass"] > 0):
        return "nothing would be loaded"
    if max(abs(values[axis]) for axis in "xyz") >= WHERE:
        return f"a load {WHERE:g} m or more beside its link is none: a lever and no weight would be added"
    far = math.hypot(*(values[axis] for axis in "xyz"))
    size = max(FURTHER * extent(plant.model, index), reach(plant.model))
    if far > size > 0.0:
        return f"a load {far:.3g} m beside its link is none: neither twice the link nor the robot reaches {size:.3g} m"
    return None


PAYLOAD = Effect(
    name="payload",
    changes="model",
    sits_at="link",
    law="load",
    parameters=(
        Parameter("mass", "kg", 0.0, 1000.0, 0.5, absent=0.0),
        *(Parameter(axis, "m", -WHERE, WHERE, 0.0, absent=0.0, default=0.0, shape=True, typical=0.1) for axis in "xyz"),
    ),
    signals=("position", "effort"),
    own=_own,
    apply=_apply,
    possible=moves,
    scaled=_first,
    page=Page(
        physics="A tool, a gripper, a battery or whatever the robot carries, which the model of the robot does not "
        "have: a point mass at a place in the frame of the link that it is fixed to. What size it has turns too little "
        "to be told from a point.",
        equation="m → m + mass; c → (m·c + mass·(x, y, z))/(m + mass); inertia by the parallel-axis theorem",
        signature="More effort and sag at every joint before the link, in proportion to its lever, at rest and in "
        "motion; none at the joints behind it.",
        confused_with="link_mass (the same where the load sits at the link's own centre of mass), center_of_mass "
        "(moves the lever and no weight), a payload on the next link (until the joint between them turns).",
        source="Atkeson, An, Hollerbach: Estimation of inertial parameters of manipulator loads and links, Int. J. "
        "Robotics Research 5(3), 1986; Mamedov, Mikhel: Practical aspects of model-based collision detection, Front. "
        "Robotics AI 7, 2020.",
    ),
    absurd=_none,
)
