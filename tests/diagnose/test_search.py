"""The search on the bundled demo (synthetic): moves that the straight-line model promises come true in simulation."""

from collections.abc import Iterator

import numpy as np
import pytest
from demo_problem import demo_problem, suspect_of
from realitygap.diagnose.candidates.starts import guess, starts
from realitygap.diagnose.data.changes import clash
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.data.worker import Question, answer
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.responses import residual, respond
from realitygap.diagnose.search.evidence import stretches
from realitygap.diagnose.search.linear import Linear
from realitygap.diagnose.search.model import Ground

FRICTION = 0.6447
"""Coulomb friction of the recorded elbow [N·m]."""


@pytest.fixture(scope="module")
def problem() -> Problem:
    return demo_problem()


@pytest.fixture(scope="module")
def simulations(problem: Problem) -> Iterator[Simulations]:
    with Simulations(problem, 2) as made:
        yield made


@pytest.fixture(scope="module")
def ground(simulations: Simulations) -> Ground:
    return Ground(simulations, [])


def test_a_worker_says_what_this_process_says(problem: Problem, simulations: Simulations) -> None:
    asked = [Question((), c, "mujoco", 0.5) for c in (1, 2)]
    for question, there in zip(asked, simulations.ask(asked), strict=True):
        here = answer(problem, question)
        assert here is not None
        assert there is not None
        for signal in here:
            assert np.array_equal(here[signal], there[signal]), signal


def test_what_was_simulated_is_remembered(simulations: Simulations) -> None:
    asked = [Question((), 1, "mujoco", 0.5)]
    simulations.ask(asked)
    before = simulations.count
    simulations.ask(asked)
    assert simulations.count == before


def test_the_true_value_has_more_evidence_than_its_neighbours(
    problem: Problem, simulations: Simulations, ground: Ground
) -> None:
    friction = guess(problem, suspect_of(problem, "coulomb_friction", "elbow"))
    evidence = {}
    for torque in (0.3, 0.5, FRICTION, 0.8):
        left = residual(simulations, [friction.at({"torque": torque})], ground.train)
        assert left is not None
        evidence[torque] = ground.score(Fit((friction.at({"torque": torque}),), left)).evidence
    assert max(evidence, key=lambda torque: evidence[torque]) == FRICTION


def test_a_fit_finds_what_was_planted(problem: Problem, simulations: Simulations, ground: Ground) -> None:
    friction = guess(problem, suspect_of(problem, "coulomb_friction", "elbow"))
    found = ground.fit([friction])
    assert found is not None
    assert found.fit.value[0] == pytest.approx(FRICTION, rel=0.04)
    assert found.deviation[0] > 0.0


def test_the_straight_line_promises_most_of_what_is_missing(
    problem: Problem, simulations: Simulations, ground: Ground
) -> None:
    left = residual(simulations, [], ground.train)
    assert left is not None
    base = ground.score(Fit((), left))
    names = ("coulomb_friction", "viscous_friction", "joint_offset", "controller_gain")
    tried = [s for n in names for s in starts(problem, suspect_of(problem, n, "elbow"))]
    blocks = respond(simulations, [], tried, ground.train, ground.floors.coarse, ground.channels)
    linear = Linear(base.metric, left, np.zeros((len(left), 0)), blocks)
    promised = linear.promises()
    assert promised[0].block.suspect.effect == "coulomb_friction"
    assert promised[0].change.parameters["torque"] == pytest.approx(FRICTION, rel=0.4)
    several = linear.several(3.0)
    assert not any(clash(a.block.suspect, b.block.suspect) for a in several for b in several if a is not b)
    assert [p.block.suspect.effect for p in several][:1] == ["coulomb_friction"]


def test_what_the_accepted_values_could_do_is_no_gain_of_another(
    problem: Problem, simulations: Simulations, ground: Ground
) -> None:
    """The response of a suspect that is already in promises nothing: it is orthogonalised away."""
    left = residual(simulations, [], ground.train)
    assert left is not None
    base = ground.score(Fit((), left))
    tried = starts(problem, suspect_of(problem, "coulomb_friction", "elbow"))
    blocks = respond(simulations, [], tried, ground.train, ground.floors.coarse, ground.channels)
    beside = Linear(base.metric, left, blocks[0].columns, blocks).promises()[0]
    alone = Linear(base.metric, left, np.zeros((len(left), 0)), blocks).promises()[0]
    assert beside.gain < 0.05 * alone.gain


def test_stretches_part_motions_and_seconds(ground: Ground) -> None:
    number = stretches(ground.channels)
    at = 0
    of: dict[int, set[int]] = {}
    for channel in ground.channels:
        n = len(channel.time)
        own = set(number[at : at + n].tolist())
        assert len(own) == int((channel.time[-1] - channel.time[0]) / 1.0) + 1
        of.setdefault(channel.case, own)
        assert of[channel.case] == own
        at += n
    assert len(set.union(*of.values())) == sum(map(len, of.values()))
