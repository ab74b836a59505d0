"""Reading a SDF file, as Drake's parser has it, into the canonical `Model`.

Drake resolves SDF's frames and poses; dry friction, mimics and shapes, which it drops, are taken from the file. A
link's frame is that of its joint, which in SDF is its own unless the joint has a pose.
"""

import importlib.util
import logging
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import defusedxml.ElementTree
import numpy as np

from realitygap_engines.errors import ModelError
from realitygap_engines.model.inertia import FixedBody, lump
from realitygap_engines.model.mimics import resolved
from realitygap_engines.model.robot import Array, Joint, Link, Mimic, Model
from realitygap_engines.model.sdf_shapes import spheres_of
from realitygap_engines.model.touching import touching

KINDS = {"weld": None, "revolute": False, "prismatic": True}
"""Drake's names of joints that a model has, and whether they slide."""
SAID = {"multiplier": "1", "offset": "0", "reference": "0"}
"""What a mimic says, and what it means where it does not."""


def read_sdf(
    path: Path, *, floating: bool, packages: Mapping[str, Path] | None = None, contact_links: list[str] | None = None
) -> Model:
    """The canonical model of a SDF file with one robot. Arguments as of `read_urdf`; where `contact_links` is empty,
    nothing touches the ground, and meshes may be missing.

    Raises:
        ModelError: where Drake is not installed or cannot read the file, or for a robot that cannot be simulated.
    """
    joints, root = _joints_of(path, packages or {})
    friction, mimics = _friction(path), _mimics(path)
    below: dict[str, list[Any]] = {}
    for joint in joints:
        below.setdefault(joint.parent_body().name(), []).append(joint)
    names = {body.name() for joint in joints for body in (joint.parent_body(), joint.child_body())} | {root.name()}
    if floating or "world" not in names or not _moves(below, "world"):
        start = root
    else:
        start = joints[0].parent_body().GetParentPlant().world_body()
    links: list[Link] = []
    made: list[Joint] = []
    carried: list[list[tuple[Any, Array]]] = []
    notes: list[str] = []
    todo: list[tuple[Any, Array, Any, int]] = [(start, np.eye(4), None, -1)]
    while todo:
        body, pose, joint, parent = todo.pop()
        if joint is not None:
            made.append(replace(_joint(path, joint, pose, parent, friction), mimic=mimics.get(joint.name())))
            pose = _inverse(_pose(joint.frame_on_child()))
        index, parts, inner = len(links), [_part(body, pose)], [(body, pose)]
        branches: list[tuple[Any, Array, Any, int]] = []
        fixed = [(body, pose)]
        while inner:
            at, where = inner.pop()
            for next_joint in below.get(at.name(), []):
                here = where @ _pose(next_joint.frame_on_parent())
                child = next_joint.child_body()
                if _kind(path, next_joint) is None:
                    place = here @ _inverse(_pose(next_joint.frame_on_child()))
                    parts.append(_part(child, place))
                    inner.append((child, place))
                    fixed.append((child, place))
                else:
                    branches.append((child, here, next_joint, index))
        link, mended = lump(path, parts, moves=index > 0 or floating, root=index == 0)
        links.append(link)
        carried.append(fixed)
        notes += mended
        todo += reversed(branches)
    if not floating and not made:
        raise ModelError(f"{path}: nothing can move: the robot has no moving joint and a fixed base")
    touch = touching(path, links, made, contact_links)
    elements = {element.get("name", ""): element for element in _tree(path).iter("link")}
    for i, link in enumerate(links):
        if link.name in touch:
            placed = [(elements[body.name()], place) for body, place in carried[i] if body.name() in elements]
            spheres, said = spheres_of(path, link.name, placed, packages or {})
            links[i] = replace(link, spheres=spheres)
            notes += said
    return Model(path.stem, tuple(links), resolved(path, made), floating, tuple(notes))


def _joints_of(path: Path, packages: Mapping[str, Path]) -> tuple[list[Any], Any]:
    """Drake's joints, and the body that all others hang on."""
    if importlib.util.find_spec("pydrake") is None:
        raise ModelError(f"{path}: is a SDF file, which Drake reads; install it with: pip install drake")
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    plant = MultibodyPlant(0.0)
    parser = Parser(plant)
    for name, folder in packages.items():
        parser.package_map().Add(name, str(folder))
    log = logging.getLogger("drake")
    level = log.level
    log.setLevel(logging.ERROR)  # it warns of what is said here
    try:
        parser.AddModels(str(path.absolute()))
    except (RuntimeError, ValueError) as error:
        raise ModelError(f"{path}: is not a SDF file that Drake takes ({' '.join(str(error).split())})") from None
    finally:
        log.setLevel(level)
    joints = [plant.get_joint(i) for i in plant.GetJointIndices()]
    children = {joint.child_body().name() for joint in joints if joint.parent_body().name() != "world"}
    bodies = [plant.get_body(i) for i in plant.GetBodyIndices(plant.GetModelInstanceByName(_model(path)))]
    roots = [body for body in bodies if body.name() not in children]
    if len(roots) != 1:
        found = ", ".join(body.name() for body in roots) or "none"
        raise ModelError(f"{path}: expected one root link, found {found}")
    return joints, roots[0]


def _tree(path: Path) -> ET.Element:
    root: ET.Element = defusedxml.ElementTree.fromstring(path.read_bytes())
    return root


def _model(path: Path) -> str:
    try:
        models = _tree(path).findall(".//model")
    except (ET.ParseError, ValueError, OSError) as error:
        raise ModelError(f"{path}: is not well-formed XML ({error}); expected a SDF") from None
    if len(models) != 1:
        raise ModelError(f"{path}: expected one model, found {len(models)}")
    return models[0].get("name", "")


def _friction(path: Path) -> dict[str, float]:
    found = {j.get("name", ""): j.findtext("axis/dynamics/friction") for j in _tree(path).iter("joint")}
    return {name: float(text) for name, text in found.items() if text}


def _mimics(path: Path) -> dict[str, Mimic]:
    """What mimics: position = multiplier·(the other's − reference) + offset (SDF 1.11)."""
    out = {}
    for joint in _tree(path).iter("joint"):
        mimic = joint.find("axis/mimic")
        if mimic is not None:
            try:
                words = (mimic.findtext(key) or default for key, default in SAID.items())
                multiplier, offset, reference = (float(word) for word in words)
            except ValueError as error:
                raise ModelError(f"{path}: joint {joint.get('name')} mimics by no number ({error})") from None
            out[joint.get("name", "")] = Mimic(mimic.get("joint", ""), multiplier, offset - multiplier * reference)
    return out


def _moves(below: Mapping[str, list[Any]], name: str) -> bool:
    return any(joint.type_name() != "weld" for joint in below.get(name, []))


def _kind(path: Path, joint: Any) -> bool | None:
    if joint.type_name() not in KINDS:
        raise ModelError(
            f"{path}: joint {joint.name()} is {joint.type_name()}; expected revolute, continuous, prismatic or fixed"
        )
    return KINDS[joint.type_name()]


def _joint(path: Path, joint: Any, origin: Array, parent: int, friction: Mapping[str, float]) -> Joint:
    slides = bool(_kind(path, joint))
    plant = joint.parent_body().GetParentPlant()
    motors = [plant.get_joint_actuator(i) for i in plant.GetJointActuatorIndices()]
    limits = [float(a.effort_limit()) for a in motors if a.joint().name() == joint.name()]
    return Joint(
        name=joint.name(),
        prismatic=slides,
        parent=parent,
        origin=origin,
        axis=np.array(joint.translation_axis() if slides else joint.revolute_axis()),
        lower=float(joint.position_lower_limits()[0]),
        upper=float(joint.position_upper_limits()[0]),
        effort=min(limits, default=np.inf),
        velocity=float(joint.velocity_upper_limits()[0]),
        friction=friction.get(joint.name(), 0.0),
        damping=float(joint.default_damping()),
    )


def _pose(frame: Any) -> Array:
    return np.array(frame.GetFixedPoseInBodyFrame().GetAsMatrix4())


def _inverse(pose: Array) -> Array:
    inverse = np.eye(4)
    inverse[:3, :3] = pose[:3, :3].T
    inverse[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return inverse


def link_frames(path: Path, packages: Mapping[str, Path] | None = None) -> dict[str, Array]:
    """The pose (4, 4) of the model's link frame in that of SDF's link, by the name of every link that a joint moves."""
    joints, _ = _joints_of(path, packages or {})
    moving = [joint for joint in joints if joint.type_name() != "weld"]
    return {joint.child_body().name(): _pose(joint.frame_on_child()) for joint in moving}


def _part(body: Any, pose: Array) -> FixedBody:
    """A body in the frame of the link that carries it."""
    if body.name() == "world":
        return FixedBody("world", None, np.zeros(3), np.zeros((3, 3)))
    inertial = body.default_spatial_inertia()
    mass, com, turn = float(inertial.get_mass()), np.array(inertial.get_com()), pose[:3, :3]
    about_origin = np.array(inertial.CalcRotationalInertia().CopyToFullMatrix3())
    about_com = about_origin - mass * (com @ com * np.eye(3) - np.outer(com, com))
    return FixedBody(body.name(), mass, turn @ com + pose[:3, 3], turn @ about_com @ turn.T)
