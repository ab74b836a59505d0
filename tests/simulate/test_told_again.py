"""What servos are told is worked out once for models that tell them the same."""

import numpy as np
import pytest
from realitygap.robot.drive import Array, neutral_drive
from realitygap.simulate.commands import Commands, on_steps
from realitygap.simulate.profile import KEPT, Told, _Known

TIME = np.arange(0.0, 2.0, 0.02)


def commands(seed: int) -> Commands:
    """Two joints that go to and fro."""
    return Commands(TIME, np.random.default_rng(seed).uniform(-1.0, 1.0, (len(TIME), 2)))


def told(sent: Commands, delay: float = 0.0, acceleration: float = np.inf, first: int = 0) -> Array:
    """Over 500 steps."""
    drive = neutral_drive(2)
    drive["profile_acceleration"] = acceleration
    return Told(sent, drive, 1000, 2e-3, np.full(2, delay)).over(first, 500)


def test_the_same_is_told_again_and_anything_else_is_not() -> None:
    sent = commands(1)
    first = told(sent)
    assert told(sent) is first
    assert first == pytest.approx(on_steps(sent, 500, 2e-3, np.zeros(2)), abs=0.0)
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 1.0
    others = [told(sent, delay=0.004), told(sent, acceleration=30.0), told(sent, first=500), told(commands(2))]
    for k, other in enumerate([*others, first]):
        for further in [*others, first][k + 1 :]:
            assert not np.array_equal(other, further)


def test_only_what_was_told_last_stays_known() -> None:
    many = [commands(seed) for seed in range(2 * KEPT)]
    for sent in many:
        told(sent)
    assert len(_Known.told) <= KEPT
    assert any(kept is many[-1] for kept, _ in _Known.told.values())
    assert not any(kept is many[0] for kept, _ in _Known.told.values())
