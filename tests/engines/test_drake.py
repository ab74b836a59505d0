"""What the Drake adapter promises beyond the laws that every engine obeys."""

import gc
import importlib.util
import logging
import weakref

import numpy as np
import pytest
from realitygap_engines.engine import Ground, Physics, State
from realitygap_engines.errors import Diverged
from realitygap_engines.model.robot import Array, Joint, Link, Model, Sphere

if importlib.util.find_spec("pydrake") is None:
    pytest.skip("drake is not installed", allow_module_level=True)
from realitygap_engines.drake import ENGINE, KEPT, DrakeSimulation

H = 1e-3
GRAVITY = 9.81


def ball(mass: float = 2.0) -> Model:
    return Model("ball", (Link("ball", mass, np.zeros(3), np.eye(3) * 1e-2, (Sphere(np.zeros(3), 0.05),)),), (), True)


def arm(armature: float = 0.0, lower: float = -np.inf, upper: float = np.inf) -> Model:
    """A link of 0.05 kg·m² that turns about a vertical axis, where gravity does nothing."""
    base = Link("base", 1.0, np.zeros(3), np.eye(3))
    link = Link("link", 1.0, np.zeros(3), np.eye(3) * 0.05)
    joint = Joint("hinge", False, 0, np.eye(4), np.array([0.0, 0.0, 1.0]), lower, upper, armature=armature)
    return Model("arm", (base, link), (joint,), False)


def drop(ground: Ground, height: float, speed: float, steps: int) -> tuple[Array, Array]:
    """Height and vertical speed of the ball's lowest point after every step."""
    none, base = np.zeros(0), np.zeros(13)
    rows = []
    with ENGINE.open(ball(), Physics(timestep=H, ground=ground)) as simulation:
        state = State(np.zeros(0), np.zeros(0), np.array([0.0, 0.0, 0.05 + height]))
        state.base_linear = np.array([0.0, 0.0, speed])
        simulation.reset(state)
        for _ in range(steps):
            simulation.step(none, none, none)
            simulation.read(none, none, base)
            rows.append((base[2] - 0.05, base[9]))
    return np.array([z for z, _ in rows]), np.array([v for _, v in rows])


@pytest.mark.parametrize(("stiffness", "damping"), [(3000.0, 100.0), (3000.0, 0.0), (2e4, 20.0)])
def test_soft_ground_is_the_spring_and_damper_asked_for(stiffness: float, damping: float) -> None:
    """Implicit Euler of m·v' = -m·g + max(0, -k·z - b·v) with z and v at the end of the step, once z < 0."""
    mass = 2.0
    found_z, found_v = drop(Ground(0.8, stiffness, damping), 0.01, -0.2, 300)
    z, v = 0.01, -0.2
    for i in range(300):
        free = v - H * GRAVITY
        touching = (mass * free - H * stiffness * z) / (mass + H * damping + H * H * stiffness)
        force = -stiffness * (z + H * touching) - damping * touching
        v = touching if z < 0 and force > 0 else free
        z += H * v
        assert found_z[i] == pytest.approx(z, abs=1e-9)
        assert found_v[i] == pytest.approx(v, abs=1e-6)


def test_rigid_ground_stops_a_fall_without_bounce() -> None:
    z, v = drop(Ground(0.8), 0.01, -0.5, 300)
    assert z.min() > -1e-5
    assert np.abs(v[-200:]).max() < 1e-6


@pytest.mark.parametrize("damping", [0.5, 50.0])
def test_damping_is_implicit_and_follows_every_change(damping: float) -> None:
    """v' = v·I/(I + h·d), then undamped again, whatever was set before."""
    armature = 0.02
    position, velocity, base = np.zeros(1), np.zeros(1), np.zeros(13)
    with ENGINE.open(arm(armature), Physics(timestep=H)) as simulation:
        simulation.reset(State(np.zeros(1), np.ones(1)))
        expected = 1.0
        for d in (damping, damping, 0.0, 2 * damping):
            simulation.step(np.zeros(1), np.array([d]), np.zeros(1))
            simulation.read(position, velocity, base)
            expected *= (0.05 + armature) / (0.05 + armature + H * d)
            assert velocity[0] == pytest.approx(expected, rel=1e-9)
        simulation.reset(State(np.zeros(1), np.ones(1)))
        simulation.step(np.zeros(1), np.zeros(1), np.zeros(1))
        simulation.read(position, velocity, base)
        assert velocity[0] == 1.0


def test_armature_is_in_the_mass_matrix() -> None:
    with ENGINE.open(arm(0.02), Physics()) as simulation:
        assert simulation.mass_matrix() == pytest.approx(np.array([[0.07]]))


def test_a_joint_stops_at_its_limit() -> None:
    position, velocity, base = np.zeros(1), np.zeros(1), np.zeros(13)
    with ENGINE.open(arm(lower=-0.1, upper=0.2), Physics(timestep=H)) as simulation:
        simulation.reset(State(np.zeros(1), np.ones(1)))
        for _ in range(500):
            simulation.step(np.array([0.5]), np.zeros(1), np.zeros(1))
            simulation.read(position, velocity, base)
        assert position[0] == pytest.approx(0.2, abs=1e-3)
        assert velocity[0] == pytest.approx(0.0, abs=1e-3)


def test_a_torque_that_is_not_a_number_is_a_divergence() -> None:
    with ENGINE.open(arm(), Physics(timestep=H)) as simulation:
        simulation.step(np.zeros(1), np.zeros(1), np.zeros(1))
        with pytest.raises(Diverged) as caught:
            simulation.step(np.array([np.nan]), np.zeros(1), np.zeros(1))
    assert caught.value.joint == "hinge"
    assert caught.value.time == pytest.approx(2 * H)


def test_iterations_are_declared_not_applicable() -> None:
    assert ENGINE.capabilities()["solver_iterations"].level == "no"
    with ENGINE.open(arm(), Physics(solver_iterations=7)) as simulation:
        assert "not applicable" in str(simulation.settings["solver iterations"])


def test_a_ground_is_opened_in_silence(caplog: pytest.LogCaptureFixture) -> None:
    level = logging.getLogger("drake").level
    with ENGINE.open(ball(), Physics(timestep=H, ground=Ground())):
        assert caplog.records == []
    assert logging.getLogger("drake").level == level


def test_closed_simulations_do_not_wait_for_a_full_collection() -> None:
    gc.collect()
    gc.disable()
    try:
        opened = []
        for _ in range(3 * KEPT):
            with ENGINE.open(arm(), Physics(timestep=H)) as simulation:
                assert isinstance(simulation, DrakeSimulation)
                opened.append(weakref.ref(simulation._plant))
        assert sum(plant() is not None for plant in opened) <= KEPT + 1
    finally:
        gc.enable()
