"""The geoms of a link as contact spheres: exact against a plane for spheres, capsules and whatever has corners."""

from pathlib import Path
from typing import Any

import numpy as np

from realitygap_engines.errors import ModelError
from realitygap_engines.model.contact import corner_spheres, inset_box, inset_cylinder, inset_points
from realitygap_engines.model.robot import Array, Sphere

Shapes = list[tuple[int, Array]]
"""MuJoCo's numbers of geoms, and their poses (4, 4) in the link's frame."""


def spheres_of(path: Path, m: Any, link: str, shapes: Shapes) -> tuple[tuple[Sphere, ...], list[str]]:
    """The contact spheres of a link, and sentences on what is only nearly the same shape."""
    import mujoco

    spheres: list[Sphere] = []
    corners: list[Array] = []
    notes = []
    for g, pose in shapes:
        kind, size = mujoco.mjtGeom(m.geom_type[g]).name, np.asarray(m.geom_size[g], dtype=float)
        if kind == "mjGEOM_SPHERE":
            spheres.append(Sphere(pose[:3, 3].copy(), float(size[0])))
            continue
        if kind == "mjGEOM_CAPSULE":
            spheres += [Sphere(pose[:3, 3] + end * size[1] * pose[:3, 2], float(size[0])) for end in (-1, 1)]
            continue
        if kind == "mjGEOM_BOX":
            points = inset_box(size)
        elif kind == "mjGEOM_CYLINDER":
            points = inset_cylinder(float(size[0]), float(size[1]))
        elif kind in ("mjGEOM_MESH", "mjGEOM_SDF"):
            first, count = int(m.mesh_vertadr[m.geom_dataid[g]]), int(m.mesh_vertnum[m.geom_dataid[g]])
            points = inset_points(np.asarray(m.mesh_vert[first : first + count], dtype=float))
        elif kind == "mjGEOM_ELLIPSOID":
            notes.append(f"link {link}: an ellipsoid touches the ground as eight of its points")
            signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
            points = inset_points(signs * size / np.sqrt(3.0))
        else:
            raise ModelError(f"{path}: link {link} has a {kind[7:].lower()}, which cannot move and touch the ground")
        corners.append(points @ pose[:3, :3].T + pose[:3, 3])
    return (*spheres, *corner_spheres(corners)), notes
