"""What the DART adapter promises beyond the laws that every engine obeys."""

import importlib.util
from typing import Any, cast

import numpy as np
import pytest
from realitygap_engines.engine import Ground, Physics, State
from realitygap_engines.errors import Diverged
from realitygap_engines.model.robot import Joint, Link, Model, Sphere

if importlib.util.find_spec("dartpy") is None:
    pytest.skip("dartpy is not installed", allow_module_level=True)
from realitygap_engines.dart import ENGINE

H = 1e-3
GRAVITY = 9.81


def arm(armature: float = 0.0, lower: float = -np.inf, upper: float = np.inf) -> Model:
    """A link of 0.05 kg·m² that turns about a vertical axis, where gravity does nothing."""
    base = Link("base", 1.0, np.zeros(3), np.eye(3))
    link = Link("link", 1.0, np.zeros(3), np.eye(3) * 0.05)
    joint = Joint("hinge", False, 0, np.eye(4), np.array([0.0, 0.0, 1.0]), lower, upper, armature=armature)
    return Model("arm", (base, link), (joint,), False)


def crate() -> Model:
    """A free box on four spheres."""
    feet = tuple(Sphere(np.array([x, y, -0.01]), 0.01) for x in (-0.1, 0.1) for y in (-0.1, 0.1))
    return Model("crate", (Link("crate", 1.2, np.zeros(3), np.diag([4e-3, 4e-3, 8e-3]), feet),), (), True)


def test_a_body_at_rest_stays_awake() -> None:
    """Asleep, its contacts would carry nothing."""
    none, base = np.zeros(0), np.zeros(13)
    with ENGINE.open(crate(), Physics(timestep=H, ground=Ground(0.8))) as simulation:
        state = State(np.zeros(0), np.zeros(0), np.array([0.0, 0.0, 0.02]))
        simulation.reset(state)
        for _ in range(2000):
            simulation.step(none, none, none)
        force = sum(c.force[2] for c in cast(Any, simulation)._world.getLastCollisionResult().getContacts())
        assert abs(force) == pytest.approx(1.2 * GRAVITY, rel=1e-3)
        simulation.read(none, none, base)
    assert base[2] == pytest.approx(0.02, abs=1e-5)


def test_a_joint_stops_at_its_limit_and_is_not_slowed_before() -> None:
    position, velocity, base = np.zeros(1), np.zeros(1), np.zeros(13)
    with ENGINE.open(arm(lower=-1.0, upper=2.0), Physics(timestep=H)) as simulation:
        simulation.reset(State(np.zeros(1), np.full(1, 30.0)))
        simulation.step(np.zeros(1), np.zeros(1), np.zeros(1))
        simulation.read(position, velocity, base)
        assert velocity[0] == 30.0
        for _ in range(500):
            simulation.step(np.array([0.5]), np.zeros(1), np.zeros(1))
        simulation.read(position, velocity, base)
    assert position[0] == pytest.approx(2.0, abs=2e-3)
    assert velocity[0] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("damping", [0.5, 50.0])
def test_damping_is_implicit_whatever_its_size(damping: float) -> None:
    """v' = v·I/(I + h·d)."""
    position, velocity, base = np.zeros(1), np.zeros(1), np.zeros(13)
    armature = 0.02
    with ENGINE.open(arm(armature), Physics(timestep=H)) as simulation:
        simulation.reset(State(np.zeros(1), np.ones(1)))
        for k in range(1, 20):
            simulation.step(np.zeros(1), np.array([damping]), np.zeros(1))
            simulation.read(position, velocity, base)
            assert velocity[0] == pytest.approx((0.07 / (0.07 + H * damping)) ** k, rel=1e-6)


@pytest.mark.parametrize("torque", [np.nan, np.inf])
def test_a_torque_that_is_not_a_number_is_a_divergence(torque: float) -> None:
    """DART alone would ignore it, print a message and go on."""
    with ENGINE.open(arm(), Physics(timestep=H)) as simulation:
        simulation.step(np.zeros(1), np.zeros(1), np.zeros(1))
        with pytest.raises(Diverged) as caught:
            simulation.step(np.array([torque]), np.zeros(1), np.zeros(1))
    assert caught.value.joint == "hinge"
    assert caught.value.time == pytest.approx(2 * H)


def test_an_explosion_is_a_divergence() -> None:
    position, velocity, base = np.zeros(1), np.ones(1), np.zeros(13)

    def explode() -> None:
        with ENGINE.open(arm(), Physics(timestep=H)) as simulation:
            simulation.reset(State(position, velocity))
            for _ in range(1000):
                simulation.step(-1000.0 * velocity, np.zeros(1), np.zeros(1))
                simulation.read(position, velocity, base)

    with pytest.raises(Diverged, match="hinge"):
        explode()


def test_iterations_are_sweeps_of_the_contact_solver() -> None:
    with ENGINE.open(crate(), Physics(ground=Ground(), solver_iterations=7)) as simulation:
        assert simulation.settings["solver"] == "NsgsFrictionSolver"
        assert simulation.settings["solver iterations, at most"] == 7
