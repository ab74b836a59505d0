"""Contact geometry that every engine has: spheres on the corners of a link's convex hull.

Against a plane a convex body touches with its vertices only, so small spheres there are the same body, and every
engine then sees nothing but sphere-plane contacts, which they all treat alike.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from realitygap_engines.errors import ModelError
from realitygap_engines.model.quiet import quiet
from realitygap_engines.model.robot import Array, Sphere

if TYPE_CHECKING:
    import yourdfpy

RADIUS = 1e-3
"""Radius of a corner sphere [m]; its centre is moved inwards, so that the surface stays where it was."""
MANY = 8
"""More corners than this on one link are thinned to those nearest the corners of its oriented bounding box."""


def contact_spheres(
    path: Path, link: str, shapes: list[tuple[yourdfpy.Collision, Array]], packages: Mapping[str, Path]
) -> tuple[Sphere, ...]:
    """The contact spheres of one link, from its collision shapes and their poses (4, 4) in the link frame.

    Raises:
        ModelError: for a mesh that cannot be found or read.
    """
    spheres: list[Sphere] = []
    corners: list[Array] = []
    for collision, pose in shapes:
        geometry = collision.geometry
        if geometry.sphere is not None:
            spheres.append(Sphere(pose[:3, 3].copy(), float(geometry.sphere.radius)))
            continue
        if geometry.box is not None:
            points = inset_box(np.asarray(geometry.box.size, dtype=float) / 2)
        elif geometry.cylinder is not None:
            points = inset_cylinder(float(geometry.cylinder.radius), float(geometry.cylinder.length) / 2)
        elif geometry.mesh is not None:
            file = find_mesh(path, link, geometry.mesh.filename, packages)
            points = inset_mesh(path, link, file, geometry.mesh.scale if geometry.mesh.scale is not None else 1.0)
        else:
            continue
        corners.append(points @ pose[:3, :3].T + pose[:3, 3])
    return (*spheres, *corner_spheres(corners))


def corner_spheres(corners: list[Array]) -> tuple[Sphere, ...]:
    """Spheres on the corners of the convex hull of points (k, 3), given by shape, that were moved inwards already."""
    return tuple(Sphere(point, RADIUS) for point in _hull(np.vstack(corners))) if corners else ()


def inset_box(half: Array) -> Array:
    """The corners of a box of half sizes (3,), moved inwards by the radius of a corner sphere. Shape (8, 3)."""
    inner = np.maximum(half - RADIUS, 0.0)
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    return signs * inner


def inset_cylinder(radius: float, half: float) -> Array:
    """Eight points on each rim of a cylinder along z of that half length, moved inwards likewise. Shape (16, 3)."""
    angles = np.arange(8) * np.pi / 4
    ring = max(radius - RADIUS, 0.0) * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(8)])
    rise = np.array([0.0, 0.0, max(half - RADIUS, 0.0)])
    return np.vstack([ring + rise, ring - rise])


def inset_mesh(path: Path, link: str, file: Path, scale: float | Array) -> Array:
    """The corners of a mesh's convex hull, moved inwards likewise; path and link are for messages.

    Raises:
        ModelError: for a mesh that cannot be read or has no volume.
    """
    import trimesh  # a third of a second to load, for robots with meshes alone

    try:
        with quiet("trimesh"):  # what it complains about is said here
            loaded = trimesh.load(file, force="mesh")
        vertices = np.asarray(loaded.vertices, dtype=float)
    except Exception as error:
        raise ModelError(f"{path}: mesh {file} of link {link} cannot be read ({error})") from None
    vertices = vertices * np.asarray(scale, dtype=float)
    if len(vertices) < 4 or not np.isfinite(vertices).all():
        raise ModelError(f"{path}: mesh {file} of link {link} has no volume")
    return inset_points(vertices)


def inset_points(vertices: Array) -> Array:
    """The corners of the convex hull of points (k, 3), moved towards its middle by the radius of a corner sphere."""
    vertices = _hull(vertices)
    inwards = vertices.mean(axis=0) - vertices
    return np.asarray(vertices + RADIUS * inwards / np.linalg.norm(inwards, axis=1, keepdims=True))


def find_mesh(path: Path, link: str, filename: str, packages: Mapping[str, Path]) -> Path:
    """The file of a mesh; `package://NAME/` is looked for in `packages`, then beside and above the URDF."""
    if filename.startswith("package://"):
        package, _, rest = filename.removeprefix("package://").partition("/")
        places = [packages[package] / rest] if package in packages else []
        places += [folder / package / rest for folder in path.resolve().parents]
    else:
        places = [path.parent / filename.removeprefix("file://")]
    for place in places:
        if place.is_file():
            return place
    hint = " (say where a package lies under robot: packages:)" if filename.startswith("package://") else ""
    raise ModelError(f"{path}: mesh {filename} of link {link} was not found; expected it at {places[0]}{hint}")


def _hull(points: Array) -> Array:
    """The corners of the convex hull; of many, those that are extreme along a diagonal of the bounding box."""
    try:
        points = points[np.sort(ConvexHull(points).vertices)]
    except (QhullError, ValueError):
        points = np.unique(points, axis=0)  # flat or degenerate: every point may touch
    if len(points) > MANY:
        import trimesh

        with quiet("trimesh"):
            to_box, extents = trimesh.bounds.oriented_bounds(points)
        local = (points @ to_box[:3, :3].T + to_box[:3, 3]) / extents
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
        points = points[np.unique((signs @ local.T).argmax(axis=1))]
    return np.asarray(points)
