"""How carefully a model without one of its findings is fitted, by what else is there."""

from types import SimpleNamespace
from typing import cast

import pytest
from demo_problem import suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.fit.fit import CHEAP
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.round import Round
from realitygap.diagnose.search.without import without

LIMIT = 6.0
FAR, NEAR = 500.0, -7.0
"""What a quick fit without a finding loses, and one that goes all the way: the others make up for it."""


def model(lost: float, *changes: Change) -> Scored:
    """A fitted model that loses so much evidence."""
    return cast("Scored", SimpleNamespace(evidence=-lost, fit=SimpleNamespace(changes=changes)))


def lost(problem: Problem, gone: str, *others: tuple[str, str]) -> float:
    """What is lost without a finding at the elbow, beside others, of which fits tell `FAR` and `NEAR`."""
    finding = guess(problem, suspect_of(problem, gone, "elbow"))
    rest = [guess(problem, suspect_of(problem, effect, joint)) for effect, joint in others]
    criterion = SimpleNamespace(refined=lambda quick: model(NEAR, *quick.fit.changes))
    criterion.fit = lambda changes, **_: model(NEAR, *changes)
    round_ = SimpleNamespace(
        limit=LIMIT,
        criterion=criterion,
        simulations=SimpleNamespace(problem=problem),
        adjusted=lambda changes, *_: model(FAR, *changes),
        earned=lambda fuller, plain, limit: fuller.evidence - plain.evidence >= limit,
    )
    left = without(cast("Round", round_), model(0.0, *rest, finding), finding.suspect)
    assert left is not None
    assert [c.suspect for c in left.fit.changes] == [c.suspect for c in rest]
    return -left.evidence


@pytest.mark.parametrize(
    ("others", "told"),
    [
        ((), FAR),
        ((("viscous_friction", "shoulder"),), FAR),
        ((("controller_gain", "elbow"), ("viscous_friction", "elbow")), NEAR),
        ((("supply_voltage", "*"),), NEAR),
    ],
)
def test_what_others_at_its_joint_may_make_up_for_is_fitted_with_care(
    problem: Problem, others: tuple[tuple[str, str], ...], told: float
) -> None:
    """Of an elbow that lacked neither another gain, 2.1 times as high, another torque constant, 0.48 times as high, and
    viscous friction were as good as none of the three, and two steps without one of them lost 350 to 3100."""
    assert lost(problem, "torque_constant", *others) == told


def test_with_many_values_a_quick_fit_has_to_do(problem: Problem) -> None:
    many = [(effect, "elbow") for effect in ("controller_gain", "viscous_friction", "coulomb_friction", "dead_band")]
    many += [(effect, "shoulder") for effect, _ in many]
    assert len(many) >= CHEAP
    assert lost(problem, "torque_constant", *many) == FAR
