"""First-order recursions against the same written out, and against closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from realitygap.trace.first_order import first_order

SHARES = st.floats(0.0, 1.0)


@given(
    arrays(float, st.integers(1, 40), elements=st.floats(-10.0, 10.0)),
    st.lists(SHARES, min_size=40, max_size=40),
    st.floats(-10.0, 10.0),
)
def test_written_out(given_: np.ndarray, shares: list[float], before: float) -> None:
    keep = np.array(shares[: len(given_)])
    expected, value = [], before
    for k, more in zip(keep, given_, strict=True):
        value = k * value + more
        expected.append(value)
    assert first_order(given_, keep, before) == pytest.approx(expected, rel=1e-12, abs=1e-9)


def test_step_answer() -> None:
    """A low-pass of a step: 1 − exp(−t/τ)."""
    h, constant = 0.01, 0.2
    keep = float(np.exp(-h / constant))
    out = first_order(np.full(100, 1.0 - keep), keep)
    assert out == pytest.approx(1.0 - np.exp(-h * np.arange(1, 101) / constant), rel=1e-12)
