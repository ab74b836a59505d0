"""Messages that are decoded many at a time are what they are one by one, whatever changes between them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bags import FILE, STATE, scenario
from realitygap.files.errors import InputError
from realitygap.recording import read_recording
from realitygap.recording.readers import alike

Message = tuple[str, float, str, dict[str, Any]]


def messages(changing: bool) -> list[Message]:
    """States and commands; where they change, in the order and the number of their names, and in their size."""
    random, out = np.random.default_rng(3), []
    for k in range(300):
        t = 1.7e9 + 0.01 * k
        names = ["b", "a"] if not changing or k % 7 else ["a", "b"]
        state = {"stamp": t, "name": names, "position": random.normal(size=2), "velocity": random.normal(size=2)}
        if changing and 100 <= k < 140:
            state["name"], state["position"] = [*names, "other"], random.normal(size=3)
            state["velocity"] = random.normal(size=3)
        if changing and k % 50 == 0:
            out.append(("/joint_states", t + 0.001, STATE, {"stamp": t, "name": ["x"], "position": [9.0]}))
        out.append(("/joint_states", t + 0.002, STATE, state))
        told = ["a"] if changing and k % 3 == 0 else ["a", "b"]
        command = {"stamp": t, "name": told, "position": random.normal(size=len(told))}
        out.append(("/joint_commands", t + 0.003, STATE, command))
    return out


@pytest.mark.parametrize("changing", [False, True])
@pytest.mark.parametrize("form", ["bag", "mcap", "db3"])
def test_together_as_one_by_one(
    form: str, changing: bool, tmp_path: Path, write_bag: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_bag(tmp_path / "run.bag" if form == "bag" else tmp_path / "run", form, messages(changing))
    monkeypatch.setattr(alike, "AT_ONCE", 16)
    together = read_recording(path, scenario(), ["a", "b"], file=FILE)
    monkeypatch.setattr(alike, "learnt", lambda *_: None)
    alone = read_recording(path, scenario(), ["a", "b"], file=FILE)
    assert together.notes == alone.notes
    for ours, theirs in ((together, alone), (together.trace, alone.trace)):
        for name, value in vars(theirs).items():
            if isinstance(value, np.ndarray):
                np.testing.assert_array_equal(getattr(ours, name), value, err_msg=name)
    assert together.trace.position is not None
    assert together.trace.position.shape == (300, 2)


def test_numbers_are_learnt_from_one_message(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    path = write_bag(tmp_path / "run", "mcap", messages(changing=False))
    decoded = []
    real = alike.Pattern.values

    def counted(self: alike.Pattern, rows: Any) -> Any:
        decoded.append(len(rows))
        return real(self, rows)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(alike.Pattern, "values", counted)
        read_recording(path, scenario(), ["a", "b"], file=FILE)
    assert sum(decoded) == 2 * 299


def test_a_message_among_many_that_is_no_good_is_named(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    wrong = messages(changing=False)
    wrong[400][3]["name"] = ["b", "b"]  # the 201st state, as long as the others
    path = write_bag(tmp_path / "run", "mcap", wrong)
    with pytest.raises(InputError, match=r"/joint_states: message 201: names joint b twice: b, b"):
        read_recording(path, scenario(), ["a", "b"], file=FILE)
