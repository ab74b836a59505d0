"""Shapes of what was found: begun again where they run away."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from demo_problem import suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import begun_again
from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.demanded import demanded
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.space import Space
from realitygap.diagnose.search.grow import _ways
from realitygap.diagnose.search.round import Round
from realitygap.diagnose.search.search import _richer, needed
from realitygap.robot.effects import EFFECTS

FREE = ("static", "coulomb", "velocity")
CREEPING = {"static": 0.6, "coulomb": 0.45, "velocity": 1e-3}


def test_the_speed_at_which_friction_falls_begins_again_and_all_else_stays(problem: Problem) -> None:
    slow = replace(guess(problem, suspect_of(problem, "stribeck_friction", "elbow")).at(CREEPING), free=FREE)
    again = begun_again(problem.plant, slow)
    assert again.parameters["velocity"] > 100 * slow.parameters["velocity"]
    assert again.at({"velocity": slow.parameters["velocity"]}) == slow
    assert begun_again(problem.plant, again) == again
    fixed = replace(slow, free=FREE[:2])
    mass = guess(problem, suspect_of(problem, "link_mass", "forearm"))
    assert [begun_again(problem.plant, c) for c in (fixed, mass)] == [fixed, mass], "nothing to begin again"


def test_a_speed_that_ran_to_where_it_shows_nothing_is_tried_from_its_first_guess(
    problem: Problem, simulations: Simulations
) -> None:
    name = suspect_of(problem, "stribeck_friction", "elbow")
    slow = replace(guess(problem, name).at(CREEPING), free=FREE)
    train = problem.of("train")
    nothing, at = (Fit(tuple(c), demanded(simulations, c, train)) for c in ([], [slow]))
    round_ = Round(simulations, at, [name], needed(1), nothing, print)
    round_.now = replace(round_.now, fit=replace(round_.now.fit, changes=(slow,)))
    assert [begun_again(problem.plant, slow)] in [way for way, _ in _ways(round_)]


def test_a_shape_that_gains_more_than_another_name_comes_first(problem: Problem) -> None:
    friction = guess(problem, suspect_of(problem, "coulomb_friction", "elbow"))
    other = guess(problem, suspect_of(problem, "viscous_friction", "elbow"))
    shaped = replace(friction, free=("torque", "onset")).at({"onset": 0.1})

    def model(evidence: float, *changes: Change) -> Any:
        return SimpleNamespace(evidence=evidence, fit=SimpleNamespace(changes=changes))

    round_ = cast("Round", SimpleNamespace(now=model(0.0, friction)))
    assert _richer(round_, model(9.0, shaped), model(5.0, other))
    assert not _richer(round_, model(5.0, shaped), model(9.0, other))
    assert not _richer(round_, model(9.0, friction, other), model(5.0, other))


def test_every_shape_that_may_be_about_zero_says_what_is_much_of_it() -> None:
    signed = [(e, p) for e in EFFECTS.values() for p in e.parameters if p.shape and p.low < 0.0 < p.high]
    assert {(e.name, p.name) for e, p in signed} >= {
        ("payload", "x"),
        ("cable_spring", "rest"),
        ("torque_ripple", "phase"),
    }
    assert all(0.0 < p.typical < p.high for _, p in signed)
    assert not any(p.typical for e in EFFECTS.values() for p in e.parameters if not p.shape)


@pytest.mark.parametrize(
    ("effect", "target", "shape"), [("payload", "forearm", "x"), ("cable_spring", "elbow", "rest")]
)
def test_how_far_a_shape_may_be_off_does_not_hang_on_how_close_to_zero_it_is(
    problem: Problem, effect: str, target: str, shape: str
) -> None:
    first = guess(problem, suspect_of(problem, effect, target))
    change = replace(first, free=(first.suspect.kind.parameters[0].name, shape))
    there = [Space(problem, [change.at({shape: value})]).scale for value in (0.0, 1e-12, -1e-3, 0.01)]
    assert np.ptp(there, axis=0).max() == 0.0
    far = Space(problem, [change.at({shape: 0.5})])
    assert far.scale[1] > there[0][1]
    assert far.scale[0] == there[0][0]
