"""When another engine confirms a finding, in held-out gaps before and after: 1 is the floor."""

import pytest
from realitygap.diagnose.judge.confirm import Confirmed, agrees


@pytest.mark.parametrize("there", [(6.1, 1.4), (5.9, 1.6), (9.0, 1.2)])
def test_an_engine_in_which_a_finding_helps_as_much_agrees(there: tuple[float, float]) -> None:
    assert agrees(Confirmed(6.0, 1.4), there)


@pytest.mark.parametrize("there", [(1.574, 1.57), (1.393, 1.229), (1.2, 1.244)])
def test_one_in_which_it_helps_little_or_half_as_much_does_not(there: tuple[float, float]) -> None:
    """The gain is then part of what the searching engine itself does wrong."""
    assert not agrees(Confirmed(1.574, 1.244), there)
