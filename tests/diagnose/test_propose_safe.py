"""No proposed motion leaves a limit: as it is written, under every rival, in every engine, in random scenarios.

`python tests/bench_propose.py --safe 1000` tries many.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
import realitygap_engines as engines
from hypothesis import given, settings
from hypothesis import strategies as st

EVERY = engines.available()


@pytest.fixture(scope="module")
def planted() -> Iterator[None]:
    """The robots of the blind suite import one another by name."""
    folder = str(Path(__file__).parents[1] / "planted")
    sys.path.insert(0, folder)
    yield
    sys.path.remove(folder)


@settings(max_examples=3, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**31), other=st.integers(0, len(EVERY) - 1))
@pytest.mark.usefixtures("planted")
def test_no_motion_leaves_a_limit_under_any_rival(seed: int, other: int) -> None:
    from random_proposals import left

    with TemporaryDirectory() as folder:
        _, outside = left(seed, Path(folder), list(dict.fromkeys(["mujoco", EVERY[other]])))
    assert outside == []
