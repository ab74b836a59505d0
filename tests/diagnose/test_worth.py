"""What a finding must remove to be named, in mean squared residuals: 1 is the floor."""

import math

import pytest
from realitygap.diagnose.data.problem import Change, Suspect
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.search.worth import absurd, explains, large, lowered, removed, stands


def fit_of(*costs: float) -> Fit:
    return Fit([], dict(enumerate(costs)))


def beside(was: float, left: float, *, base: float = 150.0, repeated: bool) -> bool:
    """Whether a finding stands that lowers what all others leave from `was` to `left`, in one run."""
    return stands(base, fit_of(was), fit_of(left), [0], left=left, repeated=repeated)


@pytest.mark.parametrize("repeated", [True, False])
@pytest.mark.parametrize("was", [1.5, 3.0, 20.0, 1000.0])
def test_a_finding_that_leaves_the_floor_is_worth_a_name(was: float, repeated: bool) -> None:
    assert beside(was, 1.0, base=2 * was, repeated=repeated)


@pytest.mark.parametrize("repeated", [True, False])
@pytest.mark.parametrize(("was", "left"), [(1.1, 1.0), (0.9, 0.85), (3.0, 2.5)])
def test_one_that_mends_a_little_near_the_floor_is_not(was: float, left: float, repeated: bool) -> None:
    assert not beside(was, left, repeated=repeated)


def test_far_from_the_floor_a_part_of_a_large_gap_is_worth_a_name_where_the_floor_is_known() -> None:
    assert beside(100.0, 90.0, repeated=True)
    assert not beside(100.0, 90.0, repeated=False)
    assert not large(1000.0, fit_of(100.0), fit_of(90.0), [0]), "a fragment"


def test_findings_that_leave_most_of_a_gap_are_none() -> None:
    def all_together(was: float, left: float, *, repeated: bool) -> bool:
        return explains(fit_of(was), fit_of(left), [0], left=left, repeated=repeated)

    assert all_together(100.0, 45.0, repeated=True)
    assert not all_together(100.0, 45.0, repeated=False)
    assert not all_together(100.0, 55.0, repeated=True)
    assert all_together(1.5, 1.3, repeated=False), "what leaves the floor needs no share"


def test_very_far_from_the_floor_the_typical_run_decides_on_all_findings() -> None:
    """One run in which the robot falls, or a cube rolls on, would outweigh all others."""
    before, after = fit_of(400.0, 400.0, 90000.0), fit_of(100.0, 100.0, 120000.0)
    assert explains(before, after, [0, 1, 2], left=40000.0, repeated=False)
    assert not explains(after, before, [0, 1, 2], left=40000.0, repeated=False)


def test_very_far_from_the_floor_the_typical_run_decides_on_one_finding() -> None:
    far, near = ([300.0, 300.0, 330.0], [270.0, 270.0, 390.0]), ([30.0, 30.0, 33.0], [27.0, 27.0, 39.0])
    assert lowered(fit_of(*far[0]), fit_of(*far[1]), [0, 1, 2]) == pytest.approx(-math.log(0.9))
    assert lowered(fit_of(*near[0]), fit_of(*near[1]), [0, 1, 2]) == pytest.approx(0.0)


def test_the_share_is_of_what_stands_above_the_floor() -> None:
    assert removed(fit_of(11.0), fit_of(6.0), [0]) == pytest.approx(0.5)


def change(effect: str, target: str, **values: float) -> Change:
    return Change(Suspect(effect, target, (0,)), tuple(values.items()), tuple(values))


@pytest.mark.parametrize(("roll", "pitch"), [(0.0, 0.1), (-0.25, 0.0), (math.pi, 0.05), (math.pi / 2 - 0.1, -0.2)])
def test_a_base_may_be_mounted_at_quarter_turns_and_lean_a_little(roll: float, pitch: float) -> None:
    assert absurd(change("base_tilt", "base", roll=roll, pitch=pitch)) is None


def test_a_base_that_leans_far_would_be_seen() -> None:
    reason = absurd(change("base_tilt", "base", roll=-0.434, pitch=0.02))
    assert reason is not None
    assert "25°" in reason


def test_stribeck_friction_falls_with_speed() -> None:
    shape = {"velocity": 0.2, "exponent": 2.0}
    assert absurd(change("stribeck_friction", "elbow", static=0.5, coulomb=0.2, **shape)) is None
    assert absurd(change("stribeck_friction", "elbow", static=0.2, coulomb=0.5, **shape)) is not None
