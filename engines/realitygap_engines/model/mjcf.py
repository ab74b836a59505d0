"""Reading a MJCF file, as MuJoCo's own parser compiles it, into the canonical `Model`.

A link's frame is the frame of its MJCF body, moved to the joint's position; joint angles are MJCF's own (`ref`
included). With a fixed base link 0 carries the frame of MuJoCo's world, and all that is fixed to it.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from realitygap_engines.errors import ModelError
from realitygap_engines.model.inertia import FixedBody, lump
from realitygap_engines.model.mimics import resolved
from realitygap_engines.model.mjcf_actuators import read_actuators, reflected
from realitygap_engines.model.mjcf_file import compile_mjcf
from realitygap_engines.model.mjcf_losses import losses, read_mimics, refuse_loops
from realitygap_engines.model.mjcf_shapes import Shapes, spheres_of
from realitygap_engines.model.robot import (
    Array,
    Joint,
    Link,
    Model,
    axis_rotation,
    rotation_from_quaternion,
)
from realitygap_engines.model.touching import touching


def read_mjcf(path: Path, *, floating: bool, contact_links: list[str] | None = None) -> Model:
    """The canonical model of a MJCF file.

    Args:
        path: the file; what it includes lies beside it.
        floating: whether the base moves freely. It is the body with a free joint, or else the only body that moves; a
            free joint of a robot whose base is fixed is held.
        contact_links: bodies whose shapes touch the ground (default: the base and the leaves).

    Raises:
        ModelError: for a file that MuJoCo cannot read or a robot that cannot be simulated, in one sentence.
    """
    m = compile_mjcf(path)
    roots, left_out = _roots(path, m, floating)
    tree = _Tree(path, m, roots, floating)
    if not floating and not tree.joints:
        raise ModelError(f"{path}: nothing can move: the robot has no moving joint and a fixed base")
    notes = [f"body {_name(m, b)} and what moves with it is not part of the robot and left out" for b in left_out]
    notes += [f"the free joint of body {_name(m, b)} is held: robot.base is fixed" for b in tree.held]
    refuse_loops(path, m, set(tree.of_body))
    links: list[Link] = []
    for i, parts in enumerate(tree.parts):
        link, mended = lump(path, parts, moves=i > 0 or floating, root=i == 0)
        links.append(link)
        notes += mended
    names = {number: joint.name for number, joint in zip(tree.numbers, tree.joints, strict=True)}
    drives = read_actuators(m, names)
    armature, damping = reflected(m, "armature"), reflected(m, "damping")
    joints = [
        replace(
            joint,
            effort=min(joint.effort, drives.limits.get(joint.name, np.inf)),
            armature=joint.armature + armature.get(number, 0.0),
            damping=joint.damping + damping.get(number, 0.0),
        )
        for number, joint in zip(tree.numbers, tree.joints, strict=True)
    ]
    mimics = read_mimics(path, m, names)
    joints = list(resolved(path, [replace(joint, mimic=mimics.get(joint.name)) for joint in joints]))
    touch = touching(path, links, joints, contact_links)
    final = []
    for link, shapes in zip(links, tree.shapes, strict=True):
        spheres, rough = spheres_of(path, m, link.name, shapes) if link.name in touch else ((), [])
        notes += rough
        notes += [f"link {link.name} does not touch the ground"] if shapes and touch and link.name not in touch else []
        final.append(replace(link, spheres=spheres))
    notes += [*losses(m, set(tree.of_body), names), *drives.notes]
    return Model(
        m.names[: m.names.find(b"\0")].decode(), tuple(final), tuple(joints), floating, tuple(notes), drives.actuators
    )


def _roots(path: Path, m: Any, floating: bool) -> tuple[list[int], list[int]]:
    """The bodies in the world that are the robot, and those that are not."""
    tops = [b for b in range(1, m.nbody) if m.body_parentid[b] == 0]
    free = {b for b in tops if _kinds(m, b) == ["free"]}
    moving = {int(m.body_rootid[b]) for b in range(1, m.nbody) if {"hinge", "slide", "ball"} & set(_kinds(m, b))}
    if not floating and moving - free:
        return [b for b in tops if b not in free], [b for b in tops if b in free]
    candidates = [c for c in (free & moving, free, moving, set(tops)) if c][: 1 if floating or free else 0]
    if not candidates:
        raise ModelError(f"{path}: nothing can move: the robot has no moving joint and a fixed base")
    if len(candidates[0]) > 1:
        found = ", ".join(_name(m, b) for b in sorted(candidates[0]))
        raise ModelError(f"{path}: expected one robot whose base moves, found {found}")
    return list(candidates[0]), [b for b in tops if b not in candidates[0]]


def _kinds(m: Any, body: int) -> list[str]:
    first = int(m.body_jntadr[body])
    return [("free", "ball", "slide", "hinge")[m.jnt_type[j]] for j in range(first, first + int(m.body_jntnum[body]))]


def _name(m: Any, body: int) -> str:
    return m.body(body).name or f"body {body}"


@dataclass
class _Place:
    """Where a body is: the link that carries it, and its pose (4, 4) there."""

    link: int
    pose: Array


class _Tree:
    """The bodies of the robot gathered into links.

    Attributes:
        parts: of every link, the bodies that it is made of.
        shapes: of every link, its geoms and their poses.
        joints, numbers: the joints, and MuJoCo's numbers of them.
        of_body: where each body is, by MuJoCo's number.
        held: bodies whose free joint is held.
    """

    def __init__(self, path: Path, m: Any, roots: list[int], floating: bool) -> None:
        self.path, self.m = path, m
        self.parts: list[list[FixedBody]] = [[]]
        self.shapes: list[Shapes] = [[]]
        self.joints: list[Joint] = []
        self.numbers: list[int] = []
        self.of_body: dict[int, _Place] = {}
        self.held: list[int] = []
        for b in range(1, m.nbody):
            kinds, parent = _kinds(m, b), int(m.body_parentid[b])
            pose = _pose(m.body_pos[b], m.body_quat[b])
            if b in roots:
                self.held += [b] if "free" in kinds and not floating else []
                if floating and set(kinds) <= {"free"}:
                    self._fix(b, _Place(0, np.eye(4)))
                    continue
                if floating:
                    raise ModelError(
                        f"{path}: body {_name(m, b)} hangs on the world by a {kinds[0]} joint; expected a free joint, "
                        "or robot.base fixed"
                    )
                above = _Place(0, np.eye(4))
            elif parent in self.of_body:
                above = self.of_body[parent]
            else:
                continue
            here = _Place(above.link, above.pose @ pose)
            if kinds in ([], ["free"]):
                self._fix(b, here)
            else:
                self._join(b, here, kinds)
        if not self.parts[0]:  # every root moves: nothing stands in the world
            self.parts[0] = [FixedBody("world", None, np.zeros(3), np.zeros((3, 3)))]

    def _fix(self, b: int, place: _Place) -> None:
        m = self.m
        self.of_body[b] = place
        middle = place.pose @ _pose(m.body_ipos[b], m.body_iquat[b])
        turn = middle[:3, :3]
        tensor = turn @ np.diag(m.body_inertia[b]) @ turn.T
        self.parts[place.link].append(FixedBody(_name(m, b), float(m.body_mass[b]), middle[:3, 3], tensor))
        for g in range(int(m.body_geomadr[b]), int(m.body_geomadr[b]) + int(m.body_geomnum[b])):
            if m.geom_contype[g] or m.geom_conaffinity[g]:
                self.shapes[place.link].append((g, place.pose @ _pose(m.geom_pos[g], m.geom_quat[g])))

    def _join(self, b: int, here: _Place, kinds: list[str]) -> None:
        """Begin a link at a body that moves by one joint."""
        m, first = self.m, int(self.m.body_jntadr[b])
        name = _name(m, b)
        if len(kinds) > 1:
            raise ModelError(
                f"{self.path}: body {name} has {len(kinds)} joints; expected one, and a body with mass between each two"
            )
        if kinds == ["ball"]:
            raise ModelError(f"{self.path}: body {name} has a ball joint; expected hinge and slide joints")
        slides = kinds == ["slide"]
        axis, limited = np.array(m.jnt_axis[first]), bool(m.jnt_limited[first])
        zero = float(m.qpos0[m.jnt_qposadr[first]])
        back, shift = np.eye(4), np.eye(4)  # to q = 0 from the pose in which the file shows the body
        if slides:
            back[:3, 3] = -zero * axis
        else:
            shift[:3, 3] = m.jnt_pos[first]
            back[:3, :3] = axis_rotation(axis, -zero)
        dof = int(m.jnt_dofadr[first])
        force = m.jnt_actfrcrange[first]
        self.joints.append(
            Joint(
                name=m.joint(first).name or f"{name} joint",
                prismatic=slides,
                parent=here.link,
                origin=here.pose @ shift @ back,
                axis=axis,
                lower=float(m.jnt_range[first, 0]) if limited else -np.inf,
                upper=float(m.jnt_range[first, 1]) if limited else np.inf,
                effort=float(np.abs(force).max()) if m.jnt_actfrclimited[first] else np.inf,
                friction=float(m.dof_frictionloss[dof]),
                damping=float(m.dof_damping[dof]),
                armature=float(m.dof_armature[dof]),
            )
        )
        self.numbers.append(first)
        self.parts.append([])
        self.shapes.append([])
        self._fix(b, _Place(len(self.joints), _shifted(-shift[:3, 3])))


def _shifted(position: Array) -> Array:
    pose = np.eye(4)
    pose[:3, 3] = position
    return pose


def _pose(position: Array, quaternion: Array) -> Array:
    pose = np.eye(4)
    pose[:3, :3] = rotation_from_quaternion(np.asarray(quaternion, dtype=float))
    pose[:3, 3] = position
    return pose
