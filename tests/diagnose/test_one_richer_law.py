"""One law in the place of its special case and of another finding at its joints, and one value in the place of one at
each joint, on the bundled demo (synthetic).
"""

from typing import Any

import pytest
from demo_problem import demo_problem, planted, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.joined import joined
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.found import Found
from realitygap.diagnose.search.round import MUCH

LIMIT = 6.0


def _found(simulations: Simulations, begun: list[Change], little: Suspect, gain: float) -> Found:
    """What was found, of which one gains so much, as if a machine told less of it."""
    problem = simulations.problem
    criterion = Criterion(simulations, begun)
    best = criterion.fit(begun)
    assert best is not None
    there = [s for s in suspects(problem) if s.target == "elbow"]
    criterion.set_discrepancy(best.fit, criterion.responses(best.fit, there))
    best = criterion.score(best.fit)
    return Found(best, best, best, LIMIT, {}, criterion.floors, criterion, {little: gain})


@pytest.mark.parametrize("plain", [False, True])
def test_dry_friction_beside_a_constant_effort_is_friction_by_side(plain: bool) -> None:
    """Unless the effort gains far more than friction by side would have to."""
    bare = demo_problem()
    sides, dry, effort = (
        guess(bare, suspect_of(bare, e, "elbow")) for e in ("direction_friction", "coulomb_friction", "constant_effort")
    )
    problem = planted(sides.at({"forward": 0.75, "backward": 0.45}))
    begun = [dry.at({"torque": 0.6}), effort.at({"effort": -0.15})]
    with Simulations(problem, 2) as simulations:
        found = _found(simulations, begun, effort.suspect, (2.0 if plain else 0.5) * MUCH * LIMIT)
        told = joined(simulations, found, suspects(problem), [])
        kept = joined(simulations, found, suspects(problem), [dry.suspect])
    assert [c.suspect for c in kept.best.fit.changes] == [dry.suspect, effort.suspect]
    if plain:
        assert [c.suspect for c in told.best.fit.changes] == [dry.suspect, effort.suspect]
        return
    (change,) = told.best.fit.changes
    assert change.suspect == sides.suspect
    assert change.parameters["forward"] == pytest.approx(0.75, rel=0.03)
    assert change.parameters["backward"] == pytest.approx(0.45, rel=0.03)


def test_what_is_far_from_saying_two_findings_is_not_asked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """As long as all are there that it was asked beside."""
    bare = demo_problem()
    oil, dry = (guess(bare, suspect_of(bare, e, "elbow")) for e in ("viscous_friction", "coulomb_friction"))
    problem = planted(oil.at({"coefficient": 0.8}), dry.at({"torque": 0.6}))
    asked, fit = list[int](), Criterion.fit

    def counted(self: Criterion, *args: Any) -> Scored | None:
        asked.append(len(args))
        return fit(self, *args)

    monkeypatch.setattr(Criterion, "fit", counted)
    with Simulations(problem, 2) as simulations:
        found = _found(simulations, [oil, dry], oil.suspect, 0.5 * MUCH * LIMIT)
        asked.clear()
        once = joined(simulations, found, suspects(problem), [])
        first = len(asked)
        again = joined(simulations, once, suspects(problem), [])
    assert first > 0
    assert len(asked) == first
    assert [c.suspect for c in again.best.fit.changes] == [oil.suspect, dry.suspect]
    assert once.apart.said
    assert once.apart.among({oil.suspect, dry.suspect}) == once.apart.said
    assert not once.apart.among({dry.suspect})


@pytest.mark.parametrize("other", [0.6, 0.9])
def test_one_value_for_all_joints_takes_the_place_of_one_at_each(other: float) -> None:
    """Where that says as much: a search that was cut off has not come to ask."""
    bare = demo_problem()
    everywhere, shoulder, elbow = (
        guess(bare, suspect_of(bare, "coulomb_friction", at)) for at in ("*", "shoulder", "elbow")
    )
    begun = [shoulder.at({"torque": 0.6}), elbow.at({"torque": other})]
    problem = planted(*begun)
    with Simulations(problem, 2) as simulations:
        found = _found(simulations, begun, elbow.suspect, 2.0 * MUCH * LIMIT)
        told = joined(simulations, found, suspects(problem), [])
        kept = joined(simulations, found, suspects(problem), [elbow.suspect])
    assert [c.suspect for c in kept.best.fit.changes] == [c.suspect for c in begun]
    if other != 0.6:
        assert [c.suspect for c in told.best.fit.changes] == [c.suspect for c in begun]
        return
    (change,) = told.best.fit.changes
    assert change.suspect == everywhere.suspect
    assert change.parameters["torque"] == pytest.approx(0.6, rel=0.03)
