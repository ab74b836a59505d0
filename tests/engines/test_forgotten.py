"""A reset forgets everything, also what touched the ground: the same motion again is the same to the last bit."""

from dataclasses import replace

import numpy as np
import pytest
import realitygap_engines as engines
from realitygap_engines import Ground, Physics, State
from realitygap_engines.model.robot import Joint, Link, Model, Sphere


def walker() -> Model:
    """A body on two legs that swing sideways, each with a foot of four spheres."""
    foot = tuple(Sphere(np.array([x, y, -0.3]), 1e-3) for x in (-0.08, 0.1) for y in (-0.04, 0.04))
    leg = Link("leg", 0.8, np.array([0.0, 0.0, -0.2]), np.diag([0.01, 0.01, 0.002]), foot)
    links = [Link("body", 2.4, np.array([0.0, 0.0, 0.08]), np.diag([0.02, 0.015, 0.012]))]
    joints: list[Joint] = []
    for y in (-0.06, 0.06):
        hip = np.eye(4)
        hip[1, 3] = y
        links.append(replace(leg, name=f"leg{y:+}"))
        joints.append(Joint(f"hip{y:+}", False, 0, hip, np.array([1.0, 0.0, 0.0])))
    return Model("walker", tuple(links), tuple(joints), True)


def landed(simulation: engines.Simulation) -> np.ndarray:
    """It falls by a centimetre and stands."""
    start = State(np.array([0.1, -0.1]), np.zeros(2), np.array([0.0, 0.0, 0.32]))
    q, w, base, rows = np.zeros(2), np.zeros(2), np.zeros(13), []
    simulation.reset(start)
    for _ in range(150):
        simulation.step(-30.0 * q - 0.3 * w, np.zeros(2), np.full(2, 0.1))
        simulation.read(q, w, base)
        rows.append([*q, *w, *base])
    return np.array(rows)


@pytest.mark.parametrize("name", engines.available())
def test_a_robot_lands_alike_after_every_reset(name: str) -> None:
    with engines.load(name).open(walker(), Physics(ground=Ground(0.8))) as simulation:
        first = landed(simulation)
        for _ in range(2):
            np.testing.assert_array_equal(landed(simulation), first)
