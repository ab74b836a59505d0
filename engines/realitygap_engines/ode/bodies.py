"""Joint-space inertia and bias of bodies that are held together by constraints (maximal coordinates).

Everything is taken from where the bodies are, in world axes, so that the result shows what an engine holds.
Newton and Euler for every body, projected onto the velocities that the joints leave free (Featherstone, Rigid Body
Dynamics Algorithms, 2008, section 3.2).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from realitygap_engines.model.robot import Array


@dataclass(frozen=True)
class Body:
    """A rigid body: `mass` [kg], `com` (3,) [m] and `inertia` (3, 3) [kg·m²] about it."""

    mass: float
    com: Array
    inertia: Array


@dataclass(frozen=True)
class Axis:
    """A joint between body `parent` and body number i + 1: a line through `anchor` (3,) [m] along `direction` (3,).

    The anchor is a point of the child, at which the parent's own motion carries it.
    """

    prismatic: bool
    parent: int
    anchor: Array
    direction: Array


def inertia_and_bias(
    bodies: Sequence[Body], axes: Sequence[Axis], origin: Array | None, speed: Array, gravity: Array
) -> tuple[Array, Array]:
    """M and c of M·a + c = effort, in the coordinates of `Simulation.mass_matrix`. Shapes (nv, nv) and (nv,).

    Args:
        bodies: the base first.
        axes: of all joints; parents come before children.
        origin: the point of a floating base whose velocity counts (3,); None for a fixed base.
        speed: the velocities. Shape (nv,).
        gravity: [m/s²]. Shape (3,).
    """
    first = 0 if origin is None else 6
    nv = first + len(axes)
    # of every body: the point that moves it, its acceleration without that of the coordinates, and what it depends on
    reference = [bodies[0].com if origin is None else origin]
    linear, angular = [np.zeros((3, nv))], [np.zeros((3, nv))]
    if first:
        linear[0][:, :3] = angular[0][:, 3:6] = np.eye(3)
    omega, alpha, acceleration = [angular[0] @ speed], [np.zeros(3)], [np.zeros(3)]
    for i, axis in enumerate(axes):
        p, column, rate = axis.parent, first + i, axis.direction * speed[first + i]
        arm = axis.anchor - reference[p]
        moved, turned = linear[p] + _cross(angular[p], arm), angular[p].copy()
        carried = acceleration[p] + np.cross(alpha[p], arm) + np.cross(omega[p], np.cross(omega[p], arm))
        if axis.prismatic:
            moved[:, column] = axis.direction
            carried = carried + 2 * np.cross(omega[p], rate)
            omega.append(omega[p])
            alpha.append(alpha[p])
        else:
            turned[:, column] = axis.direction
            omega.append(omega[p] + rate)
            alpha.append(alpha[p] + np.cross(omega[p], rate))
        reference.append(axis.anchor)
        linear.append(moved)
        angular.append(turned)
        acceleration.append(carried)
    inertia, bias = np.zeros((nv, nv)), np.zeros(nv)
    for k, body in enumerate(bodies):
        arm = body.com - reference[k]
        at_com = linear[k] + _cross(angular[k], arm)
        carried = acceleration[k] + np.cross(alpha[k], arm) + np.cross(omega[k], np.cross(omega[k], arm))
        spin = body.inertia @ alpha[k] + np.cross(omega[k], body.inertia @ omega[k])
        inertia += body.mass * at_com.T @ at_com + angular[k].T @ body.inertia @ angular[k]
        bias += at_com.T @ (body.mass * (carried - gravity)) + angular[k].T @ spin
    return inertia, bias


def _cross(columns: Array, arm: Array) -> Array:
    """Every column x arm."""
    return np.cross(columns, arm, axis=0) if columns.size else columns
