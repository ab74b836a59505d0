"""A round of the search on the bundled demo (synthetic): models are compared at their best, and no move is lost."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from demo_problem import FRICTION, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.changes import ModelKey, model_key
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.search import prune
from realitygap.diagnose.search import round as round_module
from realitygap.diagnose.search.apart import compare
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.discrepancy import KNOWN, SHARE
from realitygap.diagnose.search.exchange import Exchanged, exchanged
from realitygap.diagnose.search.grow import _ways, grown, shared
from realitygap.diagnose.search.round import Round
from realitygap.diagnose.search.search import needed


@pytest.fixture(scope="module")
def round_(problem: Problem, simulations: Simulations) -> Round:
    """At the scenario's own model, where the friction of the elbow is missing."""
    names = ("coulomb_friction", "viscous_friction", "controller_gain", "supply_voltage")
    everyone = [suspect_of(problem, n, "elbow") for n in names]
    left = residual(simulations, [], problem.of("train"))
    assert left is not None
    return Round(simulations, Fit((), left), everyone, needed(len(everyone)), Fit((), left), print)


def test_what_another_model_gains_by_fitting_better_is_no_gain_of_its_own(problem: Problem, round_: Round) -> None:
    friction, more = (guess(problem, suspect_of(problem, n, "elbow")) for n in ("coulomb_friction", "viscous_friction"))
    best, other = (round_.criterion.fit(changes) for changes in ([friction], [friction, more]))
    assert best is not None
    assert other is not None
    away = friction.at({"torque": 1.3 * FRICTION})
    left = residual(round_.simulations, [away], round_.criterion.train)
    assert left is not None
    badly = replace(best.fit, changes=(away,), residual=left, here=False)
    now = round_.now
    try:
        round_.now = round_.criterion.score(badly)
        assert other.evidence > round_.now.evidence + round_.limit
        round_.led(other)
        assert model_key(round_.now.fit.changes) == model_key([friction])
        assert other.evidence < round_.now.evidence + round_.limit
        kept = round_.now
        round_.led(replace(other, fit=replace(other.fit, changes=(away, other.fit.changes[1]))))
        assert round_.now.evidence >= kept.evidence
    finally:
        round_.now = now


def test_what_laws_leave_is_asked_of_what_is_new_by_its_kind(problem: Problem, round_: Round) -> None:
    """Of friction what friction leaves, of a gain what the drive leaves, and of a model with nothing new the most."""
    friction, gain = (guess(problem, suspect_of(problem, n, "elbow")) for n in ("viscous_friction", "controller_gain"))
    discrepancy_scale = {"friction": 1.0, "drive": 0.5, "load": 0.5, "": 2.0, "clock": 2.0}
    own, explained = replace(round_.now, discrepancy_scale=discrepancy_scale), round_.explained
    try:
        round_.explained = 1000.0
        little = {c: round_.little(replace(own, fit=replace(own.fit, changes=(c,)))) for c in (friction, gain)}
        assert little[friction] == pytest.approx(1000.0 * SHARE["friction"] ** 2)
        assert little[gain] == pytest.approx(1000.0 * (0.5 * SHARE["drive"]) ** 2)
        assert round_.little(own) == max(little.values())
    finally:
        round_.explained = explained


def test_what_is_explained_leaves_no_more_than_what_is_not_known_of_it(
    problem: Problem, round_: Round, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Friction may be off by 16 %; of a delay that explains all so far less is not known."""
    delay, friction = (guess(problem, suspect_of(problem, n, "elbow")) for n in ("command_delay", "viscous_friction"))
    discrepancy_scale = {"friction": 2.0, "": 0.5}
    alone = replace(round_.now, discrepancy_scale=discrepancy_scale, fit=replace(round_.now.fit, changes=(delay,)))
    monkeypatch.setattr(round_, "explained", 1000.0)
    monkeypatch.setattr(round_, "now", alone)
    both = replace(alone, fit=replace(alone.fit, changes=(delay, friction)))
    assert round_.little(both) == pytest.approx(1000.0 * (0.5 * KNOWN["command_delay"]) ** 2)


def test_what_laws_leave_is_asked_where_a_finding_acts_only_of_a_motion_that_is_followed(
    problem: Problem, round_: Round, monkeypatch: pytest.MonkeyPatch
) -> None:
    share, now = 0.25, round_.now
    monkeypatch.setattr(round_module, "reached", lambda *_: share)
    monkeypatch.setattr(round_, "explained", 1000.0)
    simulated = round_.leaves(now, {"friction"}, now)
    assert simulated > 0.0
    cases = [SimpleNamespace(experiment=SimpleNamespace(followed=True)) for _ in problem.cases]
    monkeypatch.setattr(round_, "simulations", SimpleNamespace(problem=SimpleNamespace(cases=cases)))
    assert round_.leaves(now, {"friction"}, now) == pytest.approx(share * simulated)


def test_moves_that_failed_are_tried_again_where_nothing_else_gains(problem: Problem, round_: Round) -> None:
    friction, other = (guess(problem, suspect_of(problem, n, "elbow")) for n in ("coulomb_friction", "supply_voltage"))
    ways = [([friction], round_.limit), ([other], round_.limit)]
    failed: set[ModelKey] = set()
    found = grown(round_, [], failed, again=True, ways=ways)
    assert found is not None
    right, wrong = model_key([friction]), model_key([other])
    assert model_key(found.fit.changes) == right
    assert right not in failed
    assert grown(round_, [], {right}, again=False, ways=ways) is None
    again = grown(round_, [], failed := {right}, again=True, ways=ways)
    assert again is not None
    assert model_key(again.fit.changes) == right
    assert failed == {right, wrong}


def test_fewer_findings_may_lose_what_another_would_have_had_to_gain(problem: Problem, round_: Round) -> None:
    names = ("coulomb_friction", "supply_voltage")
    friction, other = (guess(problem, suspect_of(problem, n, "elbow")) for n in names)
    both = round_.criterion.fit([friction, other])
    assert both is not None
    now = round_.now
    try:
        round_.now = both
        fewer = grown(round_, [], set(), again=True, ways=[([both.fit.changes[0]], -round_.limit)])
        assert fewer is not None
        assert model_key(fewer.fit.changes) == model_key([friction])
        more = grown(round_, [], set(), again=True, ways=[([both.fit.changes[1]], -round_.limit)])
        assert more is None
        out = exchanged(round_, [], Exchanged())
        assert out.better is not None
        assert model_key(out.better.fit.changes) == model_key([friction])
        assert not out.rivals
    finally:
        round_.now = now


def test_what_promises_nothing_is_tried_too_and_what_gains_little_is_spared(
    problem: Problem, simulations: Simulations
) -> None:
    """Beside the friction that the demo lacks nothing is missing: a supply there is tried, and would go again."""
    friction, other = (guess(problem, suspect_of(problem, n, "elbow")) for n in ("coulomb_friction", "supply_voltage"))
    left = residual(simulations, [], problem.of("train"))
    found = Criterion(simulations, []).fit([friction])
    assert left is not None
    assert found is not None
    at = Round(simulations, found.fit, [friction.suspect, other.suspect], needed(2), Fit((), left), print)
    at.candidates = []
    assert any(model_key(way) == model_key([friction, other]) for way, _ in _ways(at))
    both = at.criterion.fit([*at.now.fit.changes, other], at.now.fit)
    without = at.criterion.fit([other])
    assert both is not None
    assert without is not None
    assert not at.earned(both, at.now, at.limit)
    assert at.earned(both, without, at.limit)
    error = compare(at.criterion.channels, both, without)[1]

    def earned(errors: float, needs: float) -> bool:
        return at.earned(replace(both, evidence=without.evidence + errors * error), without, needs * error)

    assert [earned(2.0, 1.0), earned(2.5, 1.0), earned(2.5, 3.0)] == [False, True, False], "told by stretches"
    assert earned(1.0, 0.05), "what is plain may show in one of them alone"


def test_what_joints_have_each_of_their_own_gets_one_value_where_that_loses_little(
    problem: Problem, simulations: Simulations
) -> None:
    """The demo's elbow has another friction than its shoulder, and both have the gain that the model has."""
    kinds = ("coulomb_friction", "controller_gain")
    alone = [guess(problem, suspect_of(problem, n, j)) for n in kinds for j in ("shoulder", "elbow")]
    everyone = [*(c.suspect for c in alone), *(suspect_of(problem, n, "*") for n in kinds)]
    left = residual(simulations, [], problem.of("train"))
    assert left is not None
    nothing = Fit((), left)
    found = Criterion(simulations, []).fit(alone)
    assert found is not None
    at = Round(simulations, found.fit, everyone, needed(len(everyone)), nothing, print)
    friction, gain = shared(at)
    values = [c.parameters["torque"] for c in at.now.fit.changes if c.suspect.effect == "coulomb_friction"]
    assert friction[0][-1].parameters["torque"] == pytest.approx(np.median(values))
    assert friction[1] == gain[1] == -at.limit
    assert grown(at, [], set(), again=True, ways=[friction]) is None
    one = grown(at, [], set(), again=True, ways=[gain])
    assert one is not None
    assert [c.suspect.target for c in one.fit.changes if c.suspect.effect == "controller_gain"] == ["*"]


def test_a_round_goes_on_beside_a_little_that_was_found_and_not_beside_much(
    problem: Problem, simulations: Simulations
) -> None:
    """A gain of the elbow that was named and is left out again: what it stands for can be named anew, and all is
    compared as before. Beside a friction that explains most, laws have to be looked at anew."""
    friction, gain = (guess(problem, suspect_of(problem, n, "elbow")) for n in ("coulomb_friction", "controller_gain"))
    everyone = [friction.suspect, gain.suspect, suspect_of(problem, "viscous_friction", "elbow")]
    left = residual(simulations, [], problem.of("train"))
    criterion = Criterion(simulations, [])
    found, much = criterion.fit([friction, gain]), criterion.fit([friction])
    assert left is not None
    assert found is not None
    assert much is not None
    far = Round(simulations, Fit((), left), everyone, needed(len(everyone)), Fit((), left), print)
    assert not far.moved(much)
    assert far.now.fit.changes == ()
    at = Round(simulations, found.fit, everyone, needed(len(everyone)), Fit((), left), print)
    assert {b.suspect.effect for b in at.blocks} == {"viscous_friction"}
    less = at.adjusted([c for c in at.now.fit.changes if c.suspect == friction.suspect])
    assert less is not None
    assert at.moved(less)
    assert {b.suspect.effect for b in at.blocks} == {"viscous_friction", "controller_gain"}
    assert {p.block.suspect for p in at.linear_gains} == {gain.suspect, everyone[2]}
    assert at.explained == pytest.approx(less.evidence - at.criterion.score(Fit((), left)).evidence)
    assert model_key(at.retold().fit.changes) == model_key([friction])


def test_what_straight_lines_wrongly_call_superfluous_stays_and_the_rest_goes(
    problem: Problem, round_: Round, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that is needed among those that are not, wherever it stands: halves are tried until it is alone."""
    names = ("viscous_friction", "coulomb_friction", "controller_gain", "supply_voltage")
    whole = round_.criterion.fit([guess(problem, suspect_of(problem, n, "elbow")) for n in names], care="compared")
    assert whole is not None
    every = [c.suspect for c in whole.fit.changes]
    friction = suspect_of(problem, "coulomb_friction", "elbow")
    monkeypatch.setattr(prune, "superfluous", lambda *_: every)
    assert [c.suspect for c in prune.pruned(round_, whole, []).fit.changes] == [friction]
    kept = [suspect_of(problem, "supply_voltage", "elbow")]
    monkeypatch.setattr(prune, "superfluous", lambda *_: [s for s in every if s not in kept])
    assert {c.suspect for c in prune.pruned(round_, whole, kept).fit.changes} == {friction, *kept}
