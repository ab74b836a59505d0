"""What is PyBullet's own: its hidden defaults, its frames, its output and its soft ground."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from realitygap_engines import Diverged, Ground, Physics, Simulation, State
from realitygap_engines.law.dynamics import Dynamics
from realitygap_engines.model.robot import Array, Joint, Link, Model, Sphere

pytest.importorskip("pybullet", reason="pybullet has no wheel for this Python; the other engines are tested without it")
from realitygap_engines.pybullet import ENGINE


def block() -> Model:
    """A free box of 1.2 kg on four spheres whose centre of mass is not its origin."""
    feet = tuple(Sphere(np.array([x, y, -0.01]), 0.01) for x in (-0.1, 0.1) for y in (-0.1, 0.1))
    link = Link("block", 1.2, np.array([0.0, 0.0, 0.005]), np.diag([4e-3, 5e-3, 8e-3]), feet)
    return Model("block", (link,), (), True)


def leg(lower: float = -np.inf, upper: float = np.inf, armature: float = 0.0) -> Model:
    """The block with a swinging arm, whose axis is skewed."""
    arm = Link("arm", 0.3, np.array([0.02, 0.0, 0.1]), np.array([[1e-3, 2e-4, 0], [2e-4, 1.2e-3, 0], [0, 0, 8e-4]]))
    joint = Joint("hip", False, 0, np.eye(4), np.array([0.0, 0.6, 0.8]), lower=lower, upper=upper, armature=armature)
    return Model("leg", (block().links[0], arm), (joint,), True)


def advance(simulation: Simulation, effort: Array, steps: int) -> tuple[Array, Array, Array]:
    n = len(effort)
    position, velocity, base = np.zeros(n), np.zeros(n), np.zeros(13)
    for _ in range(steps):
        simulation.step(effort, np.zeros(n), np.zeros(n))
    simulation.read(position, velocity, base)
    return position, velocity, base


@pytest.mark.parametrize(("stiffness", "damping"), [(3000.0, 100.0), (30000.0, 300.0)])
def test_soft_ground_gives_way_by_weight_over_stiffness(stiffness: float, damping: float) -> None:
    with ENGINE.open(block(), Physics(ground=Ground(0.8, stiffness, damping))) as simulation:
        simulation.reset(State(np.zeros(0), np.zeros(0), np.array([0.0, 0.0, 0.02])))
        _, _, base = advance(simulation, np.zeros(0), 2000)
    assert 0.02 - base[2] == pytest.approx(1.2 * 9.81 / (4 * stiffness), rel=1e-4)


def test_rigid_ground_does_not_give_way() -> None:
    with ENGINE.open(block(), Physics(ground=Ground(0.8))) as simulation:
        simulation.reset(State(np.zeros(0), np.zeros(0), np.array([0.0, 0.0, 0.02])))
        _, _, base = advance(simulation, np.zeros(0), 1000)
    assert base[2] == pytest.approx(0.02, abs=1e-6)
    assert np.abs(base[7:]).max() < 1e-9


@pytest.mark.parametrize(("lower", "upper"), [(-0.5, 0.4), (-np.inf, 0.4), (-0.5, np.inf)])
def test_a_limit_holds_on_the_side_where_there_is_one(lower: float, upper: float) -> None:
    model = replace(leg(lower, upper), floating=False)
    with ENGINE.open(model, Physics(gravity=(0.0, 0.0, 0.0))) as simulation:
        for effort, limit in ((0.5, upper), (-0.5, lower)):
            simulation.reset(State(np.zeros(1), np.zeros(1)))
            position, _, _ = advance(simulation, np.array([effort]), 1000)
            if np.isfinite(limit):
                assert position[0] == pytest.approx(limit, abs=1e-6)
            else:
                assert abs(position[0]) > 10


def test_nothing_is_damped_and_no_speed_is_clipped() -> None:
    """Without gravity and effort the free arm spins on, far above Bullet's speed limit of 100 rad/s."""
    model = replace(leg(), floating=False)
    with ENGINE.open(model, Physics(timestep=1e-4, gravity=(0.0, 0.0, 0.0))) as simulation:
        simulation.reset(State(np.zeros(1), np.array([500.0])))
        _, velocity, _ = advance(simulation, np.zeros(1), 1000)
    assert velocity[0] == pytest.approx(500.0, rel=1e-6)


def test_ballast_is_not_seen_from_outside() -> None:
    """With armature the engine carries ballast; its mass matrix, free fall and the effort's effect are the model's."""
    model, h = leg(armature=0.02), 1e-4
    start = State(np.array([0.3]), np.array([0.0]), np.array([0.0, 0.0, 1.0]), np.array([0.6, 0.0, 0.8, 0.0]))
    dynamics = Dynamics(model)
    dynamics.update(
        start.position, start.velocity, np.r_[0, 0, 1, start.base_quaternion, np.zeros(6)], np.r_[0, 0, -9.81]
    )
    with ENGINE.open(model, Physics(timestep=h, ground=Ground())) as simulation:
        simulation.reset(start)
        np.testing.assert_allclose(simulation.mass_matrix(), dynamics.inertia, rtol=0, atol=1e-12)
        _, velocity, base = advance(simulation, np.array([0.5]), 1)
    mass = dynamics.inertia.copy()
    mass[6, 6] += 0.02
    expected = np.linalg.solve(mass, np.r_[np.zeros(6), 0.5] - dynamics.bias)
    np.testing.assert_allclose(np.r_[base[7:], velocity] / h, expected, rtol=0, atol=1e-8 * np.abs(expected).max())


def test_two_simulations_do_not_touch_each_other() -> None:
    physics = Physics(ground=Ground(0.5))
    with ENGINE.open(leg(), physics) as alone:
        expected = advance(alone, np.array([0.1]), 200)
    with ENGINE.open(leg(), physics) as one, ENGINE.open(block(), Physics()) as other:
        for _ in range(200):
            found = advance(one, np.array([0.1]), 1)
            advance(other, np.zeros(0), 1)
    for a, b in zip(found, expected, strict=True):
        np.testing.assert_array_equal(a, b)


def test_sweeps_are_carried_out_as_asked() -> None:
    ends = []
    for iterations in (1, 2, 50):
        with ENGINE.open(leg(), Physics(ground=Ground(0.5), solver_iterations=iterations)) as simulation:
            assert simulation.settings["numSolverIterations"] == iterations
            simulation.reset(State(np.zeros(1), np.zeros(1), np.array([0.0, 0.0, 0.02])))
            ends.append(advance(simulation, np.array([0.1]), 100)[2][2])
    assert len(set(ends)) == 3


@pytest.mark.parametrize("effort", [np.nan, 1e12])
def test_a_blow_up_is_an_outcome(effort: float) -> None:
    with ENGINE.open(leg(), Physics()) as simulation, pytest.raises(Diverged) as caught:
        advance(simulation, np.array([effort]), 100)
    assert caught.value.joint == "hip"
    assert 0 < caught.value.time <= 0.1


def test_nothing_is_printed() -> None:
    code = (
        "import numpy as np\nfrom realitygap_engines import load, Physics, Ground\n"
        "from realitygap_engines.model.robot import *\n"
        "m = Model('m', (Link('a', 1.0, np.zeros(3), np.eye(3)),), (), True)\n"
        "with load('pybullet').open(m, Physics(ground=Ground())) as s: s.step(*[np.zeros(0)] * 3)\n"
    )
    root = Path(__file__).parents[2]
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, cwd=root)
    assert (done.stdout, done.stderr) == ("", "")
