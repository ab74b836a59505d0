"""What stands in a file is told in the words of a person who writes one, and not in Python's."""

from pathlib import Path

import pytest
from realitygap.files.errors import InputError
from realitygap.files.found import shown
from realitygap.files.validation import validate
from realitygap.files.yaml_file import load_yaml
from realitygap.scenario.schema import Scenario


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (None, "nothing"),
        (True, "true"),
        ("a", "'a'"),
        (-2.5, "-2.5"),
        ([None, {"a": [False]}], "[nothing, {a: [false]}]"),
        (["x" * 100], "['" + "x" * 75 + "..."),
    ],
)
def test_a_value_is_shown_as_it_is_written(value: object, told: str) -> None:
    assert shown(value) == told


@pytest.mark.parametrize(
    ("text", "said"),
    [("", "nothing"), ("hello", "text"), ("[1]", "a list"), ("3", "a number"), ("true", "true or false")],
)
def test_a_file_that_holds_something_else(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "x.yaml").write_text(text)
    with pytest.raises(InputError, match=f"holds {said}, expected a mapping of keys"):
        load_yaml(tmp_path / "x.yaml")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"name": None}, "name: found nothing; expected text"),
        ({"robot": None}, "robot: found nothing; expected a mapping (the robot"),
        ({"servos": [{"joints": [], "kind": "pid", "kp": 1}]}, "joints: found []; expected at least 1 item ("),
        ({"servos": [{"joints": "*", "kind": "pid", "kp": True}]}, "kp: found true; expected a number"),
        ({"recordings": {"runs": [{"path": "a", "window": 3}]}}, "window: found 3; expected a list"),
    ],
)
def test_no_word_of_python_stands_in_a_sentence(changes: dict[str, object], said: str) -> None:
    raw: dict[str, object] = {"name": "x", "robot": {"urdf": "x.urdf"}, **changes}
    with pytest.raises(InputError) as raised:
        validate(Path("x.yaml"), Scenario, raw)
    assert said in str(raised.value)
