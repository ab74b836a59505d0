"""What is adjusted gets its name where its interval tells it in the end: on the bundled demo (synthetic)."""

from dataclasses import replace

import numpy as np
import pytest
from demo_problem import demo_problem, planted, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.judge import again
from realitygap.diagnose.judge.again import told_after_all
from realitygap.diagnose.judge.likeliest_name import likeliest_name
from realitygap.diagnose.judge.ordinary import all_done
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.found import Found
from realitygap.diagnose.search.rivals import Rival


@pytest.mark.parametrize("there", [True, False], ids=["missing", "not missing"])
def test_what_an_interval_tells_beside_what_is_adjusted_is_named(there: bool) -> None:
    bare = demo_problem()
    dry = guess(bare, suspect_of(bare, "coulomb_friction", "elbow")).at({"torque": 0.6})
    viscous = guess(bare, suspect_of(bare, "viscous_friction", "shoulder")).at({"coefficient": 0.4})
    problem = planted(dry, viscous) if there else planted(dry)
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [dry, viscous])
        still, best = residual(simulations, [], criterion.train), criterion.fit([dry, viscous])
        assert still is not None
        assert best is not None
        criterion.set_discrepancy(best.fit, criterion.responses(best.fit, suspects(problem)))
        best = criterion.score(best.fit)
        base, cautious, s = criterion.score(Fit((), still)), criterion.cautious(best.fit), viscous.suspect
        found = Found(base, best, cautious, 6.0, {}, criterion.floors, criterion, adjusted=(s,))
        assert told_after_all(simulations, replace(found, adjusted=()), {}).gains == {}, "nothing is adjusted"
        beaten = replace(found, beaten=(s,))
        assert told_after_all(simulations, beaten, {}) is beaten, "an unnamed effort explains that better"
        told = told_after_all(simulations, found, {})
    assert told.adjusted == (() if there else (s,))
    assert (s in told.gains) is there
    assert told.best is best, "values are as they were"
    if there:
        assert told.gains[s] > found.limit
        assert told.rivals == {s: []}
        assert told.least == {s: found.limit}
        assert {c.suspect for c in told.without[s].fit.changes} == {dry.suspect}


@pytest.mark.parametrize(("whole", "named"), [(2.2, True), (1.8, False)])
def test_what_is_adjusted_is_named_where_it_does_clearly_more_than_laws_are_off_by(
    monkeypatch: pytest.MonkeyPatch, whole: float, named: bool
) -> None:
    """Twice as much, however well it is told: of a law that is off by what laws are off by nothing is missing."""
    bare = demo_problem()
    dry = guess(bare, suspect_of(bare, "coulomb_friction", "elbow")).at({"torque": 0.6})
    problem = planted(dry)
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [dry])
        still, best = residual(simulations, [], criterion.train), criterion.fit([dry])
        assert still is not None
        assert best is not None
        criterion.set_discrepancy(best.fit, criterion.responses(best.fit, [dry.suspect]))
        base, best = criterion.score(Fit((), still)), criterion.score(best.fit)
        cautious = criterion.cautious(best.fit)
        found = Found(base, best, cautious, 6.0, {}, criterion.floors, criterion, adjusted=(dry.suspect,))
        does = all_done(found)[dry.suspect]
        monkeypatch.setattr(Criterion, "typical", lambda *_: does.whole / whole)
        told = told_after_all(simulations, found, {})
    assert does.whole > 10.0, "it is plain to see"
    assert told.adjusted == (() if named else (dry.suspect,))


def test_what_is_named_after_all_gets_the_likeliest_name() -> None:
    """Straight lines adjusted a constant effort; nobody had asked what could stand in its place."""
    bare = demo_problem()
    turned = guess(bare, suspect_of(bare, "joint_offset", "elbow")).at({"angle": 0.12})
    push = guess(bare, suspect_of(bare, "constant_effort", "elbow")).at({"effort": -0.2})
    problem = planted(turned)
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [push])
        still, best = residual(simulations, [], criterion.train), criterion.fit([push])
        assert still is not None
        assert best is not None
        blocks = criterion.responses(best.fit, suspects(problem))
        criterion.set_discrepancy(best.fit, blocks)
        base, best, s = criterion.score(Fit((), still)), criterion.score(best.fit), push.suspect
        found = Found(base, best, best, 6.0, {}, criterion.floors, criterion, {s: 50.0}, {s: base}, blocks=blocks)
        told = likeliest_name(simulations, found, s)
        other = Rival(turned.suspect, best, 1.0, 1.0)
        asked = replace(found, rivals={s: [other]})
        assert likeliest_name(simulations, asked, s) is asked, "the search has asked"
        alone = likeliest_name(simulations, replace(found, blocks=[]), s)
    assert alone.best is best
    assert alone.rivals == {s: []}
    (change,) = told.best.fit.changes
    others = {r.suspect for r in told.rivals[change.suspect]}
    assert turned.suspect in {change.suspect, *others}, "a centre of mass that is turned by as much does the same"
    assert change.suspect != s
    assert s in others
    assert told.best.evidence > best.evidence + 100.0


def test_what_other_values_may_take_over_is_no_more_than_laws_are_off_by(monkeypatch: pytest.MonkeyPatch) -> None:
    """Dry friction does more than twice that where those of load and speed stay as they are."""
    bare = demo_problem()
    dry = guess(bare, suspect_of(bare, "coulomb_friction", "elbow")).at({"torque": 0.6})
    load = guess(bare, suspect_of(bare, "load_dependent_friction", "elbow")).at({"coefficient": 0.3})
    viscous = guess(bare, suspect_of(bare, "viscous_friction", "elbow")).at({"coefficient": 0.4})
    problem = planted(dry, load, viscous)
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [dry, load, viscous])
        best, without = criterion.fit([dry, load, viscous]), criterion.fit([load, viscous])
        assert best is not None
        assert without is not None
        criterion.set_discrepancy(best.fit, criterion.responses(best.fit, [dry.suspect, load.suspect, viscous.suspect]))
        best, without = criterion.score(best.fit), criterion.score(without.fit)
        cautious = criterion.cautious(best.fit)
        found = Found(without, best, cautious, 6.0, {}, criterion.floors, criterion, adjusted=(dry.suspect,))
        does = all_done(found)[dry.suspect]
        apart = float(np.linalg.norm(criterion.discrepancy_metric(without.fit.residual - best.fit.residual)))
        monkeypatch.setattr(Criterion, "typical", lambda *_: does.whole / 2.2)
        told = told_after_all(simulations, found, {})
    assert apart < 0.6 * does.whole
    assert best.evidence - without.evidence > 20.0, "it is plain to see"
    assert told.adjusted == (dry.suspect,)


@pytest.mark.parametrize(
    ("errors", "clear", "named"), [(1.0, 1.3, False), (1.6, 1.3, True), (1.6, 1e6, False), (None, 1e6, True)]
)
def test_what_an_interval_does_not_tell_beside_what_is_adjusted_has_no_name(
    errors: float | None, clear: float, named: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However much evidence there is, but where held-out runs clearly miss it: the gap is so many times as large."""
    monkeypatch.setattr(again, "CLEAR", clear)
    bare = demo_problem()
    dry = guess(bare, suspect_of(bare, "coulomb_friction", "elbow")).at({"torque": 0.6})
    viscous = guess(bare, suspect_of(bare, "viscous_friction", "shoulder")).at({"coefficient": 0.4})
    problem = planted(dry, viscous)
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [dry, viscous])
        best = criterion.fit([dry, viscous])
        assert best is not None
        criterion.set_discrepancy(best.fit, criterion.responses(best.fit, [dry.suspect, viscous.suspect]))
        best = criterion.score(best.fit)
        cautious, s = criterion.cautious(best.fit), viscous.suspect
        of = np.array([best.fit.changes[i].suspect == s for i, _ in best.fit.names])
        if errors is not None:
            cautious = replace(cautious, away=np.where(of, np.abs(best.fit.value / best.fit.size) / errors, 0.0))
        gains = dict.fromkeys((dry.suspect, s), 500.0)
        found = Found(best, best, cautious, 6.0, {s: 6.0}, criterion.floors, criterion, gains=gains)
        told, untold = again.untold_after_all(simulations, found, [])
        kept, none = again.untold_after_all(simulations, found, [s])
    assert untold == [s] * (not named)
    assert told.adjusted == (s,) * (not named)
    assert told.best is best, "values are as they were"
    assert kept.adjusted == ()
    assert none == []


@pytest.mark.parametrize(
    ("effect", "value", "whole", "clear", "named"),
    [
        ("coulomb_friction", {"torque": 0.6}, 2.2, 1e6, True),
        ("coulomb_friction", {"torque": 0.6}, 1.8, 1e6, False),
        ("coulomb_friction", {"torque": 0.6}, 1.8, 1.3, True),
        ("viscous_friction", {"coefficient": 0.4}, 1.8, 1e6, True),
    ],
    ids=["more", "usual", "missed", "of which the model has none"],
)
def test_what_laws_may_be_off_by_has_no_name_but_where_held_out_runs_clearly_miss_it(
    effect: str, value: dict[str, float], whole: float, clear: float, named: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(again, "CLEAR", clear)
    bare = demo_problem()
    change = guess(bare, suspect_of(bare, effect, "elbow")).at(value)
    problem = planted(change)
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [change])
        best = criterion.fit([change])
        assert best is not None
        criterion.set_discrepancy(best.fit, criterion.responses(best.fit, [change.suspect]))
        best = criterion.score(best.fit)
        found = Found(best, best, criterion.cautious(best.fit), 6.0, {}, criterion.floors, criterion)
        does = all_done(found)[change.suspect]
        monkeypatch.setattr(Criterion, "typical", lambda *_: does.whole / whole)
        told, small = again.usual_after_all(simulations, found, [])
        kept, none = again.usual_after_all(simulations, found, [change.suspect])
    assert small == [change.suspect] * (not named)
    assert told.adjusted == (change.suspect,) * (not named)
    assert told.best is best, "values are as they were"
    assert (kept.adjusted, none) == ((), [])
