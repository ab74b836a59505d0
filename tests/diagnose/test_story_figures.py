"""The figures of a diagnosis show at a glance what changed: also where nothing did, and where swings are many."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from realitygap.diagnose.result.story_figures import Curves, Pair, _close_up, _dots


def test_a_gap_that_stays_shows_both_of_its_signs() -> None:
    axes = Figure().subplots()
    _dots(axes, [Pair("MuJoCo", 5.0, 5.0)])
    ring, dot = (
        next(
            line
            for line in axes.lines
            if line.get_marker() == "o" and (line.get_markerfacecolor() != line.get_color()) == hollow
        )
        for hollow in (True, False)
    )
    assert ring.get_markersize() - ring.get_markeredgewidth() > dot.get_markersize()


@pytest.mark.parametrize(("swings", "close"), [(3, False), (40, True)])
def test_many_swings_are_drawn_close_up_also_where_curves_part_far(swings: int, close: bool) -> None:
    time = np.linspace(0.0, 12.0, 2401)
    swing = np.sin(2.0 * np.pi * swings * time / 12.0)
    window = _close_up(Curves(time, 4.0 * swing, 7.0 * swing, 4.1 * swing, np.full(2401, 0.01), "deg", "position"))
    assert (window is not None) == close
    if window is not None:
        assert (window[1] - window[0]) * swings / 12.0 < 5


def test_a_joint_that_holds_between_two_counts_of_its_encoder_needs_no_close_up() -> None:
    time = np.linspace(0.0, 12.0, 2401)
    held = 0.09 * (np.arange(2401) % 3 == 0)
    assert _close_up(Curves(time, held, held + 3.0, held, np.full(2401, 0.05), "deg", "position")) is None
