"""The collision shapes of a SDF as contact spheres, read from the file: Drake takes no STL as what touches."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from realitygap_engines.errors import ModelError
from realitygap_engines.model.contact import (
    corner_spheres,
    find_mesh,
    inset_box,
    inset_cylinder,
    inset_mesh,
    inset_points,
)
from realitygap_engines.model.robot import Array, Sphere, rotation_from_rpy

SIGNS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)


def spheres_of(
    path: Path, name: str, parts: Sequence[tuple[ET.Element, Array]], packages: Mapping[str, Path]
) -> tuple[tuple[Sphere, ...], list[str]]:
    """The contact spheres of a link, and sentences on what is only nearly the same shape.

    Args:
        path: the SDF.
        name: the link's, for messages.
        parts: SDF's links in it and their poses (4, 4) in its frame.
        packages: where `model://NAME/` and `package://NAME/` lie.

    Raises:
        ModelError: for a shape that cannot move, a mesh that is missing, or a pose in another frame than the link's.
    """
    spheres, corners, notes = list[Sphere](), list[Array](), list[str]()
    for link, pose in parts:
        for collision in link.findall("collision"):
            at = pose @ _pose(path, link.get("name", ""), collision.find("pose"))
            shape = next(iter(collision.find("geometry") or ()), None)
            kind = "shape of no kind" if shape is None else shape.tag
            if shape is None or kind == "empty":
                continue
            if kind == "sphere":
                spheres.append(Sphere(at[:3, 3].copy(), _number(path, shape, "radius")))
            elif kind == "capsule":
                half = _number(path, shape, "length") / 2 * at[:3, 2]
                spheres += [Sphere(at[:3, 3] + side * half, _number(path, shape, "radius")) for side in (-1, 1)]
            else:
                points, said = _corners(path, name, shape, packages)
                notes += said
                corners.append(points @ at[:3, :3].T + at[:3, 3])
    return (*spheres, *corner_spheres(corners)), notes


def _corners(path: Path, name: str, shape: ET.Element, packages: Mapping[str, Path]) -> tuple[Array, list[str]]:
    """The corners of a shape in its own frame, moved inwards. Shape (k, 3)."""
    if shape.tag == "box":
        return inset_box(_numbers(path, shape, "size", 3) / 2), []
    if shape.tag == "cylinder":
        return inset_cylinder(_number(path, shape, "radius"), _number(path, shape, "length") / 2), []
    if shape.tag == "mesh":
        uri = shape.findtext("uri", "").strip().replace("model://", "package://")
        scale = _numbers(path, shape, "scale", 3) if shape.find("scale") is not None else 1.0
        return inset_mesh(path, name, find_mesh(path, name, uri, packages), scale), []
    if shape.tag == "ellipsoid":
        note = f"link {name}: an ellipsoid touches the ground as eight of its points"
        return inset_points(SIGNS * _numbers(path, shape, "radii", 3) / np.sqrt(3.0)), [note]
    raise ModelError(f"{path}: link {name} has a {shape.tag}, which cannot move and touch the ground")


def _pose(path: Path, link: str, pose: ET.Element | None) -> Array:
    """The pose (4, 4) of a collision in its link's frame."""
    out = np.eye(4)
    if pose is None:
        return out
    if pose.get("relative_to", "") not in ("", link) or pose.get("rotation_format", "euler_rpy") != "euler_rpy":
        raise ModelError(f"{path}: a collision of link {link} has no pose of x y z roll pitch yaw in the link's frame")
    found = _read(path, f"pose of a collision of link {link}", pose.text, 6)
    turn = np.deg2rad(found[3:]) if pose.get("degrees") == "true" else found[3:]
    out[:3, :3], out[:3, 3] = rotation_from_rpy(*turn), found[:3]
    return out


def _number(path: Path, shape: ET.Element, key: str) -> float:
    return float(_numbers(path, shape, key, 1)[0])


def _numbers(path: Path, shape: ET.Element, key: str, count: int) -> Array:
    return _read(path, f"{key} of a {shape.tag}", shape.findtext(key), count)


def _read(path: Path, what: str, text: str | None, count: int) -> Array:
    try:
        found = np.array([float(word) for word in (text or "").split()])
    except ValueError:
        found = np.empty(0)
    if len(found) != count or not np.isfinite(found).all():
        raise ModelError(f"{path}: {what}: found {(text or '').strip() or 'nothing'}, expected {count} numbers")
    return found
