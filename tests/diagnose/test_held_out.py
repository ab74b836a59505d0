"""Held-out runs of the bundled demo (synthetic) speak of every finding, after the model is chosen."""

from dataclasses import replace

import pytest
from demo_problem import FRICTION, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.responses import residual
from realitygap.diagnose.judge.held_out import predicted, supported
from realitygap.diagnose.likelihood.floors import measure
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.search import Found
from realitygap.diagnose.search.yardstick import Yardstick


@pytest.fixture(scope="module")
def found(problem: Problem, simulations: Simulations) -> Found:
    """The missing friction, and beside it an offset that the robot has not, as if training runs had shown it."""
    friction = Change(suspect_of(problem, "coulomb_friction", "elbow"), (("torque", FRICTION),), ("torque",))
    offset = guess(problem, suspect_of(problem, "joint_offset", "elbow")).at({"angle": 0.02})
    yardstick = Yardstick(simulations, [friction])

    def scored(*changes: Change) -> Scored:
        left = residual(simulations, changes, yardstick.train)
        assert left is not None
        return yardstick.score(Fit(changes, left))

    base, best = scored(), scored(friction, offset)
    without = {friction.suspect: scored(offset), offset.suspect: scored(friction)}
    floors = measure(simulations, best.fit.changes)
    gains = {s: best.evidence - other.evidence for s, other in without.items()}
    return Found(base, best, best, 6.0, 6.0, floors, yardstick, gains=gains, without=without)


def test_a_finding_that_held_out_runs_speak_against_is_dropped_and_no_other(
    problem: Problem, simulations: Simulations, found: Found
) -> None:
    left, against = supported(simulations, found, [])
    assert [s.effect for s in against] == ["joint_offset"]
    assert max(against.values()) < 0.0
    assert [c.suspect.effect for c in left.best.fit.changes] == ["coulomb_friction"]
    assert left.best.fit.value[0] == pytest.approx(FRICTION, rel=0.04)
    assert set(left.gains) == {suspect_of(problem, "coulomb_friction", "elbow")}
    assert left.gains[suspect_of(problem, "coulomb_friction", "elbow")] > 10.0
    assert predicted(simulations, left.floors, left.best.fit.changes).gain > 10.0


def test_what_the_recordings_told_stays(problem: Problem, simulations: Simulations, found: Found) -> None:
    offset = suspect_of(problem, "joint_offset", "elbow")
    left, against = supported(simulations, replace(found), [offset])
    assert not against
    assert left.best is found.best


def test_a_finding_needs_that_all_runs_together_say_enough_for_it(simulations: Simulations, found: Found) -> None:
    friction, offset = (c.suspect for c in found.best.fit.changes)
    together = (
        found.gains[friction]
        + predicted(simulations, found.floors, found.best.fit.changes, found.without[friction].fit.changes).gain
    )
    assert not supported(simulations, replace(found, least=together - 1.0), [offset])[1]
    assert list(supported(simulations, replace(found, least=together + 1.0), [offset])[1]) == [friction]


def test_what_held_out_runs_speak_for_beside_all_that_was_found_is_not_asked_again(
    simulations: Simulations, found: Found
) -> None:
    friction, offset = (c.suspect for c in found.best.fit.changes)
    poor = replace(found, gains={friction: 1e9, offset: found.gains[offset]}, least=1e6)
    left, against = supported(simulations, poor, [])
    assert list(against) == [offset]
    assert left.gains[friction] < poor.least
