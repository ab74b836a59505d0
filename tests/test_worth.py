"""What a finding must remove to be named, in mean squared residuals: 1 is the floor."""

import pytest

from harness.diagnose.worth import least_beside, share_of_all


@pytest.mark.parametrize("repeated", [True, False])
@pytest.mark.parametrize("was", [1.5, 3.0, 20.0, 1000.0])
def test_a_finding_that_leaves_the_floor_is_worth_a_name(was: float, repeated: bool) -> None:
    assert was - 1.0 > least_beside(2 * was, was, 1.0, repeated=repeated)


@pytest.mark.parametrize("repeated", [True, False])
@pytest.mark.parametrize(("was", "left"), [(1.1, 1.0), (0.9, 0.85), (3.0, 2.5)])
def test_one_that_mends_a_little_near_the_floor_is_not(was: float, left: float, repeated: bool) -> None:
    assert was - left < least_beside(100.0, was, left, repeated=repeated)


def test_far_from_the_floor_a_small_part_of_a_large_gap_is_worth_a_name_where_the_floor_is_known() -> None:
    was, left = 100.0, 90.0
    assert was - left > least_beside(150.0, was, left, repeated=True)
    assert was - left < least_beside(150.0, was, left, repeated=False)


def test_findings_that_leave_most_of_a_gap_are_none() -> None:
    assert share_of_all(50.0, 50.0, repeated=True) == 0.5 < share_of_all(50.0, 50.0, repeated=False)
    assert share_of_all(1.2, 1.3, repeated=False) == 0.0, "what leaves the floor needs no share"
