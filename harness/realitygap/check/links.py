"""Lengths, masses and inertias that no link of such a robot has."""

import numpy as np
from realitygap_engines.model.robot import Model

from realitygap.check.mistake import Certainty, Mistake
from realitygap.robot.plant import Plant
from realitygap.robot.reach import bulk, gyration, reach

WIDE, ABSURD = 5.0, 30.0
"""A body whose mass lies further from its centre than this many times the robot's reach is none, and than that many
times its own size where it is as light as bodies come, as a disc on its axis reaches nowhere; the second certain."""
ODD = 100.0
"""A single link that is this many times heavier than the next is in another unit: 30 is a rotor beside its housing."""
LONG, ENDLESS = 20.0, 100.0
"""m: a moving link is no longer than this (the sections of the longest booms that fold, of concrete pumps, have about
15 m), and in mm one of 2 cm already is; the second certain, which only the jibs of the largest cranes come near."""


def link_mistakes(plant: Plant) -> list[Mistake]:
    """Lengths in mm, or else masses and inertias in another unit, which lengths make wrong as well."""
    return _long_links(plant.model) or _heavy_links(plant.model)


def _long_links(model: Model) -> list[Mistake]:
    """Joints, or centres of mass, that are far from the joint that carries their link.

    A first joint may stand anywhere on a fixed base.
    """
    first = 0 if model.floating else 1
    far = [
        (float(np.linalg.norm(joint.origin[:3, 3])), f"the origin of joint {joint.name}", "its parent", joint.name)
        for joint in model.joints
        if joint.parent >= first
    ]
    for i, link in enumerate(model.links[first:], first):
        name = model.joints[i - 1].name if i else model.joints[0].name if model.joints else link.name
        far.append((float(np.linalg.norm(link.com)), f"the centre of mass of link {link.name}", "its joint", name))
    long = sorted((f for f in far if f[0] > LONG), reverse=True)
    if not long:
        return []
    length, what, whence, _ = long[0]
    sentence = (
        f"{what} is {length:.4g} m from {whence}: lengths a thousand times too large, as of mm; expected m in the URDF"
    )
    names = tuple(sorted({name for *_, name in long}))
    return [Mistake("thousandths", "certain" if length > ENDLESS else "likely", names, sentence, "robot.urdf")]


def _heavy_links(model: Model) -> list[Mistake]:
    """Inertias that are far too large for the size of a robot, and a link that is far heavier than all others."""
    far = reach(model)
    out = []
    first = 0 if model.floating else 1
    for i in range(first, len(model.links)):
        link = model.links[i]
        if far <= 0 or not _turns(model, i):
            continue
        wide, size = gyration(link), max(far, bulk(link))
        if wide > WIDE * size:
            sentence = (
                f"the inertia of link {link.name} puts its {link.mass:.3g} kg {wide:.3g} m from its centre, "
                f"and the whole robot reaches {far:.3g} m: an inertia in another unit than kg·m², or a mass in "
                "another than kg; expected both to fit the link's size"
            )
            certainty: Certainty = "certain" if wide > ABSURD * size else "likely"
            out.append(Mistake("impossible_link", certainty, _joint_of(model, i), sentence, "robot.urdf"))
    masses = np.array([link.mass for link in model.links[first:]])
    if len(masses) > 2:
        order = np.argsort(masses)
        heaviest, after = masses[order[-1]], masses[order[-2]]
        if heaviest > ODD * after and heaviest > 20.0 and np.median(masses) > 1e-3:
            link = model.links[first + int(order[-1])]
            sentence = (
                f"link {link.name} weighs {heaviest:.4g} kg and the next heaviest {after:.3g} kg: grams, as it seems; "
                "expected kg"
            )
            out.append(Mistake("grams", "certain", _joint_of(model, first + int(order[-1])), sentence, "robot.urdf"))
    return out


def _joint_of(model: Model, link: int) -> tuple[str, ...]:
    return (model.joints[link - 1].name,) if link else tuple(model.joint_names)


def _turns(model: Model, link: int) -> bool:
    """Whether a link turns at all: a revolute joint or a floating base carries it."""
    if model.floating:
        return True
    while link > 0:
        joint = model.joints[link - 1]
        if not joint.prismatic:
            return True
        link = joint.parent
    return False
