"""Laws of least squares within bounds."""

from typing import Any

import numpy as np
import pytest
from realitygap.diagnose.fit import bounded as module
from realitygap.diagnose.fit.bounded import bounded
from realitygap.robot.drive import Array
from scipy.optimize import OptimizeResult, lsq_linear


@pytest.mark.parametrize("values", [1, 3, 12])
@pytest.mark.parametrize("seed", range(5))
def test_no_value_within_its_bounds_does_better(values: int, seed: int) -> None:
    """Where a value is free the slope is nothing, and at a bound it leads out of it (Karush, Kuhn and Tucker)."""
    rng = np.random.default_rng(seed)
    matrix, right = rng.standard_normal((20, values)), 3.0 * rng.standard_normal(20)
    low, high = -0.3 * rng.random(values), np.where(rng.random(values) < 0.3, np.inf, 0.3 * rng.random(values))
    x = bounded(matrix, right, low, high)
    slope = matrix.T @ (matrix @ x - right)
    assert (x >= low).all()
    assert (x <= high).all()
    inside = (x > low + 1e-9) & (x < high - 1e-9)
    assert slope[inside] == pytest.approx(0.0, abs=1e-8)
    assert (slope[x <= low + 1e-9] >= -1e-8).all()
    assert (slope[x >= high - 1e-9] <= 1e-8).all()


def test_what_active_sets_do_not_find_is_found_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where one exchange of values is not enough, the way through the inside leads to the same."""
    rng = np.random.default_rng(7)
    matrix, right, bound = rng.standard_normal((20, 8)), 3.0 * rng.standard_normal(20), np.full(8, 0.2)
    best = bounded(matrix, right, -bound, bound)

    def one_exchange(matrix: Array, right: Array, **options: Any) -> OptimizeResult:
        return lsq_linear(matrix, right, **{**options, "max_iter": 1 if "method" in options else None})

    monkeypatch.setattr(module, "lsq_linear", one_exchange)
    assert bounded(matrix, right, -bound, bound) == pytest.approx(best, abs=1e-4)


def test_no_values() -> None:
    """Of none there are none."""
    assert bounded(np.zeros((3, 0)), np.ones(3), np.zeros(0), np.zeros(0)).shape == (0,)
