"""What values do is told at all joints at once, where each has its own answer: a recorded arm that is bolted down."""

from pathlib import Path

import numpy as np
import pytest
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.problem import build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import slope
from realitygap.diagnose.fit.responses import single
from realitygap.diagnose.fit.space import Space
from realitygap.diagnose.search.yardstick import Yardstick
from realitygap.scenario.file import load_scenario

SCENARIO = Path(__file__).parents[2] / "scenarios" / "so101" / "scenario.yaml"


@pytest.mark.usefixtures("data_dir")
def test_slopes_of_all_joints_at_once_are_those_of_each_alone() -> None:
    problem = build_problem(load_scenario(SCENARIO), "mujoco")
    with Simulations(problem, 1) as simulations:
        yardstick = Yardstick(simulations, [])
        for effect in ("coulomb_friction", "controller_gain"):
            space = Space(problem, [guess(problem, s) for s in suspects(problem) if s.effect == effect and single(s)])
            assert len(space.names) == 6
            where = simulations, space, space.first, yardstick.train, yardstick.floors.coarse
            before = simulations.count
            together = slope(*where, yardstick.channels)
            few = simulations.count - before
            alone = slope(*where)
            assert simulations.count - before - few == 6 * len(yardstick.train)
            cosine = np.sum(alone * together, 0) / np.linalg.norm(alone, axis=0) / np.linalg.norm(together, axis=0)
            assert np.all(cosine > 0.97)
