"""Commands over steps: the mean over every step, after any delay, with the servo's off times kept."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from realitygap.scenario.file import load_scenario
from realitygap.simulate.commands import Commands, on_steps
from realitygap.simulate.experiment import experiments
from scipy.integrate import quad

TIME = np.array([0.0, 0.013, 0.02, 0.0371, 0.05])
VALUE = np.array([[1.0, -1.0], [3.0, 0.0], [-2.0, 0.5], [0.0, 0.5], [4.0, 0.25]])


def at(commands: Commands, t: float, column: int) -> float:
    """The command in force at a time: the last one sent, or linear in between; the first one before the first."""
    if not commands.held:
        return float(np.interp(t, commands.time, commands.value[:, column]))
    last = max(int(np.searchsorted(commands.time, t, side="right")) - 1, 0)
    return float(commands.value[last, column])


@pytest.mark.parametrize("held", [True, False])
@pytest.mark.parametrize("h", [1e-3, 3.7e-3, 0.02])
def test_every_step_has_the_mean_of_its_time(held: bool, h: float) -> None:
    """From half a step before its time to half a step after, also where several commands fall into one step."""
    commands = Commands(TIME, VALUE, held)
    delay = np.array([0.0, 0.0042])
    steps = int(0.08 / h)
    out = on_steps(commands, steps, h, delay)
    for k in range(steps):
        for j in range(2):
            low, high = (k - 0.5) * h - delay[j], (k + 0.5) * h - delay[j]
            inside = [t for t in TIME if low < t < high]
            edges = [low, *inside, high]
            parts = [quad(lambda t, j=j: at(commands, t, j), a, b)[0] for a, b in pairwise(edges)]
            assert_allclose(out[k, j], sum(parts) / h, atol=1e-9)


def test_a_delay_is_continuous() -> None:
    """A tenth of a step moves the result by a tenth of the step of the command, with no jump at whole steps."""
    commands = Commands(np.array([0.0, 0.1]), np.array([[0.0], [1.0]]))
    h = 0.01
    sums = [on_steps(commands, 40, h, np.array([d])).sum() * h for d in np.arange(0.0, 0.05, 0.1 * h)]
    assert_allclose(np.diff(sums), -0.1 * h, rtol=1e-9)


def test_a_delay_of_whole_steps_is_a_shift() -> None:
    commands = Commands(TIME, VALUE)
    now = on_steps(commands, 60, 1e-3, np.zeros(2))
    late = on_steps(commands, 70, 1e-3, np.full(2, 10e-3))
    assert_allclose(late[10:], now, atol=1e-12)
    assert_allclose(late[:10], np.tile(VALUE[0], (10, 1)))


def test_a_servo_that_is_off_has_no_command() -> None:
    value = np.array([[1.0, 1.0], [np.nan, 2.0], [3.0, 3.0]])
    out = on_steps(Commands(np.array([0.0, 0.1, 0.2]), value), 30, 0.01, np.zeros(2))
    assert np.flatnonzero(np.isnan(out[:, 0])).tolist() == list(range(10, 20))
    assert np.isfinite(out[:, 1]).all()
    assert_allclose(out[20:, 0], 3.0)


def test_no_command_at_all() -> None:
    out = on_steps(Commands(np.zeros(1), np.full((1, 3), np.nan)), 5, 0.01, np.zeros(3))
    assert out.shape == (5, 3)
    assert np.isnan(out).all()


@pytest.mark.parametrize("held", [True, False])
def test_a_step_never_overshoots(held: bool) -> None:
    random = np.random.default_rng(1)
    time = np.cumsum(random.uniform(1e-3, 0.02, 200))
    value = np.round(random.standard_normal((200, 1)), 2)
    out = on_steps(Commands(time, value, held), 2000, 1e-3, np.zeros(1))
    assert value.min() <= out.min()
    assert out.max() <= value.max()
    still = on_steps(Commands(time, np.full_like(value, 0.1), held), 2000, 1e-3, np.zeros(1))
    assert (still == 0.1).all(), "a constant stays what it is, bit for bit"


@pytest.mark.parametrize("held", [True, False])
def test_a_scenario_says_whether_recorded_commands_hold(held: bool) -> None:
    demo = load_scenario(Path(__file__).parents[2] / "scenarios" / "demo" / "scenario.yaml")
    assert [e.commands.held for e in experiments(demo.override({"motion.held": held}))][:1] == [held]
