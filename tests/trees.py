"""Branching robots without symmetry, for laws that hold of any machine."""

from collections.abc import Sequence

import numpy as np
from realitygap_engines.model.robot import Joint, Link, Model, axis_rotation, rotation_from_rpy


def tree(
    parents: Sequence[int],
    floating: bool = False,
    *,
    seed: int = 0,
    moments: tuple[float, float] = (1e-3, 3e-3),
) -> Model:
    """Skewed axes, offset centres of mass, and a slider for the fourth joint.

    Args:
        parents: the link that each joint hangs on.
        floating: whether the base is free.
        seed: of all that is drawn.
        moments: bounds of the three second moments of a link's mass about its centre [kg·m²], of which two each make a
            moment of inertia.
    """
    rng = np.random.default_rng(seed)
    links, joints = [], []
    for i in range(len(parents) + 1):
        turn = axis_rotation(np.array([0.6, 0.0, 0.8]), rng.uniform(-2, 2))
        a, b, c = rng.uniform(*moments, 3)
        inertia = turn @ np.diag([b + c, a + c, a + b]) @ turn.T
        links.append(Link(f"link{i}", rng.uniform(0.2, 1.5), rng.uniform(-0.1, 0.1, 3), (inertia + inertia.T) / 2))
    for i, parent in enumerate(parents):
        origin = np.eye(4)
        origin[:3, :3] = rotation_from_rpy(*rng.uniform(-1, 1, 3))
        origin[:3, 3] = rng.uniform(-0.2, 0.2, 3)
        axis = rng.normal(size=3)
        joints.append(Joint(f"joint{i}", i == 3, parent, origin, axis / np.linalg.norm(axis)))
    return Model("tree", tuple(links), tuple(joints), floating)
