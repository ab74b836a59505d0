"""Mass, shape and mounting of the bodies.

A link that is fixed to another is one body with it. Either name is accepted as a target; the values are those of the
whole body, in the frame of the link that moves.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from realitygap_engines.model.robot import Link

from realitygap.robot.effects.effect import Effect, Page, Parameter, Values
from realitygap.robot.plant import Plant


def moves(plant: Plant, index: int) -> str | None:
    """For effects on a link that moves."""
    if index == 0 and not plant.model.floating:
        return f"link {plant.model.links[0].name} is fixed to the world and does not move; expected another link"
    return None


def _edit(plant: Plant, indices: list[int], change: Callable[[Link], dict[str, Any]]) -> None:
    links = list(plant.model.links)
    for i in indices:
        links[i] = replace(links[i], **change(links[i]))
    plant.model = replace(plant.model, links=tuple(links))


def _own_mass(plant: Plant, index: int) -> dict[str, float]:
    return {"mass": plant.model.links[index].mass}


def _mass(plant: Plant, indices: list[int], values: Values) -> None:
    _edit(plant, indices, lambda _: {"mass": values["mass"]})


def _heavier(plant: Plant, index: int) -> dict[str, float]:
    return {"mass": 1.2 * plant.model.links[index].mass}


LINK_MASS = Effect(
    name="link_mass",
    changes="model",
    sits_at="link",
    law="load",
    special_of=("center_of_mass", "payload"),
    parameters=(Parameter("mass", "kg", 1e-6, 1000.0, 1.0, logarithmic=True),),
    signals=("position", "effort"),
    own=_own_mass,
    apply=_mass,
    possible=moves,
    scaled=_heavier,
    page=Page(
        physics="Cables, screws, batteries and paint are not in the drawing. The inertia about the centre of mass "
        "stays.",
        equation="M(q) and gravity with the new mass at the same centre",
        signature="More sag and effort in proportion to gravity's lever, at rest and in motion.",
        confused_with="center_of_mass (the same m·g·l in one joint), link_inertia, torque_constant (where effort was "
        "not recorded), load_dependent_friction.",
        source="Atkeson, An, Hollerbach: Estimation of inertial parameters, Int. J. Robotics Research 5(3), 1986; "
        "Flemming 2019, table of link masses.",
    ),
)


def _own_com(plant: Plant, index: int) -> dict[str, float]:
    return dict(zip("xyz", (float(v) for v in plant.model.links[index].com), strict=True))


def _com(plant: Plant, indices: list[int], values: Values) -> None:
    _edit(plant, indices, lambda _: {"com": np.array([values["x"], values["y"], values["z"]])})


def _shifted(plant: Plant, index: int) -> dict[str, float]:
    com = plant.model.links[index].com
    outward = com / length if (length := float(np.linalg.norm(com))) > 1e-3 else np.array([1.0, 0.0, 0.0])
    return dict(zip("xyz", (float(v) for v in com + 0.01 * outward), strict=True))


CENTER_OF_MASS = Effect(
    name="center_of_mass",
    changes="model",
    sits_at="link",
    law="load",
    special_of=("payload",),
    parameters=tuple(Parameter(axis, "m", -10.0, 10.0, 0.0) for axis in "xyz"),
    signals=("position", "effort"),
    own=_own_com,
    apply=_com,
    possible=moves,
    scaled=_shifted,
    page=Page(
        physics="Where the mass sits, in the frame of the link: drawings assume evenly filled parts. The inertia "
        "about the centre of mass stays.",
        equation="M(q) and gravity with the mass at (x, y, z)",
        signature="A change of sag and effort whose phase over the angle differs from gravity's own: also sideways.",
        confused_with="link_mass (along the same lever), base_tilt and joint_offset (turn gravity instead), "
        "constant_effort.",
        source="Atkeson, An, Hollerbach, Int. J. Robotics Research 5(3), 1986; Flemming 2019, chapter 4.",
    ),
)


def _own_inertia(_plant: Plant, _index: int) -> dict[str, float]:
    return {"scale": 1.0}


def _inertia(plant: Plant, indices: list[int], values: Values) -> None:
    _edit(plant, indices, lambda link: {"inertia": link.inertia * values["scale"]})


def _has_inertia(plant: Plant, index: int) -> str | None:
    link = plant.model.links[index]
    if not np.trace(link.inertia) > 0:
        return f"link {link.name} is a point mass without inertia to scale; expected an <inertia> above zero"
    return moves(plant, index)


ROD = 3.0
"""Mass at both ends of a rod, m·L²/4, has so many times the inertia of one that is even, m·L²/12."""

SPARE = 1.25
"""How many times as much is fitted at most: while laws beside it are a little off, 3.69 was for 3.24 times, where 3.56
would be at the end of the link."""


def _within(plant: Plant, index: int) -> dict[str, float]:
    """As if all mass sat at the end of the link, as far as joints and contacts tell how long it is: where a rotor was
    missing at each of several joints, a link had 7.7 times its own inertia.
    """
    link, joints = plant.model.links[index], plant.model.joints
    ends = [np.zeros(3), *(j.origin[:3, 3] for j in joints if j.parent == index), *(s.center for s in link.spheres)]
    reach = max(float(np.linalg.norm(end - link.com)) for end in ends)
    return {"scale": SPARE * max(link.mass * reach**2 / float(np.linalg.norm(link.inertia, 2)), ROD)}


def _beyond(plant: Plant, index: int, values: Values) -> str | None:
    return "mass would have to sit beyond the link" if values["scale"] >= _within(plant, index)["scale"] else None


LINK_INERTIA = Effect(
    name="link_inertia",
    changes="model",
    sits_at="link",
    law="load",
    special_of=("center_of_mass", "payload"),
    parameters=(Parameter("scale", "", 0.01, 100.0, 1.5, absent=1.0, logarithmic=True),),
    signals=("position", "velocity"),
    own=_own_inertia,
    apply=_inertia,
    possible=_has_inertia,
    page=Page(
        physics="How the mass is spread: the tensor about the centre of mass is often a guess (a box, a point).",
        equation="I_c → scale·I_c",
        signature="Slower or quicker acceleration and other overshoot; nothing at rest.",
        confused_with="rotor_inertia (the same on a single joint), link_mass, viscous_friction.",
        source="Atkeson, An, Hollerbach, Int. J. Robotics Research 5(3), 1986.",
    ),
    largest=_within,
    absurd=_beyond,
)


def _own_tilt(plant: Plant, _index: int) -> dict[str, float]:
    return {"roll": float(plant.base_tilt[0]), "pitch": float(plant.base_tilt[1])}


def _tilt(plant: Plant, _indices: list[int], values: Values) -> None:
    plant.base_tilt = np.array([values["roll"], values["pitch"]])


def _is_fixed(plant: Plant, _index: int) -> str | None:
    if plant.model.floating:
        return "the base moves freely, and has its own orientation; expected `robot.base: fixed`"
    return None


LEAN = 0.3
"""A base leans by no more than this [rad] from level or from a mount at quarter turns: one would see it."""


def _leans(_plant: Plant, _index: int, values: Values) -> str | None:
    quarter = math.pi / 2
    lean = max(abs((v + quarter / 2) % quarter - quarter / 2) for v in values.values())
    return f"the base would lean by {math.degrees(lean):.0f}°, and one would see that" if lean > LEAN else None


BASE_TILT = Effect(
    name="base_tilt",
    changes="model",
    sits_at="base",
    law="load",
    parameters=(
        Parameter("roll", "rad", -math.pi, math.pi, 0.03, absent=0.0, default=0.0),
        Parameter("pitch", "rad", -math.pi, math.pi, 0.03, absent=0.0, default=0.0),
    ),
    signals=("position", "effort"),
    own=_own_tilt,
    apply=_tilt,
    possible=_is_fixed,
    page=Page(
        physics="A bench or a mount that is not level: gravity is turned in the frame of the base. Right-handed, "
        "first about the base's x, then about its y.",
        equation="R_base = R_x(roll)·R_y(pitch)",
        signature="Sag and effort belong to a pose that is turned by the same angle; a free pendulum hangs beside "
        "zero.",
        confused_with="joint_offset (the same for a single joint; of several, tilt turns all), center_of_mass, "
        "constant_effort.",
        source="Flemming 2019, chapter 4; any spirit level.",
    ),
    absurd=_leans,
)
