"""Steps of a fit and moves of the search, by themselves."""

from dataclasses import replace

import numpy as np
import pytest
from demo_problem import demo_problem, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import LATER
from realitygap.diagnose.fit.fit import secant
from realitygap.diagnose.search.grow import LOOSER, with_shape


def test_slopes_tell_the_step_that_was_taken_and_what_lies_across_it_as_before() -> None:
    rng = np.random.default_rng(1)
    slopes, step, change = rng.standard_normal((30, 4)), rng.standard_normal(4), rng.standard_normal(30)
    told = slopes + secant(slopes, step, change)
    np.testing.assert_allclose(told @ step, change)
    across = rng.standard_normal(4)
    across -= step * (across @ step) / (step @ step)
    np.testing.assert_allclose(told @ across, slopes @ across)


@pytest.mark.parametrize("effect", ["command_profile", "effort_limit"])
def test_a_limit_beside_another_begins_at_several_sizes(effect: str) -> None:
    problem = demo_problem()
    whole = guess(problem, suspect_of(problem, effect, "elbow"))
    known, *others = LATER[effect]
    alone = replace(whole.at({n: np.inf for n in others if n != "share"}), free=(known,))
    tries = [with_shape(problem.plant, alone, looser) for looser in LOOSER]
    assert len(set(tries)) == len(LOOSER)
    for try_, looser in zip(tries, LOOSER, strict=True):
        assert set(try_.free) == set(LATER[effect])
        assert try_.parameters[known] == alone.parameters[known]
        new = [n for n in others if not np.isfinite(alone.parameters[n])]
        for name in new:
            assert try_.parameters[name] == pytest.approx(looser * tries[0].parameters[name] / LOOSER[0])
    assert with_shape(problem.plant, tries[0], LOOSER[-1]) == tries[0]
