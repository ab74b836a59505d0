"""The links of a URDF as they are written: inertials unchecked, collision geometry, and poses at zero."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from defusedxml.common import DefusedXmlException
from realitygap_engines.errors import ModelError
from realitygap_engines.model.contact import find_mesh
from realitygap_engines.model.inertial_editor import UrdfText, urdf_text
from realitygap_engines.model.quiet import quiet
from realitygap_engines.model.robot import rotation_from_rpy

from realitygap.bench.estimate import Array
from realitygap.files.errors import InputError


@dataclass(frozen=True)
class UrdfLink:
    """A link: `mass` [kg], `com` (3,) [m] and `inertia` (3, 3) [kg·m²] about it, in link axes.

    `points` (n, 3) [m] are the corners of its collision geometry in the link frame, none where n is 0; `pose` (4, 4) is
    the link in the root's frame with all joints at zero.
    """

    name: str
    mass: float
    com: Array
    inertia: Array
    points: Array
    pose: Array


@dataclass(frozen=True)
class UrdfFile:
    """A URDF: its text that can be edited, and the links that have a mass."""

    path: Path
    text: UrdfText
    links: dict[str, UrdfLink]


def read_urdf_links(path: Path, packages: Mapping[str, Path]) -> UrdfFile:
    """The links of a URDF that have a mass.

    Raises:
        InputError: for a file that is not a URDF, or geometry that cannot be found.
    """
    try:
        text = path.read_text(encoding="utf-8")
        parsed = urdf_text(text)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); expected a URDF") from None
    except DefusedXmlException as error:
        raise InputError(f"{path}: XML entities are not accepted in a URDF ({type(error).__name__})") from None
    except (ET.ParseError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: is not well-formed XML ({error}); expected a URDF") from None
    root = parsed.root
    if root.tag != "robot" or "xacro:" in text:
        raise InputError(f"{path}: is not a URDF; expected <robot> without xacro (expand it: xacro FILE > OUT)")
    poses = _poses(path, root)
    links = {}
    for element in root.findall("link"):
        name = element.get("name", "")
        inertial = element.find("inertial")
        if inertial is None:
            continue
        if name in links:
            raise InputError(f"{path}: link {name} is defined twice")
        links[name] = _link(path, name, element, inertial, poses.get(name, np.eye(4)), packages)
    if not links:
        raise InputError(f"{path}: no link has an <inertial>; nothing to check")
    return UrdfFile(path, parsed, links)


def _link(
    path: Path, name: str, element: ET.Element, inertial: ET.Element, pose: Array, packages: Mapping[str, Path]
) -> UrdfLink:
    mass, tensor = inertial.find("mass"), inertial.find("inertia")
    if mass is None or tensor is None:
        raise InputError(f"{path}: link {name}: <inertial> has no <{'mass' if mass is None else 'inertia'}>")

    def entry(key: str) -> float:
        return _number(path, f"link {name}: {key}", tensor.get(key, ""))

    xx, xy, xz, yy, yz, zz = (entry(k) for k in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))
    origin = _origin(path, inertial)
    turn = origin[:3, :3]
    inertia = turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.T
    points = [_corners(path, name, c, packages) for c in element.findall("collision")]
    value = _number(path, f"link {name}: mass", mass.get("value", ""))
    return UrdfLink(name, value, origin[:3, 3], inertia, np.vstack([np.zeros((0, 3)), *points]), pose)


def _number(path: Path, what: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise InputError(f"{path}: {what} is {text!r}, expected a finite number")
    return value


def _vector(path: Path, text: str, what: str) -> Array:
    values = np.array([_number(path, what, word) for word in text.split()])
    if len(values) != 3:
        raise InputError(f"{path}: {what} is {text!r}, expected three numbers")
    return values


def _origin(path: Path, element: ET.Element) -> Array:
    """The pose (4, 4) of an element with an <origin>."""
    pose = np.eye(4)
    origin = element.find("origin")
    if origin is not None:
        pose[:3, :3] = rotation_from_rpy(*_vector(path, origin.get("rpy", "0 0 0"), "origin rpy"))
        pose[:3, 3] = _vector(path, origin.get("xyz", "0 0 0"), "origin xyz")
    return pose


def _corners(path: Path, name: str, collision: ET.Element, packages: Mapping[str, Path]) -> Array:
    """Points whose convex hull is the collision shape, in the link frame."""
    shape = next(iter(collision.findall("geometry/*")), None)
    if shape is None:
        return np.zeros((0, 3))
    if shape.tag == "box":
        points = _vector(path, shape.get("size", ""), f"link {name}: box size") / 2 * _SIGNS
    elif shape.tag == "sphere":
        radius = _number(path, f"link {name}: radius", shape.get("radius", ""))
        points = np.asarray(trimesh.creation.icosphere(subdivisions=3, radius=radius).vertices)
    elif shape.tag in ("cylinder", "capsule"):
        radius = _number(path, f"link {name}: radius", shape.get("radius", ""))
        half = _number(path, f"link {name}: length", shape.get("length", "")) / 2
        angle = np.arange(32) * np.pi / 16
        ring = radius * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
        points = np.vstack([ring + np.array([0, 0, half]), ring - np.array([0, 0, half])])
    else:
        try:
            file = find_mesh(path, name, shape.get("filename", ""), packages)
            with quiet("trimesh"):  # what it complains about is said here
                mesh = trimesh.load(file, force="mesh")
        except ModelError as error:
            raise InputError(str(error)) from None
        except Exception as error:
            raise InputError(f"{path}: the mesh of link {name} cannot be read ({error})") from None
        points = np.asarray(mesh.vertices) * _vector(path, shape.get("scale", "1 1 1"), f"link {name}: mesh scale")
    pose = _origin(path, collision)
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])


_SIGNS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)


def _poses(path: Path, root: ET.Element) -> dict[str, Array]:
    """The pose of every link in its root's frame, all joints at zero."""
    above: dict[str, tuple[str, Array]] = {}
    for joint in root.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is not None and child is not None:
            above[child.get("link", "")] = (parent.get("link", ""), _origin(path, joint))
    poses = {}
    for element in root.findall("link"):
        name, pose, seen = element.get("name", ""), np.eye(4), set[str]()
        while name in above and name not in seen:
            seen.add(name)
            name, origin = above[name]
            pose = origin @ pose
        poses[element.get("name", "")] = pose
    return poses
