"""What the other commands ask of the checks: an error, warnings, what is accepted, where physics is not to blame."""

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import lerobot_sets
import numpy as np
import pandas as pd
import pytest
import yaml
from realitygap.check import Mistake, accepted, blamed_joints, certain, check
from realitygap.check.mistake import merged
from realitygap.check.observed import observe
from realitygap.cli.main import main
from realitygap.files.errors import InputError
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from spoil import scaled, start_elsewhere
from teams import DEMO, Table, Team, demo


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


@pytest.mark.parametrize("off", [True, False])
def test_a_joint_whose_servo_is_off_may_stand_still(off: bool, team: Team, tmp_path: Path) -> None:
    """Its command is none then; one that is told to move by half a radian and stands still is not read at all."""
    still = team.copy()
    still.scenario["recordings"]["effort"] = "none"
    for table in still.tables.values():
        table.position[:, 1], table.velocity[:, 1] = table.position[0, 1], 0.0
        if off:
            table.command[:, 1] = np.nan
    found = [(m.kind, m.certainty, m.joints) for m in check(load_scenario(still.write(tmp_path)))]
    assert found == [("undriven_joint" if off else "stuck_position", "likely", ("elbow",))]


@pytest.mark.parametrize("told", [True, False])
def test_steps_between_slow_samples_are_no_lost_readings(told: bool, team: Team, tmp_path: Path) -> None:
    """A servo may be told to step and stand exactly in between; one that is told none of it lost its readings."""
    slow = team.copy()
    for name in slow.tables:
        time = np.arange(0.0, 6.0, 0.1)
        step = 0.6 * (time % 3.0 > 1.5)[:, None] * np.array([1.0, 1.0])
        command = step if told else 0.1 * np.sin(time)[:, None] * np.array([1.0, 1.0])
        position = np.vstack([step[:1], step[:-1]]) if told else np.where(step > 0, 0.6, command)
        slow.tables[name] = Table(time, command, position, np.full_like(position, np.nan), None)
    slow.scenario["recordings"]["effort"] = "none"
    found = {m.kind for m in check(load_scenario(slow.write(tmp_path)))}
    assert ("stuck_position" in found) is not told


def test_a_weak_servo_that_sags_by_less_than_a_radian_has_no_other_zero(team: Team, tmp_path: Path) -> None:
    for sag, kinds in ((0.5, set[str]()), (1.0, {"far_zero"})):
        low = team.copy()
        low.scenario["recordings"]["effort"] = "none"
        for table in low.tables.values():
            table.position[:, 0] -= sag
        assert {m.kind for m in check(load_scenario(low.write(tmp_path / f"{sag}")))} == kinds


EFFORTS = DEMO.parents[1] / "effort_driven" / "scenario.yaml"


@pytest.mark.parametrize(
    ("times", "kind", "said"),
    [
        (1.0, None, ""),
        (3.0, None, ""),  # a gear that takes, a torque constant that is only known so well
        (1000.0, "milliamperes", "a thousand times too large, as of mN·m or of a current in mA"),
        (1e-3, "milliamperes", "the measured effort of elbow is "),
        (1 / 0.0980665, "effort_size", "the commanded effort of elbow is 10."),
        (-1.0, "flipped_sign", "the measured effort of elbow goes against the commanded one: -1.00 times it"),
    ],
)
def test_commanded_efforts_are_those_that_were_measured(
    times: float, kind: str | None, said: str, tmp_path: Path
) -> None:
    for path in EFFORTS.parent.glob("*.csv"):
        table = pd.read_csv(path)
        table["command_elbow"] *= times
        table.to_csv(tmp_path / path.name, index=False)
    for path in (EFFORTS, EFFORTS.with_name("pendulum.urdf")):
        (tmp_path / path.name).write_text(path.read_text())
    found = check(load_scenario(tmp_path / EFFORTS.name))
    assert [(m.kind, m.certainty, m.joints) for m in found] == ([(kind, "certain", ("elbow",))] if kind else [])
    assert all(said in m.text for m in found)


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


def test_readings_that_are_absent_are_told_and_no_mistake(
    team: Team, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lossy = team.copy()
    lossy.tables["chirp_1"].position[100:141, 1] = np.nan
    with pytest.raises(SystemExit) as ended:
        main(["check", str(lossy.write(tmp_path))])
    assert not ended.value.code
    note, last = capsys.readouterr().out.splitlines()
    assert note.startswith("note: chirp_1: 41 of ")
    assert note.endswith(" samples are left out, as they are without the position of elbow (41)")
    assert last == "no mistake found"


def test_samples_that_are_not_there_or_are_dropped_are_told_and_no_mistake(
    team: Team, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lossy = team.copy()
    first, second = list(lossy.tables.values())[:2]
    pause = (first.time > 2.0) & (first.time < 4.0)
    for signal in ("time", "command", "position", "velocity", "effort"):
        setattr(first, signal, getattr(first, signal)[~pause])
    second.time[1::2] = second.time[:-1:2]
    with pytest.raises(SystemExit) as ended:
        main(["check", str(lossy.write(tmp_path))])
    assert not ended.value.code
    names = list(lossy.tables)
    hole, repeated, last = capsys.readouterr().out.splitlines()
    assert hole.startswith(f"note: {names[0]}: no samples from {first.time[first.time <= 2.0][-1]:.3f} to 4.0")
    rows = len(second.time)
    assert repeated == f"note: {names[1]}: {rows // 2} rows repeat the time of another and were dropped, of {rows}"
    assert last == "no mistake found"


def as_data_set(file: Path) -> Path:
    """A scenario of tables with their columns in a LeRobot data set instead; velocities, positions and commands."""
    folder, data = file.parent / "set", yaml.safe_load(file.read_text())
    features, rows = {}, []
    names = ("observation.state", "position"), ("observation.velocity", "velocity"), ("action", "command")
    for k, run in enumerate(data["recordings"]["runs"]):
        frame = pd.read_csv(file.parent / run["path"])
        out = {"episode_index": k, "timestamp": frame["time"]}
        for feature, signal in names:
            columns = [c for c in frame.columns if c.startswith(f"{signal}_")]
            out[feature] = list(np.degrees(frame[columns].to_numpy()))
            labels = [c.removeprefix(f"{signal}_") for c in columns]
            features[feature] = {"dtype": "float32", "shape": [len(columns)], "names": labels}
        lerobot_sets.table(pd.DataFrame(out), folder / f"data/chunk-000/episode_{k:06d}.parquet")
        rows.append({"episode_index": k, "tasks": [], "length": len(frame)})
        run.update(path="set", episode=k)
    layout = {"codebase_version": "v2.1", "fps": 100, "data_path": lerobot_sets.LAYOUTS["v2.1"], "features": features}
    lerobot_sets.write(folder / "meta/info.json", json.dumps(layout))
    lerobot_sets.write(folder / "meta/episodes.jsonl", "\n".join(map(json.dumps, rows)))
    data["recordings"] |= {"effort": "none"}
    data["motion"] = {"recorded": "action"}
    file.write_text(yaml.safe_dump(data))
    return file


@pytest.mark.parametrize("kind", ["table", "data set"])
@pytest.mark.parametrize(
    ("factor", "said"),
    [
        (0.0, "expected its derivative, or none: `velocity: none` under recordings.columns leaves it out"),
        (180 / np.pi, {"table": "expected rad/s, or `units: {velocity: deg}` under recordings.columns",
                       "data set": "expected rad/s where positions are in recordings.dataset.units: `velocity: none` "
                                   "under recordings.columns leaves it out"}),
    ],
)  # fmt: skip
def test_a_velocity_that_is_none_or_in_another_unit_is_told_with_the_key_that_mends_it(
    factor: float, said: str | dict[str, str], kind: str, team: Team, tmp_path: Path
) -> None:
    wrong = team.copy()
    for table in wrong.tables.values():
        assert table.velocity is not None
        table.velocity[:, 1] *= factor
    path = wrong.write(tmp_path)
    file = load_scenario(as_data_set(path) if kind == "data set" else path)
    (found,) = check(file)
    assert (found.joints, found.certainty, found.key) == (("elbow",), "certain", "recordings.columns.velocity")
    assert found.sentence.endswith(said if isinstance(said, str) else said[kind])
    assert check(file.override({"recordings.columns.velocity": "none"})) == []
    if factor and kind == "table":
        units = {"*": "rad", "elbow": "deg"}
        assert check(file.override({"recordings.columns.units": {"velocity": dict(reversed(units.items()))}})) == []


def test_a_velocity_that_fits_counts_is_not_certainly_in_thousandths(team: Team, tmp_path: Path) -> None:
    wrong = team.copy()
    scaled("velocity", 2 * np.pi / 4096)(wrong, 1)
    (found,) = check(load_scenario(wrong.write(tmp_path)))
    assert (found.kind, found.certainty, found.joints) == ("velocity", "likely", ("elbow",))


@pytest.mark.parametrize("signal", ["position", "command"])
def test_degrees_of_one_column_are_told_with_the_unit_that_mends_them(signal: str, team: Team, tmp_path: Path) -> None:
    spoilt = team.copy()
    scaled(signal, 180 / np.pi)(spoilt, 1)
    file = load_scenario(spoilt.write(tmp_path))
    (found,) = check(file)
    assert found.sentence.endswith(f"expected both in rad, or `units: {{{signal}: deg}}` under recordings.columns")
    assert check(file.override({f"recordings.columns.units.{signal}": {"elbow": "deg", "*": "rad"}})) == []


@pytest.mark.parametrize(("count", "start", "period"), [(281, 2.5, 0.01), (400, 0.0, 0.005), (200, 0.0, 0.00501)])
def test_the_even_clock_ends_within_the_recording(
    count: int, start: float, period: float, team: Team, tmp_path: Path
) -> None:
    """However its stamps are rounded: beyond its last reading nothing is known, and accelerations are of all."""
    seen = observe(load_scenario(team.write(tmp_path)))[0]
    trace = replace(seen.recording.trace.rows(np.arange(count)), time=np.round(start + period * np.arange(count), 9))
    shifted = replace(seen, recording=replace(seen.recording, trace=trace))
    assert np.isfinite(shifted.position).all()
    assert np.isfinite(shifted.acceleration).all()
