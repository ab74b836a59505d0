"""The steps of a diagnosis of the bundled demo (synthetic): each model has the values that it has by itself."""

from dataclasses import replace

import pytest
from demo_problem import FRICTION, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.judge.gaps import shown
from realitygap.diagnose.judge.steps import in_steps, steps
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.found import Found


@pytest.fixture(scope="module")
def found(problem: Problem, simulations: Simulations) -> Found:
    """Half of the missing friction, as if what else was found did the other half."""
    friction = Change(
        suspect_of(problem, "coulomb_friction", "elbow"),
        (("torque", FRICTION), ("onset", 0.0), ("presliding", 0.0)),
        ("torque",),
    )
    offset = guess(problem, suspect_of(problem, "joint_offset", "elbow"))
    criterion = Criterion(simulations, [friction])
    fitted = criterion.fit([friction, offset])
    assert fitted is not None
    half, rest = fitted.fit.changes[0].at({"torque": 0.5 * FRICTION}), fitted.fit.changes[1]
    left = residual(simulations, [half, rest], criterion.train)
    assert left is not None
    best = criterion.score(replace(fitted.fit, changes=(half, rest), residual=left))
    return Found(best, best, best, 6.0, {}, criterion.floors, criterion)


def test_a_step_has_the_values_that_it_has_without_what_comes_after_it(simulations: Simulations, found: Found) -> None:
    half, offset = found.best.fit.changes
    none, first, both = steps(found, [half.suspect, offset.suspect])
    assert none == ()
    assert both == (half, offset)
    assert [c.suspect for c in first] == [half.suspect]
    assert first[0].parameters["torque"] == pytest.approx(FRICTION, rel=0.1)
    of_friction = shown(simulations, found.floors, (none, first, both), ["mujoco"])[half.suspect]
    as_it_stands = shown(simulations, found.floors, (none, (half,), both), ["mujoco"])[half.suspect]
    assert of_friction.before == as_it_stands.before
    assert of_friction.after < 0.8 * as_it_stands.after


def test_steps_are_in_the_order_that_is_asked_for(found: Found) -> None:
    half, offset = found.best.fit.changes
    models = steps(found, [offset.suspect, half.suspect])
    assert [[c.suspect for c in m] for m in models] == [[], [offset.suspect], [offset.suspect, half.suspect]]


def test_many_findings_are_steps_by_effect(problem: Problem) -> None:
    both = [suspect_of(problem, effect, "elbow") for effect in ("coulomb_friction", "joint_offset")]
    assert in_steps(both) == [both[:1], both[1:]]
    alike = [replace(both[0], target=f"joint_{k}") for k in range(4)]
    assert in_steps([alike[0], both[1], *alike[1:]]) == [alike, both[1:]]
