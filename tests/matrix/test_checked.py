"""A value of an axis that makes a mistake is told before anything is simulated, with the axis."""

from pathlib import Path

import pytest
from realitygap.files.errors import InputError
from realitygap.matrix.checked import checked
from realitygap.matrix.matrix_file import load_matrix

SCENARIOS = Path(__file__).parents[2] / "scenarios"


def told(folder: Path, text: str, scenario: str = "demo/scenario.yaml") -> list[str]:
    path = folder / "matrix.yaml"
    path.write_text(f"name: test\nscenarios: {SCENARIOS / scenario}\n{text}\n")
    return checked(load_matrix(path))


def test_a_sweep_of_what_a_servo_may_be_is_no_mistake(tmp_path: Path) -> None:
    axes = "{servos.drive.gain: [2.5, 5, 10], step_rate: [500, 1000], servos.drive.friction.coulomb: [0, 0.2]}"
    assert told(tmp_path, f"engines: mujoco\naxes: {axes}") == []


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("engines: mujco", "matrix.yaml: engines: found mujco; expected one of"),
        (
            "axes: {'servos.drive.joints': ['*', 'elbw*']}",
            r"matrix.yaml: axes.servos.drive.joints: elbw\*: .*matches no joint",
        ),
        ("axes: {servos.drive.joints: ['elbw*']}", r"axes.servos.drive.joints: elbw\*: .*matches no joint"),
        ("axes: {servos.drive.supply: [12, 12000]}", r"axes.servos.drive.supply\[1\]: found 12000; .*\[V\]"),
        ("axes: {step_rate: [0.001]}", r"axes.step_rate\[0\]: found 0.001; expected greater than"),
        ("axes: {servos.drive.friction.culomb: [0.1]}", "culomb: unknown key; .* did you mean coulomb"),
        (
            "axes: {recordings.effort: [motor, {topic: /joint_states, measures: motor, factor: 1000.0}]}",
            "axes.recordings.effort: .*effort",
        ),
    ],
)
def test_a_mistake_is_one_sentence_with_its_axis(text: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=sentence) as error:
        told(tmp_path, text)
    assert "matrix.yaml" in str(error.value)
    assert "\n" not in str(error.value)


def test_time_is_no_axis_of_a_motion_that_is_followed(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"axes.step_rate: changes nothing in .*, whose motion is followed"):
        told(tmp_path, "axes: {step_rate: [500, 1000]}", "effort_driven/followed.yaml")
