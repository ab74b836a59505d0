"""What a change is in a run whose own values differ from those of the reference."""

from dataclasses import replace

import numpy as np
import pytest
from demo_problem import demo_problem, suspect_of
from numpy.testing import assert_allclose
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.changes import Suspect, changed


def test_where_a_mass_sits_moves_by_as_much_and_the_mass_by_the_same_ratio() -> None:
    """Also where a coordinate is zero but for rounding, of which a ratio would make centimetres."""
    problem = demo_problem()
    reference = problem.plant.copy()
    links = list(reference.model.links)
    moved, rounding = np.array([5e-3, 9e-3, 0.0]), np.array([-1.9e-19, 1e-3, 0.0])
    own = links[2].com + rounding
    reference.model = replace(reference.model, links=(*links[:2], replace(links[2], com=own)))
    run = reference.copy()
    other = np.array([2.9e-18, -0.04, 1.1 * own[2]])
    heavy = replace(links[2], com=other, mass=2.0 * links[2].mass)
    run.model = replace(run.model, links=(*links[:2], heavy))
    at = own + moved
    there = guess(problem, suspect_of(problem, "center_of_mass", "forearm")).at(dict(zip("xyz", at, strict=True)))
    lighter = guess(problem, suspect_of(problem, "link_mass", "forearm")).at({"mass": 0.9 * links[2].mass})
    assert_allclose(changed(run, [there], reference).model.links[2].com, other + moved, atol=1e-12)
    assert changed(run, [lighter], reference).model.links[2].mass == pytest.approx(1.8 * links[2].mass)


@pytest.mark.parametrize("gains", [(5.0, 2.5), (2.5, 5.0), (5.0, 5.0), (2.5, 2.5)])
def test_a_change_of_several_joints_keeps_its_ratio_at_each(gains: tuple[float, float]) -> None:
    problem = demo_problem()
    reference, run = problem.plant.copy(), problem.plant.copy()
    reference.drive["gain"], run.drive["gain"] = 5.0, gains
    everywhere = guess(problem, Suspect("controller_gain", "*", (0, 1))).at({"gain": 4.5})
    assert_allclose(changed(run, [everywhere], reference).drive["gain"], 0.9 * np.array(gains))
