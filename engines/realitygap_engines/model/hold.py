"""Joints that are held fixed: welded at an angle, so that what they carry is one body with what carries them."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from realitygap_engines.model.inertia import Inertial, together
from realitygap_engines.model.robot import Array, Joint, Link, Model, Sphere, axis_rotation


def hold(model: Model, angles: Mapping[int, float]) -> Model:
    """The model with joints welded at these positions [rad or m], by the joint's index.

    A held joint is no joint of the new model, and its child link is part of the nearest link before it that moves, in
    whose `held` it stands. What mimics a held joint is held, too.
    """
    if not angles:
        return model
    known = {model.joints[i].name: angle for i, angle in angles.items()}
    follows = {i: j.mimic for i, j in enumerate(model.joints) if j.mimic is not None and j.mimic.joint in known}
    angles = {**{i: m.multiplier * known[m.joint] + m.offset for i, m in follows.items()}, **angles}
    carrier: list[tuple[int, Array]] = [(0, np.eye(4))]  # of every link: the new index, and its pose in that link
    links, joints = [model.links[0]], list[Joint]()
    for i, (joint, link) in enumerate(zip(model.joints, model.links[1:], strict=True)):
        index, pose = carrier[joint.parent]
        origin = pose @ joint.origin
        if i in angles:
            place = origin @ _moved(joint, angles[i])
            links[index] = _carrying(links[index], link, place)
            carrier.append((index, place))
        else:
            joints.append(replace(joint, parent=index, origin=origin))
            carrier.append((len(links), np.eye(4)))
            links.append(link)
    names = {joint.name for joint in joints}
    actuators = tuple(a for a in model.actuators if a.joint in names)
    return replace(model, links=tuple(links), joints=tuple(joints), actuators=actuators)


def own_body(link: Link) -> Inertial:
    """A link without what it holds: mass, centre of mass and inertia about it."""
    taken = [(-mass, com, -inertia) for mass, com, inertia in link.held]
    return together([(link.mass, link.com, link.inertia), *taken])


def _moved(joint: Joint, angle: float) -> Array:
    motion = np.eye(4)
    if joint.prismatic:
        motion[:3, 3] = joint.axis * angle
    else:
        motion[:3, :3] = axis_rotation(joint.axis, angle)
    return motion


def _carrying(link: Link, other: Link, place: Array) -> Link:
    """A link with another fixed to it at a pose (4, 4)."""
    turn, at = place[:3, :3], place[:3, 3]
    body = (other.mass, turn @ other.com + at, turn @ other.inertia @ turn.T)
    mass, com, inertia = together([(link.mass, link.com, link.inertia), body])
    spheres = (*link.spheres, *(Sphere(turn @ s.center + at, s.radius) for s in other.spheres))
    return replace(link, mass=mass, com=com, inertia=inertia, spheres=spheres, held=(*link.held, body))
