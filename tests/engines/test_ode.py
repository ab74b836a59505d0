"""ODE: what its joints and sweeps leave undone and how that vanishes; its motors and contacts in closed form."""

import ctypes.util
from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest
import realitygap_engines as engines
from realitygap.audit.check import advance, read
from realitygap.audit.machines import at_rest, block, chain, leg, random_state, rotor, tree, velocities
from realitygap.audit.oracle import Oracle
from realitygap_engines import Diverged, Ground, Physics, State, Unsupported
from realitygap_engines.model.robot import Array, Model, link_poses

pytestmark = pytest.mark.skipif("ode" not in engines.available(), reason="libode is not installed")
STANCE = at_rest(0.2 * np.cos(0.35) * 2 + 0.035, -0.35, 0.7, -0.35)


@pytest.fixture
def ode() -> engines.Engine:
    return engines.load("ode")


@pytest.mark.parametrize("floating", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_a_step_from_rest_is_forward_dynamics(ode: engines.Engine, floating: bool, seed: int) -> None:
    model, h = tree(floating), 1e-4
    moving = random_state(model, seed)
    state = State(moving.position, np.zeros(6), moving.base_position, moving.base_quaternion)
    effort = np.random.default_rng(seed).uniform(-0.05, 0.05, 6)
    with ode.open(model, Physics(h)) as simulation:
        simulation.reset(state)
        found = velocities(model, advance(simulation, effort=effort)) / h
    expected = velocities(model, Oracle(model).step(state, h, effort)) / h
    # rates are read where the joints are after the step
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-3 * np.abs(expected).max())


def swing(name: str, h: float) -> Array:
    with engines.load(name).open(chain(), Physics(h)) as simulation:
        simulation.reset(State(np.array([0.5, -0.3, 0.8]), np.array([0.5, -1.0, 0.7])))
        return advance(simulation, round(0.2 / h)).position


def test_a_chain_comes_to_the_true_motion_as_the_step_shrinks(ode: engines.Engine) -> None:
    """With an error of order h, as the generalized coordinates of the others have, and no larger."""
    fine = swing("mujoco", 1e-5)
    errors = [np.abs(swing("ode", h) - fine).max() for h in (1e-3, 5e-4)]
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.1)
    assert errors[0] < 1.2 * np.abs(swing("mujoco", 1e-3) - fine).max()


@pytest.mark.parametrize("iterations", [None, 50])
def test_joints_do_not_come_apart(ode: engines.Engine, iterations: int | None) -> None:
    model = chain()
    with ode.open(model, Physics(solver_iterations=iterations)) as simulation:
        simulation.reset(State(np.array([0.5, -0.3, 0.8]), np.array([0.5, -1.0, 0.7])))
        bodies = cast(Any, simulation)._robot.links[1:]
        worst = 0.0
        for _ in range(2000):
            poses = link_poses(model, advance(simulation).position)
            for pose, link, body in zip(poses[1:], model.links[1:], bodies, strict=True):
                worst = max(worst, np.abs(pose[:3, :3] @ link.com + pose[:3, 3] - body.position).max())
    assert worst < 3e-4


def squat(ode: engines.Engine, iterations: int | None) -> Array:
    model = leg(0.0266)
    gain = np.array([0.0, 25.0, 25.0, 25.0])
    out = np.empty((200, 4))
    with ode.open(model, Physics(ground=Ground(0.8), solver_iterations=iterations)) as simulation:
        simulation.reset(STANCE)
        state = STANCE
        for k in range(len(out)):
            goal = STANCE.position + 0.2 * np.sin(k * 0.01) * np.array([0.0, -0.5, 1.0, -0.5])
            effort = gain * (goal - state.position)
            state = advance(simulation, effort=effort, damping=np.sign(gain) * 1.4, friction=np.sign(gain) * 0.1)
            out[k] = state.position
    return out


def test_sweeps_of_quickstep_converge_to_the_direct_solution(ode: engines.Engine) -> None:
    direct = squat(ode, None)
    errors = [np.abs(squat(ode, n) - direct).max() for n in (20, 100, 500, 4000)]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 1e-3 < errors[0]


def test_the_number_of_sweeps_is_the_one_asked_for(ode: engines.Engine) -> None:
    with ode.open(block(), Physics(solver_iterations=37)) as simulation:
        assert simulation.settings["step function"] == "dWorldQuickStep"
        assert simulation.settings["quickStep iterations"] == 37
    with ode.open(block(), Physics()) as simulation:
        assert simulation.settings["step function"] == "dWorldStep"


def test_simulations_side_by_side_draw_from_generators_of_their_own(ode: engines.Engine) -> None:
    model, physics = leg(0.0266), Physics(ground=Ground(0.8), solver_iterations=20)

    def alone() -> Array:
        with ode.open(model, physics) as simulation:
            simulation.reset(STANCE)
            return np.array([advance(simulation).position for _ in range(100)])

    expected = alone()
    with ode.open(model, physics) as one, ode.open(model, physics) as other:
        one.reset(STANCE)
        other.reset(STANCE)
        found = []
        for _ in range(100):
            found.append(advance(one).position)
            advance(other, 2)
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(alone(), expected)


@pytest.mark.parametrize("armature", [0.0, 0.03])
@pytest.mark.parametrize("damping", [0.0, 1.4])
@pytest.mark.parametrize("friction", [0.0, 0.2])
@pytest.mark.parametrize("iterations", [None, 200])
def test_one_step_of_a_wheel_is_the_joint_law(
    ode: engines.Engine, armature: float, damping: float, friction: float, iterations: int | None
) -> None:
    """(I + A + h D) (v' - v) = h (effort - D v - friction)."""
    inertia, h, v, effort = 4.5e-4, 1e-3, 2.0, 0.7
    with ode.open(rotor(inertia, armature=armature), Physics(h, solver_iterations=iterations)) as simulation:
        simulation.reset(State(np.zeros(1), np.array([v])))
        after = advance(simulation, effort=effort, damping=damping, friction=friction)
        assert simulation.dry_friction()[0] == pytest.approx(-friction, abs=1e-9)
    change = h * (effort - damping * v - friction) / (inertia + armature + h * damping)
    assert after.velocity[0] == pytest.approx(v + change, rel=1e-8)


@pytest.mark.parametrize("prismatic", [False, True])
def test_a_joint_that_is_stuck_is_held_by_as_much_as_pushes_it(ode: engines.Engine, prismatic: bool) -> None:
    model = rotor(0.01, armature=0.02)
    model = replace(model, joints=(replace(model.joints[0], prismatic=prismatic, axis=np.array([0.6, 0.8, 0.0])),))
    with ode.open(model, Physics(gravity=(0.0, 0.0, 0.0))) as simulation:
        end = advance(simulation, 50, effort=0.15, friction=0.2)
        assert simulation.dry_friction()[0] == pytest.approx(-0.15, rel=1e-6)
    assert abs(end.velocity[0]) < 1e-9


@pytest.mark.parametrize(("stiffness", "damping"), [(3000.0, 100.0), (2e4, 0.0), (500.0, 400.0)])
@pytest.mark.parametrize("speed", [0.0, -0.3])
def test_soft_contact_is_the_implicit_spring_and_damper(
    ode: engines.Engine, stiffness: float, damping: float, speed: float
) -> None:
    """m (v' - v)/h = 4 (k (depth - h v') - d v') - m g for the four points of the block."""
    h, depth, mass = 1e-3, 1e-3, block().mass
    with ode.open(block(), Physics(h, ground=Ground(0.8, stiffness, damping))) as simulation:
        state = State(np.zeros(0), np.zeros(0))
        state.base_position[2], state.base_linear[2] = 0.02 - depth, speed
        simulation.reset(state)
        after = advance(simulation)
    expected = (mass * speed + h * (4 * stiffness * depth - mass * 9.81)) / (mass + 4 * h * (damping + h * stiffness))
    assert after.base_linear[2] == pytest.approx(expected, rel=1e-6)


def test_an_angle_is_counted_over_many_turns(ode: engines.Engine) -> None:
    with ode.open(rotor(0.01), Physics()) as simulation:
        simulation.reset(State(np.array([-9.0]), np.array([25.0])))
        assert read(simulation).position[0] == pytest.approx(-9.0, abs=1e-12)
        assert advance(simulation, 1000).position[0] == pytest.approx(16.0, abs=1e-9)


@pytest.mark.parametrize("effort", [np.nan, np.inf, 1e15])
@pytest.mark.parametrize("iterations", [None, 20])
def test_what_blows_up_is_told_and_the_process_lives(
    ode: engines.Engine, effort: float, iterations: int | None
) -> None:
    with ode.open(chain(), Physics(solver_iterations=iterations)) as simulation:
        with pytest.raises(Diverged, match="joint"):
            advance(simulation, 50, effort=effort)
        simulation.reset(at_rest(0.1, 0.2, 0.3))
        assert np.isfinite(advance(simulation, 10).position).all()


def test_a_link_without_inertia_is_refused_in_one_sentence(ode: engines.Engine) -> None:
    model = chain()
    links = (*model.links[:2], replace(model.links[2], inertia=np.zeros((3, 3))), *model.links[3:])
    with pytest.raises(Unsupported, match=r"link2 has .* give it an inertia"):
        ode.open(replace(model, links=links), Physics())


def test_it_is_silent(ode: engines.Engine, capfd: pytest.CaptureFixture[str]) -> None:
    """With more contacts than a body needs, of which its pivoting complains."""
    double: Model = replace(block(), links=(replace(block().links[0], spheres=block().links[0].spheres * 3),))
    with ode.open(double, Physics(ground=Ground(0.8))) as simulation:
        state = State(np.zeros(0), np.zeros(0))
        state.base_position[2], state.base_linear[:] = 0.02, [0.3, 0.1, -0.5]
        simulation.reset(state)
        end = advance(simulation, 300)
    assert end.base_position[2] == pytest.approx(0.02, abs=1e-4)
    assert capfd.readouterr() == ("", "")


def test_a_missing_library_is_said_with_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ctypes.util, "find_library", lambda _: None)
    assert "ode" not in engines.available()
    with pytest.raises(Unsupported, match="apt-get install libode8"):
        engines.load("ode")
