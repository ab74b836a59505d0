"""Reading a URDF into the canonical `Model`, and writing a `Model` as a plain URDF."""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import yourdfpy

from realitygap_engines.errors import ModelError
from realitygap_engines.model.contact import contact_spheres
from realitygap_engines.model.inertia import FixedBody, lump
from realitygap_engines.model.mimics import resolved
from realitygap_engines.model.robot import (
    Array,
    Joint,
    Link,
    Mimic,
    Model,
    quaternion_from_rotation,
    rotation_from_quaternion,
)
from realitygap_engines.model.touching import touching
from realitygap_engines.model.urdf_check import FLOATING, parse_urdf

AXIS = 1e-3
"""By how much an axis may miss the length 1 before it is told; one that is so short or 1/so long is a mistake."""
Fixed = tuple[yourdfpy.Link, Array]
"""A URDF link and its pose (4, 4) in the link that carries it."""
Branch = tuple[yourdfpy.Joint, Array]
"""A joint and the pose (4, 4) of its frame in the link that carries it."""


def read_urdf(
    path: Path, *, floating: bool, packages: Mapping[str, Path] | None = None, contact_links: list[str] | None = None
) -> Model:
    """The canonical model of a URDF file.

    Args:
        path: the URDF.
        floating: whether the root link moves freely; with a floating joint, that joint's child is the root. On a fixed
            base it is held where that joint stands.
        packages: where `package://NAME/` lies; without an entry, NAME is looked for beside and above the URDF.
        contact_links: URDF links whose collision shapes touch the ground (default: the root and the leaves).

    Raises:
        ModelError: for a file that is not a URDF or a robot that cannot be simulated, in one sentence.
    """
    robot = parse_urdf(path, packages)
    links = {link.name: link for link in robot.links}
    children: dict[str, list[yourdfpy.Joint]] = {name: [] for name in links}
    for joint in robot.joints:
        children[joint.parent].append(joint)
    (root,) = links.keys() - {joint.child for joint in robot.joints}
    free = next((joint for joint in robot.joints if joint.type == FLOATING), None)
    root = free.child if free is not None and floating else root

    bodies: list[Link] = []
    joints: list[Joint] = []
    shapes: list[list[tuple[yourdfpy.Collision, Array]]] = []
    notes = [] if free is None else [f"{FLOATING} joint {free.name} in the URDF: link {free.child} is the base"]
    parts, branches = _carried(root, links, children)
    todo: list[tuple[yourdfpy.Joint, Array, int]] = []  # depth first, in the file's order
    while True:
        index = len(bodies)
        lumped = [_part(part, pose) for part, pose in parts]
        body, mended = lump(path, lumped, moves=index > 0 or floating, root=index == 0)
        bodies.append(body)
        notes += mended
        shapes.append([(c, pose @ _pose(c.origin)) for part, pose in parts for c in part.collisions])
        todo += [(joint, origin, index) for joint, origin in reversed(branches)]
        if not todo:
            break
        joint, origin, parent = todo.pop()
        joints.append(_joint(path, joint, origin, parent))
        parts, branches = _carried(joint.child, links, children)
    joints = list(resolved(path, joints))
    if not floating and not joints:
        raise ModelError(f"{path}: nothing can move: the robot has no moving joint and a fixed base")

    touch = touching(path, bodies, joints, contact_links)
    notes += [
        f"link {body.name} does not touch the ground"
        for body, found in zip(bodies, shapes, strict=True)
        if found and touch and body.name not in touch  # where nothing may touch, nothing is said
    ]
    notes += [
        f"joint {joint.name} has {limit} limit 0 in the URDF, which is taken as no limit"
        for joint in robot.joints
        for limit in ("effort", "velocity")
        if joint.type != "fixed" and joint.limit is not None and getattr(joint.limit, limit) == 0
    ]
    notes += [
        f"joint {joint.name} has limits from 0 to 0 in the URDF, which are taken as none"
        for joint in robot.joints
        if joint.type in ("revolute", "prismatic") and _without_range(joint)
    ]
    notes += [
        f"joint {joint.name} has an axis of length {_length(joint):.4g} in the URDF; its direction is taken"
        for joint in robot.joints
        if joint.type != "fixed" and abs(_length(joint) - 1) > AXIS
    ]
    final = [
        replace(body, spheres=contact_spheres(path, body.name, found, packages or {})) if body.name in touch else body
        for body, found in zip(bodies, shapes, strict=True)
    ]
    return Model(robot.name, tuple(final), tuple(joints), floating, tuple(notes))


def _pose(origin: Array | None) -> Array:
    return np.eye(4) if origin is None else np.asarray(origin, dtype=float)


def _carried(
    name: str, links: Mapping[str, yourdfpy.Link], children: Mapping[str, list[yourdfpy.Joint]]
) -> tuple[list[Fixed], list[Branch]]:
    """Everything that is fixed to a link, itself first, and the joints that move away from it."""
    parts, branches = [(links[name], np.eye(4))], []
    todo = [(joint, _pose(joint.origin)) for joint in reversed(children[name])]
    while todo:
        joint, origin = todo.pop()
        if joint.type in ("fixed", FLOATING):  # what floats is held where the base is fixed
            parts.append((links[joint.child], origin))
            todo += [(further, origin @ _pose(further.origin)) for further in reversed(children[joint.child])]
        else:
            branches.append((joint, origin))
    return parts, branches


def _part(part: yourdfpy.Link, pose: Array) -> FixedBody:
    """A URDF link's inertial in the frame of the link that carries it."""
    inertial = part.inertial
    if inertial is None or inertial.mass is None:
        return FixedBody(part.name, None, np.zeros(3), np.zeros((3, 3)))
    origin = pose @ _pose(inertial.origin)
    tensor = np.zeros((3, 3)) if inertial.inertia is None else np.asarray(inertial.inertia, dtype=float)
    turned = origin[:3, :3] @ tensor @ origin[:3, :3].T
    return FixedBody(part.name, float(inertial.mass), origin[:3, 3], turned)


def _joint(path: Path, joint: yourdfpy.Joint, origin: Array, parent: int) -> Joint:
    axis = np.array([1.0, 0.0, 0.0]) if joint.axis is None else np.asarray(joint.axis, dtype=float)
    norm = _length(joint)
    if not AXIS < norm < 1 / AXIS:
        raise ModelError(f"{path}: joint {joint.name} has axis {axis}, expected a direction: a vector of length 1")
    limit, dynamics = joint.limit, joint.dynamics

    def value(source: object, key: str, default: float) -> float:
        found = getattr(source, key, None)
        return default if found is None else float(found)

    unlimited = joint.type == "continuous" or limit is None or _without_range(joint)
    lower = -np.inf if unlimited else value(limit, "lower", 0.0)
    upper = np.inf if unlimited else value(limit, "upper", 0.0)
    if lower >= upper:
        what = f"lower limit {lower:g} {'above' if lower > upper else 'at'} its upper limit {upper:g}"
        raise ModelError(f"{path}: joint {joint.name} has {what}; expected room to move, or a fixed joint")
    return Joint(
        name=joint.name,
        prismatic=joint.type == "prismatic",
        parent=parent,
        origin=origin,
        axis=axis / norm,
        lower=lower,
        upper=upper,
        effort=value(limit, "effort", np.inf) or np.inf,
        velocity=value(limit, "velocity", np.inf) or np.inf,
        friction=value(dynamics, "friction", 0.0),
        damping=value(dynamics, "damping", 0.0),
        mimic=_mimic(joint),
    )


def _length(joint: yourdfpy.Joint) -> float:
    """Of the axis, which is to be 1."""
    return 1.0 if joint.axis is None else math.hypot(*map(float, joint.axis))


def _without_range(joint: yourdfpy.Joint) -> bool:
    """Whether the limits of a joint go from 0 to 0, as exporters leave them that know none."""
    return joint.limit is not None and not (joint.limit.lower or joint.limit.upper)


def _mimic(joint: yourdfpy.Joint) -> Mimic | None:
    if joint.mimic is None:
        return None
    multiplier, offset = joint.mimic.multiplier, joint.mimic.offset
    return Mimic(joint.mimic.joint, 1.0 if multiplier is None else float(multiplier), float(offset or 0.0))


def rpy_from_rotation(rotation: Array) -> tuple[float, float, float]:
    """URDF's roll, pitch, yaw [rad] of a rotation matrix; yaw is 0 at the pole."""
    pitch = float(np.arctan2(-rotation[2, 0], np.hypot(rotation[0, 0], rotation[1, 0])))
    if np.hypot(rotation[0, 0], rotation[1, 0]) < 1e-12:
        return float(np.arctan2(-rotation[1, 2], rotation[1, 1])), pitch, 0.0
    return float(np.arctan2(rotation[2, 1], rotation[2, 2])), pitch, float(np.arctan2(rotation[1, 0], rotation[0, 0]))


def write_urdf(model: Model, *, spheres: bool = True) -> str:
    """The model as a URDF: inertials and joints only, with its contact spheres as collision where asked for.

    Limits, effort, friction and damping are left out: they are the adapter's to set. Numbers have 17 digits, so that
    every engine reads the same machine; rotations are cleaned of rounding first.
    """
    lines = [f"<robot name={quoteattr(model.name)}>"]
    for link in model.links:
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = link.inertia.tolist()
        lines += [
            f"<link name={quoteattr(link.name)}><inertial><origin xyz={_xyz(link.com)}/>",
            f'<mass value="{link.mass!r}"/>',
            f'<inertia ixx="{xx!r}" ixy="{xy!r}" ixz="{xz!r}" iyy="{yy!r}" iyz="{yz!r}" izz="{zz!r}"/></inertial>',
        ]
        for sphere in link.spheres if spheres else ():
            lines.append(
                f"<collision><origin xyz={_xyz(sphere.center)}/><geometry>"
                f'<sphere radius="{sphere.radius!r}"/></geometry></collision>'
            )
        lines.append("</link>")
    for i, joint in enumerate(model.joints):
        rotation = rotation_from_quaternion(quaternion_from_rotation(joint.origin[:3, :3]))
        kind = "prismatic" if joint.prismatic else "continuous"
        parent, child = model.links[joint.parent].name, model.links[i + 1].name
        lines += [
            f'<joint name={quoteattr(joint.name)} type="{kind}">'
            f"<origin xyz={_xyz(joint.origin[:3, 3])} rpy={_xyz(np.array(rpy_from_rotation(rotation)))}/>",
            f"<parent link={quoteattr(parent)}/><child link={quoteattr(child)}/><axis xyz={_xyz(joint.axis)}/>",
            '<limit lower="-1e9" upper="1e9" effort="1e9" velocity="1e9"/>' if joint.prismatic else "",
            "</joint>",
        ]
    return "\n".join([*lines, "</robot>", ""])


def _xyz(vector: Array) -> str:
    return '"' + " ".join(repr(float(v)) for v in vector) + '"'
