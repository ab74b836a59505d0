"""Where two models differ, on the bundled demo (synthetic) with its friction found and not."""

import numpy as np
import pytest
from demo_problem import FRICTION, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.likelihood.whitening import spans
from realitygap.diagnose.search.apart import ERRORS, reached, scatter
from realitygap.diagnose.search.criterion import Criterion


def test_a_change_reaches_what_is_explained_where_it_acts(problem: Problem, simulations: Simulations) -> None:
    """Changes of one joint each share what is explained among them; one of both reaches no more than all of it."""
    criterion = Criterion(simulations, [])
    friction = guess(problem, suspect_of(problem, "coulomb_friction", "elbow")).at({"torque": FRICTION})
    bare, told = (residual(simulations, changes, criterion.train) for changes in ([], [friction]))
    assert bare is not None
    assert told is not None
    explained = criterion.score(Fit((friction,), told)), criterion.score(Fit((), bare))
    share = {}
    for joint in (0, 1):
        change = np.zeros(len(bare))
        for channel, span in spans(criterion.channels):
            change[span] = 1.0 if channel.column == joint else 0.0
        share[joint] = reached(criterion.channels, explained, change)
        assert reached(criterion.channels, explained, -3.0 * change) == pytest.approx(share[joint])
    assert sum(share.values()) == pytest.approx(1.0)
    assert share[1] > share[0]
    assert share[1] < reached(criterion.channels, explained, told - bare) <= 1.0


@pytest.mark.parametrize("number", [2, 3, 5, 60])
def test_a_difference_is_sure_by_chance_once_in_twenty_however_few_stretches_tell_it(number: int) -> None:
    parts = np.random.default_rng(number).standard_normal((20000, number))
    sure = np.mean([p.sum() > ERRORS * scatter(p) for p in parts])
    assert sure == pytest.approx(0.05, abs=0.005)


def test_one_stretch_tells_no_scatter() -> None:
    assert scatter(np.array([3.0])) == 0.0
