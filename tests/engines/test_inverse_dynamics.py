"""The effort that a motion takes: what every engine has natively is M·a + c of its own step, and alike in all."""

from dataclasses import replace

import numpy as np
import pytest
import realitygap_engines as engines
import trees
from realitygap_engines import GRAVITY, Physics, Simulation, State, Unsupported
from realitygap_engines.model.robot import Array, Joint, Link, Model

NAMES = engines.available()
every = pytest.mark.parametrize("name", NAMES)


def tree(floating: bool = False) -> Model:
    """With stops near zero."""
    model = trees.tree([0, 1, 2, 0, 4], floating, seed=4)
    return replace(model, joints=tuple(replace(j, lower=-0.1, upper=0.1) for j in model.joints))


def motion(seed: int = 0, samples: int = 20) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(seed)
    q, v, a = rng.normal(size=(3, samples, 5))
    return q, v, a


def mounted(model: Model) -> State:
    """A base on a slanted wall."""
    quaternion = np.array([0.8, 0.3, -0.4, 0.33166])
    zero = np.zeros(len(model.joints))
    return State(zero, zero, np.array([0.1, 0.2, 0.3]), quaternion / np.linalg.norm(quaternion))


@every
def test_it_is_mass_matrix_times_acceleration_and_bias(name: str) -> None:
    """Also beyond the joints' limits, whose stops are not part of it."""
    model = tree()
    free = replace(model, joints=tuple(replace(j, lower=-np.inf, upper=np.inf) for j in model.joints))
    with engines.load(name).open(model, Physics()) as limited, engines.load(name).open(free, Physics()) as simulation:
        native = limited.inverse_dynamics(mounted(model), *motion())
        made = Simulation._inverse(simulation, mounted(model), *motion())
    np.testing.assert_allclose(native, made, rtol=0, atol=1e-8 * np.abs(made).max())


@pytest.mark.parametrize("name", [n for n in NAMES if n != NAMES[0]])
def test_engines_agree_to_rounding(name: str) -> None:
    model, found = tree(), []
    for engine in (NAMES[0], name):
        with engines.load(engine).open(model, Physics()) as simulation:
            found.append(simulation.inverse_dynamics(mounted(model), *motion(1)))
    assert np.abs(found[1] - found[0]).max() < 1e-9 * np.abs(found[0]).max()


@every
def test_a_pendulum_takes_what_the_closed_form_says(name: str) -> None:
    bob = Link("bob", 0.5, np.array([0.0, 0.0, -0.2]), np.eye(3) * 1e-3)
    hinge = Joint("hinge", False, 0, np.eye(4), np.array([0.0, 1.0, 0.0]))
    model = Model("pendulum", (Link("base", 1.0, np.zeros(3), np.eye(3) * 1e-3), bob), (hinge,), False)
    q, v, a = (x.reshape(-1, 1) for x in np.random.default_rng(0).normal(size=(3, 30)))
    with engines.load(name).open(model, Physics()) as simulation:
        found = simulation.inverse_dynamics(State(np.zeros(1), np.zeros(1)), q, v, a)
    exact = (0.5 * 0.2**2 + 1e-3) * a + 0.5 * GRAVITY * 0.2 * np.sin(q)
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-9)


@every
def test_what_is_not_known_is_refused(name: str) -> None:
    rotors = tree().with_armature(np.full(5, 0.1))
    for model in (tree(floating=True), rotors):
        with engines.load(name).open(model, Physics()) as simulation, pytest.raises(Unsupported, match="armature"):
            simulation.inverse_dynamics(mounted(model), *motion())
