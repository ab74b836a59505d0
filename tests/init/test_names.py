"""The words of names, as people write them."""

import pytest
from realitygap.init.names import role_of, words


@pytest.mark.parametrize(
    ("label", "expected"),
    [
        ("shoulderPan_pos1", ("shoulder", "pan", "pos", "1")),
        ("current1_mA", ("current", "1", "ma")),
        ("mA/elbow", ("ma", "elbow")),
        ("gammaAngle", ("gamma", "angle")),
        ("mAngle", ("m", "angle")),
        ("TCP_speed", ("tcp", "speed")),
        ("tau_Nm", ("tau", "nm")),
    ],
)
def test_a_label_is_taken_to_its_words(label: str, expected: tuple[str, ...]) -> None:
    assert words(label) == expected


def test_a_current_in_milliamperes_is_a_current() -> None:
    assert role_of(words("present_current_mA")) == ("current", False, True)
