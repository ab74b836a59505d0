"""What the other commands ask of the checks: an error, warnings, what is accepted, where physics is not to blame."""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from realitygap.check import Mistake, accepted, blamed_joints, certain, check
from realitygap.check.mistake import merged
from realitygap.cli.main import main
from realitygap.files.errors import InputError
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from spoil import scaled, start_elsewhere
from teams import Table, Team, demo


@pytest.fixture(scope="module")
def team() -> Team:
    return demo()


def flipped(team: Team, folder: Path) -> Path:
    spoilt = team.copy()
    scaled("position", -1.0)(spoilt, 1)
    return spoilt.write(folder)


def far(team: Team, folder: Path) -> Path:
    spoilt = team.copy()
    start_elsewhere(spoilt, 0)
    return spoilt.write(folder)


def test_a_certain_mistake_is_one_sentence(team: Team, tmp_path: Path) -> None:
    path = flipped(team, tmp_path)
    with pytest.raises(InputError) as raised:
        certain(load_scenario(path))
    said = str(raised.value)
    assert said.startswith(f"{path}: ")
    assert "elbow" in said
    assert "flipped" in said
    assert "\n" not in said


def test_a_likely_mistake_is_a_warning_that_stops_physics_at_its_joint(team: Team, tmp_path: Path) -> None:
    warnings = certain(load_scenario(far(team, tmp_path)))
    assert [(m.kind, m.certainty) for m in warnings] == [("far_start", "likely")]
    assert blamed_joints(warnings) == {"shoulder"}


@pytest.mark.parametrize("entry", ["far_start", "far_start@shoulder", "far_start@sh*"])
def test_what_is_accepted_is_no_mistake(team: Team, tmp_path: Path, entry: str) -> None:
    file = load_scenario(far(team, tmp_path)).override({"accept": [entry]})
    assert certain(file) == []
    (found,) = check(file)
    assert accepted(file, found)


def test_a_certain_mistake_can_be_accepted(team: Team, tmp_path: Path) -> None:
    file = load_scenario(flipped(team, tmp_path)).override({"accept": ["flipped_sign@elbow"]})
    assert certain(file) == []


def test_another_joint_is_not_accepted(team: Team, tmp_path: Path) -> None:
    file = load_scenario(far(team, tmp_path)).override({"accept": ["far_start@elbow"]})
    assert [m.kind for m in certain(file)] == ["far_start"]


@pytest.mark.parametrize(
    ("entry", "said"), [("far_strat", "did you mean far_start"), ("far_start@knee", "knee matches no joint")]
)
def test_an_unknown_word_in_accept_is_one_sentence(team: Team, tmp_path: Path, entry: str, said: str) -> None:
    file = load_scenario(far(team, tmp_path)).override({"accept": [entry]})
    with pytest.raises(InputError, match=f"accept\\[0\\].*{said}"):
        check(file)


@pytest.mark.parametrize(
    ("make", "status", "line"),
    [(flipped, 2, "certain: flipped_sign: "), (far, 0, "likely: far_start: "), (None, 0, "no mistake found")],
)
def test_the_command_lists_them_and_says_how_sure_it_is(
    team: Team,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    make: Callable[[Team, Path], Path] | None,
    status: int,
    line: str,
) -> None:
    path = make(team, tmp_path) if make else team.copy().write(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["check", str(path)])
    assert (ended.value.code or 0) == status
    assert capsys.readouterr().out.startswith(line)


@pytest.mark.parametrize("signals", [("position",), ("position", "velocity")], ids=" and ".join)
@pytest.mark.parametrize("rate", [50, 200, 1000])
def test_a_servo_that_is_off_for_a_while_hides_nothing(
    team: Team, tmp_path: Path, rate: int, signals: tuple[str, ...]
) -> None:
    """At the recorded rate, a quarter of it, and five times as often."""
    paused = team.copy()
    for name, table in paused.tables.items():
        time = np.arange(table.time[0], table.time[-1], 1 / rate)
        command, position, velocity = (
            resampled(time, table.time, value) for value in (table.command, table.position, table.velocity)
        )
        command[(time < 0.5) | ((time > 2.0) & (time < 2.5))] = np.nan
        paused.tables[name] = Table(time, command, position, velocity, None)
    paused.scenario["recordings"]["effort"] = "none"
    for signal in signals:
        scaled(signal, -1.0)(paused, 1)
    (found,) = check(load_scenario(paused.write(tmp_path)))
    assert (found.kind, found.joints) == ("flipped_sign", ("elbow",))


def resampled(time: np.ndarray, known: np.ndarray, value: np.ndarray) -> np.ndarray:
    return np.column_stack([np.interp(time, known, column) for column in value.T])


@pytest.mark.parametrize(("rest", "found"), [(0.0, []), (0.04, []), (1.0, ["far_start"])])
def test_a_recording_may_begin_with_a_step(team: Team, tmp_path: Path, rest: float, found: list[str]) -> None:
    """From rest and at once a servo goes to where it is told; one that waits was not told yet."""
    stepped = team.copy()
    for table in stepped.tables.values():
        late = np.maximum(table.time - table.time[0] - rest, 0.0) / 0.05
        table.position[:, 1] += 0.9 * (1.0 + late) * np.exp(-late)
        table.velocity[:, 1] -= 0.9 / 0.05 * late * np.exp(-late)
    stepped.scenario["recordings"]["effort"] = "none"
    assert [m.kind for m in check(load_scenario(stepped.write(tmp_path)))] == found


def test_run_stops_at_a_certain_mistake(team: Team, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = flipped(team, tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["run", str(path), "--engine", "mujoco", "--out", str(tmp_path / "out")])
    assert ended.value.code == 2
    assert "flipped" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_the_same_in_several_recordings_is_told_once() -> None:
    likely = Mistake("velocity", "likely", ("a",), "first", "recordings.state", ("one",))
    sure = Mistake("velocity", "certain", ("a",), "second", "recordings.state", ("two",))
    (one,) = merged([likely, sure])
    assert (one.certainty, one.runs) == ("certain", ("two", "one"))
    assert one.text == "recordings.state: second (and in 1 other recording)"


def test_a_velocity_that_was_never_measured_is_no_mistake(team: Team, tmp_path: Path) -> None:
    without = team.copy()
    for table in without.tables.values():
        assert table.velocity is not None
        table.velocity[:, 1] = np.nan
    assert check(load_scenario(without.write(tmp_path))) == []


def test_a_velocity_that_is_always_zero_is_told_with_how_to_leave_it_out(team: Team, tmp_path: Path) -> None:
    still = team.copy()
    for table in still.tables.values():
        assert table.velocity is not None
        table.velocity[:, 1] = 0.0
    (found,) = check(load_scenario(still.write(tmp_path)))
    assert (found.kind, found.certainty) == ("velocity", "certain")
    assert "remove recordings.columns.velocity, and rename a column that is called velocity" in found.sentence
