"""Simulations that stay open tell what new ones tell, are used by one at a time, and are few."""

from collections.abc import Iterator

import numpy as np
import pytest
import realitygap_engines as engines
from realitygap.simulate import opened as room
from realitygap.simulate.opened import KEPT, kept_open, opened
from realitygap_engines import Ground, Physics, Simulation, State
from realitygap_engines.model.robot import Joint, Link, Model, Sphere


@pytest.fixture(autouse=True)
def _kept() -> Iterator[None]:
    with kept_open():
        yield
    assert not room._Kept.simulations


def hopper() -> Model:
    """A body with one swinging leg, on a foot of four spheres."""
    foot = tuple(Sphere(np.array([x, y, -0.2]), 1e-3) for x in (-0.05, 0.05) for y in (-0.04, 0.04))
    links = (
        Link("body", 2.0, np.array([0.0, 0.0, 0.05]), np.diag([0.02, 0.015, 0.012])),
        Link("leg", 0.8, np.array([0.0, 0.0, -0.1]), np.diag([0.01, 0.01, 0.002]), foot),
    )
    return Model("hopper", links, (Joint("hip", False, 0, np.eye(4), np.array([0.0, 1.0, 0.0])),), True)


def dropped(simulation: Simulation, angle: float, damping: float) -> np.ndarray:
    """What it does when it falls by a centimetre, step by step."""
    q, w, base, rows = np.zeros(1), np.zeros(1), np.zeros(13), []
    simulation.reset(State(np.array([angle]), np.zeros(1), np.array([0.0, 0.0, 0.215])))
    for _ in range(80):
        simulation.step(-5.0 * q, np.array([damping]), np.array([0.05]))
        simulation.read(q, w, base)
        rows.append([*q, *w, *base])
    return np.array(rows)


@pytest.mark.parametrize("engine", engines.available())
def test_one_that_was_used_is_as_a_new_one(engine: str) -> None:
    physics = Physics(ground=Ground(0.8))
    with engines.load(engine).open(hopper(), physics) as new:
        expected = dropped(new, 0.1, 0.2)
    with opened(engine, hopper(), physics) as first:
        dropped(first, -0.3, 0.0)
    with opened(engine, hopper(), physics) as again:
        assert again is first
        np.testing.assert_array_equal(dropped(again, 0.1, 0.2), expected)


def test_two_that_are_used_at_once_are_two() -> None:
    with opened("mujoco", hopper(), Physics()) as one, opened("mujoco", hopper(), Physics()) as other:
        assert one is not other
    assert len(room._Kept.simulations) == 1


def test_another_machine_or_physics_is_another() -> None:
    heavy = Model("hopper", hopper().links[:1], (), True)
    with opened("mujoco", hopper(), Physics()) as one:
        pass
    for model, physics in ((heavy, Physics()), (hopper(), Physics(5e-4)), (hopper(), Physics(ground=Ground(0.5)))):
        with opened("mujoco", model, physics) as other:
            assert other is not one


def test_one_in_which_something_was_raised_is_not_used_again() -> None:
    with pytest.raises(ZeroDivisionError), opened("mujoco", hopper(), Physics()):
        raise ZeroDivisionError
    assert not room._Kept.simulations


def test_they_are_few() -> None:
    for k in range(2 * KEPT):
        for engine in ("mujoco", "dart"):
            with opened(engine, hopper(), Physics(1e-3 / (k + 1))):
                pass
    assert len(room._Kept.simulations) == 2 * KEPT


def test_elsewhere_none_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also MuJoCo's messages are the user's again."""
    monkeypatch.setattr(room._Kept, "blocks", 0)
    with opened("mujoco", hopper(), Physics()):
        pass
    assert not room._Kept.simulations
