"""Disturbing torques: as large and as lasting as they are said to be, on their joint alone."""

from dataclasses import replace

import numpy as np
import pytest
from demo_problem import demo_problem
from realitygap.diagnose.data.push import CORRELATION, Push, coloured


@pytest.mark.parametrize("h", [1e-3, 0.02])
def test_a_random_torque_has_its_deviation_and_its_correlation_time_at_any_step(h: float) -> None:
    value = coloured(400_000, h, seed=1)
    assert value.std() == pytest.approx(1.0, rel=0.05)
    lag = round(CORRELATION / h)
    assert np.mean(value[lag:] * value[:-lag]) == pytest.approx(np.exp(-lag * h / CORRELATION), abs=0.08)
    np.testing.assert_array_equal(value, coloured(400_000, h, seed=1))
    assert not np.array_equal(value, coloured(400_000, h, seed=2))


def test_it_is_put_on_its_joint_for_the_whole_motion() -> None:
    experiment = demo_problem().cases[0].experiment
    experiment = replace(experiment, duration=2.0)
    bare, still, moved = (experiment.plant.copy() for _ in range(3))
    Push(1, 0.3).on(still, experiment)
    Push(1, 0.3, seed=4).on(moved, experiment)
    assert (still.drive["constant"] - bare.drive["constant"]).tolist() == [0.0, 0.3]
    h = experiment.scenario.timestep
    time = np.arange(round(2.0 / h), dtype=np.float64) * h
    given = moved.given(time) - bare.given(time)
    np.testing.assert_array_equal(given[:, 0], 0.0)
    np.testing.assert_allclose(given[:, 1], 0.3 * coloured(round(2.0 / h) + 3, h, 4)[: len(time)])
