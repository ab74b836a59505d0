"""Commands whose messages name no joints, and whose values are not as many as the joints that were measured."""

from collections.abc import Callable
from pathlib import Path

import pytest
from first_scenario import arm, messages
from realitygap.init.draft import init

ARRAY = "std_msgs/msg/Float64MultiArray"
NAMED_SO = "a topic of commands is told by its name"


def told(topic: str, count: int, folder: Path, write_bag: Callable[..., Path], late: float = 0.0) -> list[str]:
    states = [m for m in messages() if m[0] == "/joint_states"]
    sent = [(topic, stamp + late, ARRAY, {"data": [0.1] * count}) for _, stamp, _, _ in states]
    bag = write_bag(folder / "run", "mcap", sorted([*states, *sent], key=lambda m: m[1]))
    return init(arm(folder / "arm.urdf"), [bag], folder / "out").told


@pytest.mark.parametrize(
    ("topic", "count", "values", "taken"),
    [
        ("/cmd", 3, "3 values", "recorded: /cmd, joints: [shoulder, elbow, NAME]"),
        ("/effort_cmd", 1, "1 value", "recorded: /effort_cmd, as: effort, joints: [shoulder]"),
        (
            "/velocity_cmd",
            4,
            "4 values",
            "recorded: /velocity_cmd, as: velocity, joints: [shoulder, elbow, NAME, NAME]",
        ),
    ],
)
def test_their_number_is_told_and_how_they_are_taken(
    topic: str, count: int, values: str, taken: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    said = told(topic, count, tmp_path, write_bag)
    assert (
        f"{topic} says by its name that it holds commands, but it holds {values} that name no joints, for 2 that were "
        f"measured; `motion: {{{taken}}}` takes it, where joints has a name for every value, in their order"
    ) in said
    assert any(line.startswith("no fitting topic of commands was found") for line in said)
    assert not any(line.startswith(NAMED_SO) for line in said)


def test_those_of_another_time_are_told_as_such(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    said = told("/cmd", 2, tmp_path, write_bag, late=100.0)
    why = "it has no values from the time in which the joints were measured"
    assert f"/cmd says by its name that it holds commands, but {why}" in said


def test_without_any_it_is_said_how_a_topic_tells_that_it_holds_some(
    tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    said = told("/spare", 3, tmp_path, write_bag)
    assert any(line.startswith(NAMED_SO) for line in said)
    assert any(line.startswith("no topic of commands was found") for line in said)
