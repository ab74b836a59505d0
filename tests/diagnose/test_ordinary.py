"""What does no more than laws are ordinarily off by is no finding of the bundled demo (synthetic), but adjusted."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from demo_problem import DEMO, demo_problem, planted, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.problem import build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.judge import ordinary
from realitygap.diagnose.judge.gaps import WORST, held_out_gap, joint_gaps
from realitygap.diagnose.judge.held_out import Verdict
from realitygap.diagnose.judge.ordinary import Done, all_done, tolerated
from realitygap.diagnose.likelihood.floors import measure
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.found import Found
from realitygap.diagnose.search.round import MUCH
from realitygap.scenario.file import load_scenario

GAIN = 5.048
"""Of the recorded servos [duty/rad]."""


@pytest.fixture(scope="module", params=[1.02, 1.3])
def found(request: pytest.FixtureRequest) -> tuple[float, Found]:
    """The missing friction and a gain of the elbow, as if both were found; the model's gain is off by a factor."""
    file = load_scenario(DEMO).override({"servos.drive.gain": request.param * GAIN})
    problem = build_problem(file, "mujoco")
    with Simulations(problem, 2) as simulations:
        both = [guess(problem, suspect_of(problem, e, "elbow")) for e in ("coulomb_friction", "controller_gain")]
        criterion = Criterion(simulations, both)
        still, best = residual(simulations, [], criterion.train), criterion.fit(both)
        assert still is not None
        assert best is not None
        criterion.set_discrepancy(best.fit, criterion.responses(best.fit, suspects(problem)))
        found = Found(criterion.score(Fit((), still)), best, best, 6.0, {}, criterion.floors, criterion)
        done = list(all_done(found))
        assert [s.effect for s in done] == ["coulomb_friction", "controller_gain"]
        stay = tolerated(simulations, found, done)
        assert stay.adjusted == (), "what the recordings told"
        beaten = tolerated(simulations, replace(found, beaten={done[0]}), done[1:])
        assert beaten.adjusted == (done[0],), "what an unnamed effort explains better"
        return request.param, tolerated(simulations, found, [])


def test_a_gain_that_is_off_by_little_is_adjusted_and_one_that_is_off_by_much_is_named(
    found: tuple[float, Found],
) -> None:
    factor, told = found
    assert [s.effect for s in told.adjusted] == (["controller_gain"] if factor < 1.04 else [])
    assert [c.suspect.effect for c in told.best.fit.changes] == ["coulomb_friction", "controller_gain"]


@pytest.mark.parametrize("small", [True, False])
def test_a_small_limit_has_to_be_missed_on_held_out_runs(
    small: bool, judged: Any, simulations: Simulations, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same model without it leaves no gap there: what is smaller than laws are off by is adjusted then."""
    problem, criterion, bare, best, *_ = judged
    limit = guess(problem, suspect_of(problem, "torque_speed_limit", "elbow"))
    does = Done(whole=20.0, beyond=19.0, ordinary=30.0 if small else 5.0, usual=False)
    monkeypatch.setattr(ordinary, "all_done", lambda *_: {limit.suspect: does})
    floors = measure(simulations, best.fit.changes)
    for without, missed in ((best, False), (bare, True)):
        gains = {limit.suspect: MUCH * 6.0}
        found = Found(bare, best, best, 6.0, {}, floors, criterion, gains, without={limit.suspect: without})
        told = tolerated(simulations, found, [])
        assert told.adjusted == ((limit.suspect,) if small and not missed else ())


@pytest.mark.parametrize(("says", "shows"), [(0.5, False), (0.5, True), (1.5, False)])
def test_what_all_runs_say_little_for_has_to_show_in_the_gap_of_those_kept_back(
    says: float, shows: bool, judged: Any, simulations: Simulations, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, criterion, bare, best, *_ = judged
    suspect = guess(problem, suspect_of(problem, "viscous_friction", "shoulder")).suspect
    monkeypatch.setattr(ordinary, "all_done", lambda *_: {suspect: Done(50.0, 40.0, 10.0, usual=True)})
    monkeypatch.setattr(ordinary, "predicted", lambda *_: Verdict(1.0, 1.0))
    without = bare if shows else best
    found = Found(bare, best, best, 6.0, {}, measure(simulations, best.fit.changes), criterion)
    found = replace(found, gains={suspect: says * MUCH * 6.0}, without={suspect: without})
    assert tolerated(simulations, found, []).adjusted == (() if shows or says > 1.0 else (suspect,))


def test_the_gap_of_a_joint_tells_what_the_gap_of_all_hides(judged: Any, simulations: Simulations) -> None:
    """Friction of the elbow: without it the elbow is further off than the whole arm, and the shoulder hardly."""
    problem, _, bare, best, *_ = judged
    floors = measure(simulations, best.fit.changes)
    without, with_ = (joint_gaps(simulations, floors, m.fit.changes) for m in (bare, best))
    whole = [held_out_gap(simulations, floors, m.fit.changes) for m in (bare, best)]
    shoulder, elbow = without / with_
    assert elbow > whole[0] / whole[1] > shoulder
    assert np.sqrt(np.mean(without**2)) == pytest.approx(whole[0], rel=0.05)
    absurd = guess(problem, suspect_of(problem, "link_mass", "forearm")).at({"mass": np.nan})
    assert (joint_gaps(simulations, floors, [absurd]) == WORST).all(), "what cannot be simulated is furthest off"


def test_what_laws_could_not_do_is_named_however_small_and_what_they_could_do_only_beyond_them() -> None:
    small = Done(whole=20.0, beyond=19.0, ordinary=30.0, usual=False)
    assert small.named(6.0), "a ripple, that no law does"
    assert not replace(small, usual=True).named(6.0), "a torque constant that fades, as they do"
    assert not replace(small, beyond=12.0).named(6.0), "a limit, where a droop does most of it"
    assert replace(small, beyond=12.0, ordinary=25.0, usual=True).named(6.0)
    assert not replace(small, beyond=np.sqrt(11.9), ordinary=0.0).named(6.0), "all laws together could do it"


@pytest.mark.parametrize(
    ("effect", "values", "large"),
    [
        ("backlash", {"angle": 0.0005}, False),
        ("backlash", {"angle": 0.02}, True),
        ("joint_compliance", {"stiffness": 3e4}, False),
        ("joint_compliance", {"stiffness": 200.0}, True),
    ],
)
def test_play_and_springs_are_named_beyond_what_every_joint_gives_way(
    effect: str, values: dict[str, float], large: bool
) -> None:
    bare = demo_problem()
    gives = guess(bare, suspect_of(bare, effect, "elbow")).at(values)
    problem = planted(gives)
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [gives])
        still = residual(simulations, [gives], criterion.train)
        assert still is not None
        best = criterion.score(Fit((gives,), still))
        criterion.set_discrepancy(best.fit, criterion.responses(best.fit, [gives.suspect]))
        done = all_done(Found(best, best, best, 6.0, {}, criterion.floors, criterion))[gives.suspect]
    assert done.ordinary > 0.0
    assert done.large == large
    assert done.usual, "however little laws could do of it"
