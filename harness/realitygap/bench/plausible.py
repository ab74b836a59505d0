"""Which inertials no body, or no likely body, can have, given its mass and its collision geometry."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import trimesh
from scipy.spatial import ConvexHull, QhullError

from realitygap.bench.estimate import Array
from realitygap.bench.urdf_links import UrdfLink

OUTSIDE = 2e-3
"""A centre of mass this far [m] outside the geometry is still taken for inside: collision shapes are simplified."""
SLENDER = 1.3
"""A body whose inertia box is this much longer than it is wide has a direction to compare."""
TURNED = 30.0
"""Angle [°] between the long axes of inertia and geometry from which the tensor counts as turned."""
SMALL = 0.25
"""Share of the uniform body's moment below which a tensor counts as too small for the mass."""
DENSE = 2700.0
"""Solid aluminium [kg/m³]."""


@dataclass(frozen=True)
class Doubt:
    """What is wrong with a link. `impossible`: no body can have it, else no likely one; `tensor`: the inertia."""

    link: str
    impossible: bool
    tensor: bool
    what: str


@dataclass(frozen=True)
class Form:
    """The convex hull of a link's geometry as a body of uniform density with mass 1.

    `volume` [m³], `center` (3,) [m], `solid` and `shell` (3, 3) [m²]: the inertia about the centre with the mass in the
    volume and in the surface; `planes` (n, 4): outward normals and offsets.
    """

    volume: float
    center: Array
    solid: Array
    shell: Array
    planes: Array


def body(points: Array) -> Form | None:
    """The body of a point set; None where it has no volume."""
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    mesh = trimesh.convex.convex_hull(points)
    corners = np.asarray(mesh.triangles)
    area = np.asarray(mesh.area_faces) / mesh.area
    middle = corners.mean(axis=1)
    center = area @ middle
    # exact second moment of a triangle: (sum of corner and nine times middle products) / 12
    products = np.einsum("fki,fkj->fij", corners - center, corners - center)
    products += 9 * np.einsum("fi,fj->fij", middle - center, middle - center)
    second = np.einsum("f,fij->ij", area, products) / 12
    shell = np.trace(second) * np.eye(3) - second
    solid = np.asarray(mesh.moment_inertia) / mesh.volume
    return Form(float(mesh.volume), np.asarray(mesh.center_mass), solid, shell, hull.equations)


def spread(inertia: Array) -> tuple[Array, Array]:
    """Second moments ∫(u·x)² dm along the principal axes, ascending, and the axes as columns."""
    moments, axes = np.linalg.eigh(np.trace(inertia) / 2 * np.eye(3) - inertia)
    return moments, axes


def inertia_box(mass: float, inertia: Array) -> tuple[Array, Array]:
    """Edge lengths [m] of the uniform box with this inertia, ascending, and its axes as columns."""
    moments, axes = spread(inertia)
    return np.sqrt(12 * np.maximum(moments, 0) / mass), axes


def doubts(link: UrdfLink) -> list[Doubt]:
    """All that is wrong with a link's inertial."""
    found: list[Doubt] = []

    def add(impossible: bool, tensor: bool, what: str) -> None:
        found.append(Doubt(link.name, impossible, tensor, what))

    if not link.mass > 0:
        add(True, False, f"the mass is {link.mass:g} kg")
        return found
    moments = np.linalg.eigvalsh(link.inertia)
    if not np.any(link.inertia):
        add(True, True, f"{link.mass:g} kg have no inertia at all: only a point is like that")
        return found
    if moments[0] <= 0 or moments[0] + moments[1] < moments[2] * (1 - 1e-9):
        text = ", ".join(f"{m:.3g}" for m in moments)
        add(True, True, f"no body has the principal moments {text} kg·m² (one exceeds the other two together)")
        return found
    form = body(link.points)
    if form is None:
        return found
    depth = float(np.max(form.planes[:, :3] @ link.com + form.planes[:, 3]))
    if depth > OUTSIDE:
        add(True, False, f"the centre of mass lies {depth * 1e3:.0f} mm outside the collision geometry")
    if link.mass / form.volume > DENSE:
        add(False, False, f"{link.mass / form.volume:.0f} kg/m³ is denser than solid aluminium")
    _bounds(link, form, depth > OUTSIDE, add)
    return found


def _bounds(link: UrdfLink, form: Form, outside: bool, add: Callable[[bool, bool, str], None]) -> None:
    """Compare the inertia with what the geometry allows, its size with shell and solid, its axis with the shape's."""
    second, axes = spread(link.inertia)
    along = link.points @ axes
    low, high = along.min(axis=0), along.max(axis=0)
    middle = link.com @ axes
    # a mass within [low, high] with this mean has at most the variance of two lumps at the ends (Bhatia and Davis 2000)
    limit = ((high - low) / 2) ** 2 if outside else (high - middle) * (middle - low)
    ratio = second / (link.mass * np.maximum(limit, 1e-12))
    if ratio.max() > 1:
        add(
            True,
            True,
            f"the inertia is {ratio.max():.1f} times what that mass can have within the geometry, even with all of it "
            "at the ends",
        )
    mine = np.linalg.eigvalsh(link.inertia) / link.mass
    shell = mine / np.linalg.eigvalsh(form.shell)
    solid = mine / np.linalg.eigvalsh(form.solid)
    if ratio.max() <= 1 and shell.max() > 1.1:
        add(
            False,
            True,
            f"the inertia is too large: {shell.max():.1f} times that of a thin shell of this shape and mass "
            f"({solid.max():.1f} times the solid's)",
        )
    if solid.min() < SMALL:
        add(False, True, f"the inertia is too small for the mass: {solid.min():.2f} of the uniform body's")
    box, turn = inertia_box(link.mass, link.inertia)
    form_box, form_turn = inertia_box(1.0, form.solid)
    angle = float(np.degrees(np.arccos(min(1.0, abs(float(turn[:, 2] @ form_turn[:, 2]))))))
    if box[2] > SLENDER * box[1] and form_box[2] > SLENDER * form_box[1] and angle > TURNED:
        add(False, True, f"the inertia is turned: its long axis is {angle:.0f}° off the geometry's")
