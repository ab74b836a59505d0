"""What values do is told at all joints at once, where each has its own answer: a recorded arm that is bolted down."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from demo_problem import suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit, as_seen, slope
from realitygap.diagnose.fit.responses import single
from realitygap.diagnose.fit.space import Space
from realitygap.diagnose.search.criterion import Criterion
from realitygap.scenario.file import load_scenario

SCENARIO = Path(__file__).parents[2] / "scenarios" / "so101" / "scenario.yaml"


@pytest.mark.usefixtures("data_dir")
def test_slopes_of_all_joints_at_once_are_those_of_each_alone() -> None:
    problem = build_problem(load_scenario(SCENARIO), "mujoco")
    with Simulations(problem, 1) as simulations:
        criterion = Criterion(simulations, [])
        for effect in ("coulomb_friction", "controller_gain"):
            space = Space(problem, [guess(problem, s) for s in suspects(problem) if s.effect == effect and single(s)])
            assert len(space.names) == 6
            where = simulations, space, space.first, criterion.train, criterion.floors.coarse
            before = simulations.count
            together = slope(*where, criterion.channels)
            few = simulations.count - before
            alone = slope(*where)
            assert simulations.count - before - few == 6 * len(criterion.train)
            cosine = np.sum(alone * together, 0) / np.linalg.norm(alone, axis=0) / np.linalg.norm(together, axis=0)
            assert np.all(cosine > 0.97)


def test_a_value_that_shows_nowhere_is_the_models_own(problem: Problem) -> None:
    away = guess(problem, suspect_of(problem, "center_of_mass", "forearm")).at({"x": 0.01, "y": 0.02, "z": -0.2})
    stop = guess(problem, suspect_of(problem, "joint_compliance", "elbow"))
    names = ((0, "x"), (0, "y"), (0, "z"), (1, "stiffness"))
    shows = np.array([[1.0, 1e-9, 0.1, 0.0], [0.0, 0.0, 1.0, 0.0]])
    found = Fit((away, stop), np.zeros(2), names, shows, np.ones(4), np.zeros(4))
    seen = as_seen(problem, found)
    assert seen.changes == (away.at({"y": 0.0}), stop), "what does nothing at all stays, too"
    assert as_seen(problem, replace(found, slope=np.abs(shows) + 1e-3)).changes == found.changes


def test_a_load_lies_at_its_links_frame_along_an_axis_of_which_nothing_tells(problem: Problem) -> None:
    load = guess(problem, suspect_of(problem, "payload", "forearm")).at({"x": 0.03, "y": 4e-13, "z": -0.2})
    shows = np.array([[1.0, 0.2, 1e-9, 0.1], [0.0, 0.3, 0.0, 1.0]])
    found = Fit((load,), np.zeros(2), tuple((0, n) for n in load.free), shows, np.ones(4), np.zeros(4))
    assert load.free == ("mass", "x", "y", "z")
    assert as_seen(problem, found).changes == (load.at({"y": 0.0}),)
