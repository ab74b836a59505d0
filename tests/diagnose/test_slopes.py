"""What values do is told at all joints at once, where each has its own answer: a recorded arm that is bolted down."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from demo_problem import suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import neutral, suspects
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit, slope
from realitygap.diagnose.fit.motions import residual
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
            where = criterion.motions, space, space.first
            before = simulations.count
            together = slope(*where, criterion.channels)
            few = simulations.count - before
            alone = slope(*where)
            assert simulations.count - before - few == 6 * len(criterion.train)
            cosine = np.sum(alone * together, 0) / np.linalg.norm(alone, axis=0) / np.linalg.norm(together, axis=0)
            assert np.all(cosine > 0.97)


LEVER = {"x": 0.01, "y": 0.02, "z": -0.2}
"""Of the demo's forearm, whose hinge is about y: along that nothing shows."""


@pytest.mark.parametrize(
    ("effect", "free", "values"),
    [
        ("center_of_mass", ("x", "y", "z"), LEVER),
        ("payload", ("mass", "x", "y", "z"), {"mass": 0.2, **LEVER}),
        ("payload", ("mass", "x", "z"), {"mass": 0.2, **LEVER}),
        ("payload", ("mass", "y"), {"mass": 0.2, "x": 0.0, "y": 4e-13, "z": -0.2}),
    ],
)
def test_a_value_that_shows_nowhere_is_the_models_own(
    problem: Problem, simulations: Simulations, effect: str, free: tuple[str, ...], values: dict[str, float]
) -> None:
    away = replace(guess(problem, suspect_of(problem, effect, "forearm")).at(values), free=free)
    stop = guess(problem, suspect_of(problem, "joint_compliance", "elbow"))
    criterion = Criterion(simulations, [])
    first = residual(simulations, [away, stop], criterion.train)
    assert first is not None
    names = (*((0, n) for n in free), (1, "stiffness"))
    size, prior = np.ones(len(names)), np.zeros(len(names))
    found = criterion.plain(Fit((away, stop), first, names, np.ones((len(first), len(names))), size, prior))
    seen = criterion.seen(found).fit
    assert seen.changes == (away.at({"y": 0.0}) if "y" in free else away, stop)
    assert [not c.any() for c in seen.slope.T] == [name == (0, "y") for name in names], "what shows not has no slope"


def test_what_does_nothing_by_any_value_stays(problem: Problem, simulations: Simulations) -> None:
    suspect = suspect_of(problem, "center_of_mass", "forearm")
    own = neutral(problem.plant, suspect)
    away = replace(guess(problem, suspect).at({**own, "x": own["x"] + 1e-12, "y": 0.02}), free=("x", "y"))
    criterion = Criterion(simulations, [])
    first = residual(simulations, [away], criterion.train)
    assert first is not None
    names = ((0, "x"), (0, "y"))
    found = criterion.plain(Fit((away,), first, names, np.ones((len(first), 2)), np.ones(2), np.zeros(2)))
    assert criterion.seen(found).fit.changes == (away,)
