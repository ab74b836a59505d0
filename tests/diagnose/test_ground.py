"""Diagnosis of a cube that slides: what is wrong with the ground is named, also from far away."""

import pytest
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.locate import locate
from realitygap.diagnose.likelihood.floors import measure
from realitygap.diagnose.search.search import search
from realitygap.scenario.file import load_scenario
from synthetic_tosses import write_tosses

TRUE = 0.17
"""Friction of the ground that the cube was thrown on; the scenario says 0.8."""


@pytest.fixture(scope="module")
def thrown(tmp_path_factory: pytest.TempPathFactory) -> Problem:
    """Six tosses and the scenario that believes in a rougher ground."""
    path = write_tosses(tmp_path_factory.mktemp("tosses"), TRUE)
    return build_problem(load_scenario(path), "mujoco")


def test_a_ground_that_is_slippery_is_named_from_a_rough_one(thrown: Problem) -> None:
    with Simulations(thrown, 2) as simulations:
        found = search(simulations, suspects(thrown), [], lambda _: None)
    (first,) = found.best.fit.changes
    assert first.suspect.effect == "ground_friction"
    assert first.parameters["coefficient"] == pytest.approx(TRUE, rel=0.1)


def test_where_a_throw_differs_is_said_of_the_base(thrown: Problem) -> None:
    with Simulations(thrown, 2) as simulations:
        floors = measure(simulations, [])
        answers = simulations.of([], range(len(thrown.cases)))
        places = locate(thrown, floors, {i: a for i, a in enumerate(answers) if a is not None})
    first = places[0]
    assert (first.joint, first.signal, first.unit) == ("base", "base_position", "m")
    assert first.gap > 10 * first.noise_floor


def test_a_body_alone_carries_nothing_that_is_not_the_body(thrown: Problem, problem: Problem) -> None:
    body = {"link_mass", "center_of_mass", "link_inertia"}
    here, arm = ({s.effect for s in suspects(p)} for p in (thrown, problem))
    assert body <= here
    assert "payload" not in here
    assert "payload" in arm
