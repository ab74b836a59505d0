"""Sentences from planted tables: what they must say, and what they must not."""

from collections.abc import Sequence
from pathlib import Path

import pytest
import synthetic
from realitygap.compare.row import Cell
from realitygap.report.folder import read_folder
from realitygap.report.levels import pareto
from realitygap.report.sentences import NO_RESULT, Sentence, sentences

NONE = ()


def say(
    folder: Path, gaps: synthetic.Gaps, *, manifest: dict[str, object] | None = None, timings: str = "", **floors: float
) -> list[Sentence]:
    synthetic.write_planted(folder, synthetic.planted(gaps, **floors), manifest, timings)
    return sentences(read_folder(folder))


def about(said: list[Sentence], what: str) -> list[str]:
    return [s.text for s in said if s.about == what]


def engines(**gaps: float) -> synthetic.Gaps:
    return {(name, NONE, "position", "moving"): gap for name, gap in gaps.items()}


def test_closest_engine_is_named_with_its_gap_and_both_floors(tmp_path: Path) -> None:
    (text,) = about(say(tmp_path, engines(mujoco=0.52, pybullet=1.04), noise=0.04, numerical=0.02), "closest")
    assert text == (
        "MuJoCo comes closest in position of moving joints: 0.520° (noise floor 0.040°, numerical floor 0.020°); "
        "PyBullet is 2 times as far (1.04°)."
    )


@pytest.mark.parametrize(("noise", "numerical"), [(0.05, 0.0), (0.0, 0.05), (0.05, float("nan"))])
def test_engines_closer_than_the_larger_floor_are_no_different(tmp_path: Path, noise: float, numerical: float) -> None:
    (text,) = about(say(tmp_path, engines(mujoco=0.52, dart=0.56), noise=noise, numerical=numerical), "closest")
    assert text.startswith("In position of moving joints, no difference seen between MuJoCo, 0.520°")
    assert "comes closest" not in text


def test_engines_further_apart_than_the_floors_are_different(tmp_path: Path) -> None:
    (text,) = about(say(tmp_path, engines(mujoco=0.52, dart=0.56), noise=0.03, numerical=0.03), "closest")
    assert "no difference seen" not in text


def test_some_alike_and_some_apart(tmp_path: Path) -> None:
    (text,) = about(say(tmp_path, engines(mujoco=0.5, dart=0.505, drake=0.8)), "closest")
    assert "no difference seen to DART (0.505°)" in text
    assert "Drake is 1.6 times as far" in text


def test_a_gap_below_its_floors_is_no_difference_from_the_recording(tmp_path: Path) -> None:
    (text,) = about(say(tmp_path, engines(mujoco=0.03), noise=0.04), "gap")
    assert "no difference seen from the recording" in text


def test_unknown_floors_are_called_unknown(tmp_path: Path) -> None:
    (text,) = about(say(tmp_path, engines(mujoco=0.5, dart=0.6), numerical=float("nan")), "closest")
    assert "numerical floor unknown" in text


def test_a_failed_engine_is_told_in_words_and_does_not_win(tmp_path: Path) -> None:
    said = say(tmp_path, engines(mujoco=float("inf"), dart=0.5))
    assert about(said, "failed") == ["MuJoCo: its only cell diverged at 1.2 s at left_knee: not finite."]
    assert not about(said, "closest"), "one engine is left, and it is no choice"
    (text,) = about(said, "gap")
    assert text.startswith("DART")
    assert "MuJoCo" not in text


def test_no_result_at_all_is_told(tmp_path: Path) -> None:
    assert say(tmp_path, engines(mujoco=float("inf"), dart=float("inf")))[-1].text == NO_RESULT


def test_nor_traces_where_nothing_was_measured_and_all_failed(tmp_path: Path) -> None:
    """As of keyframes alone: a cell that failed has no rows without a measurement."""
    assert [s.text for s in say(tmp_path, {})] == [NO_RESULT]


def test_engines_are_compared_over_the_cells_in_which_all_of_them_ran(tmp_path: Path) -> None:
    a, b = (("recording", "a"),), (("recording", "b"),)
    gaps = {
        ("mujoco", a, "position", "moving"): 1.0,
        ("dart", a, "position", "moving"): 2.0,
        ("mujoco", b, "position", "moving"): 9.0,
        ("dart", b, "position", "moving"): float("inf"),
    }
    (text,) = about(say(tmp_path, gaps), "closest")
    assert text.startswith("MuJoCo comes closest in position of moving joints: 1.00°")


def revisions(old: Sequence[float], new: Sequence[float]) -> synthetic.Gaps:
    signals = ("position", "velocity", "effort")
    out: synthetic.Gaps = {}
    for revision, gaps in (("old", old), ("new", new)):
        for signal, gap in zip(signals, gaps, strict=True):
            out["mujoco", (("robot_revision", revision),), signal, "moving"] = gap
    return out


def test_a_change_that_helps_one_signal_and_harms_another_says_both(tmp_path: Path) -> None:
    # table 5.4 of the thesis, moving joints: the new revision against the old one
    (text,) = about(say(tmp_path, revisions((0.6062, 0.7271, 1.9947), (0.3138, 1.6838, 0.2798))), "change")
    assert text.startswith("On moving joints, revision new instead of old improves position by 0.292° (0.606 → 0.314°")
    assert "effort by 1.71 N·m" in text
    assert "but worsens velocity by 0.957 °/s (0.727 → 1.68 °/s" in text


def test_a_change_below_the_floors_is_none(tmp_path: Path) -> None:
    (text,) = about(say(tmp_path, revisions((0.60, 0.7, 2.0), (0.595, 0.695, 1.0))), "change")
    assert "improves effort by 1.00 N·m" in text
    assert "no difference seen in position and velocity" in text
    assert "worsens" not in text


def rates(*gaps: float) -> synthetic.Gaps:
    return {
        ("dart", (("step_rate", rate),), "position", "moving"): gap
        for rate, gap in zip((250.0, 500.0, 1000.0, 2000.0), gaps, strict=True)
    }


def test_the_step_rate_above_which_nothing_is_gained(tmp_path: Path) -> None:
    (text,) = about(say(tmp_path, rates(2.0, 1.0, 0.5, 0.5)), "enough")
    assert "at 500 Hz the gap (1.00°) is 2 times as large as at 2000 Hz (0.500°); from 1000 Hz (0.500°; noise" in text
    assert text.endswith(" on, no difference seen to 2000 Hz.")


@pytest.mark.parametrize(("low", "how"), [(2.67, "0.15° larger than"), (2.2, "0.32° smaller than"), (9.0, "3.6 times")])
def test_a_step_rate_is_told_against_the_one_that_it_differs_from(tmp_path: Path, low: float, how: str) -> None:
    """The highest, from which 2.61° is no difference and the lower rate's gap is one, though close to 2.61°."""
    (text,) = about(say(tmp_path, rates(9.0, low, 2.61, 2.52), noise=0.1, numerical=0.1), "enough")
    number = f"{low:.2f}"
    assert f"at 500 Hz the gap ({number}°) is {how}" in text
    assert "at 2000 Hz (2.52°); from 1000 Hz (2.61°" in text
    assert text.endswith("on, no difference seen to 2000 Hz.")


def test_a_step_rate_that_never_matters(tmp_path: Path) -> None:
    (text,) = about(say(tmp_path, rates(0.5, 0.501, 0.5, 0.502)), "enough")
    assert text.startswith("DART: no difference seen in position of moving joints from 250 Hz")


def test_a_gap_that_still_moves_at_the_highest_step_rate(tmp_path: Path) -> None:
    (text,) = about(say(tmp_path, rates(4.0, 3.0, 2.0, 1.0)), "enough")
    assert "highest tried" in text
    assert "nothing is gained" not in text


def test_the_fastest_choice_that_is_as_close_as_the_closest(tmp_path: Path) -> None:
    gaps = {(e, (("step_rate", r),), "position", "moving"): g for e, r, g in PLANTED_SPEEDS}
    frame = synthetic.planted(gaps)
    lines = [",".join([*Cell.__dataclass_fields__, "wall_seconds", "real_time_factor", "steps"])]
    for (engine, rate, _), factor in zip(PLANTED_SPEEDS, (30, 60, 5), strict=True):
        one = synthetic.cell(engine, step_rate=rate)
        values = ["" if v is None else f"{v:g}" if isinstance(v, float) else v for v in vars(one).values()]
        lines.append(",".join([*values, "1", str(factor), "1"]))
    synthetic.write_planted(tmp_path, frame, None, "\n".join(lines) + "\n")
    (text,) = about(sentences(read_folder(tmp_path)), "speed")
    assert text.startswith("MuJoCo at 1000 Hz (30.0 × real time) is the fastest with no difference seen")
    assert "Drake at 1000 Hz (5.00 × real time)" in text


def test_speed_is_all_that_was_simulated_over_all_the_time_it_took(tmp_path: Path) -> None:
    """A short cell that starts slowly counts as little as it lasts."""
    recordings = {"a": (0.1, 100.0), "b": (10.0, 1.0)}  # wall seconds, real-time factor: 20 s in 10.1 s
    gaps = {(e, (("recording", r),), "position", "moving"): 0.5 for e in ("mujoco", "dart") for r in recordings}
    lines = [",".join([*Cell.__dataclass_fields__, "wall_seconds", "real_time_factor", "steps"])]
    for engine, slower in (("mujoco", 1.0), ("dart", 2.0)):
        for recording, (wall, factor) in recordings.items():
            one = synthetic.cell(engine, recording=recording)
            values = ["" if v is None else f"{v:g}" if isinstance(v, float) else v for v in vars(one).values()]
            lines.append(",".join([*values, str(wall * slower), str(factor / slower), "1"]))
    synthetic.write_planted(tmp_path, synthetic.planted(gaps), None, "\n".join(lines) + "\n")
    (text,) = about(sentences(read_folder(tmp_path)), "speed")
    assert "MuJoCo at 1000 Hz (1.98 × real time)" in text


PLANTED_SPEEDS = [("mujoco", 1000.0, 0.505), ("mujoco", 500.0, 0.9), ("drake", 1000.0, 0.5)]


def test_virtual_recordings_conclude_nothing(tmp_path: Path) -> None:
    said = say(tmp_path, engines(mujoco=0.5), manifest={"virtual": True})
    assert "nothing is concluded about reality" in about(said, "virtual")[0]
    assert not about(say(tmp_path, engines(mujoco=0.5), manifest={"virtual": False}), "virtual")


def test_joint_that_no_engine_closes(tmp_path: Path) -> None:
    gaps = {(e, NONE, "position", g): v for e in ("mujoco", "dart") for g, v in (("moving", 3.0), ("unmoving", 0.2))}
    (text,) = about(say(tmp_path, gaps), "joint")
    assert text.startswith("moving_joint has the largest gap in position, 3.00° at least in every engine")


def test_pareto_front() -> None:
    assert pareto([1.0, 2.0, 3.0, 0.5], [10.0, 20.0, 5.0, 1.0]) == [True, True, False, True]
    assert pareto([float("inf"), 1.0], [100.0, 1.0]) == [False, True]


def test_a_small_lead_is_told_as_a_difference(tmp_path: Path) -> None:
    (text,) = about(say(tmp_path, engines(mujoco=1.74, ode=1.78)), "closest")
    assert text.endswith("ODE is 0.040° further (1.78°).")


def test_engines_that_need_the_same_rate_share_a_sentence(tmp_path: Path) -> None:
    gaps = rates(0.5, 0.501, 0.5, 0.502)
    gaps |= {("drake", *key[1:]): gap + 0.1 for key, gap in gaps.items()}
    (text,) = about(say(tmp_path, gaps), "enough")
    assert text.startswith(
        "DART and Drake: no difference seen in position of moving joints from 250 Hz (0.500 to 0.600°"
    )


@pytest.mark.parametrize(
    ("moving", "said"), [(0.4, []), (1.2, ["moving_joint has the largest gap in effort above its"])]
)
def test_a_joint_below_its_floors_is_not_the_worst(tmp_path: Path, moving: float, said: list[str]) -> None:
    gaps = {("mujoco", (), "effort", "moving"): moving, ("mujoco", (), "effort", "unmoving"): 2.0}
    frame = synthetic.planted(gaps, noise=0.5, numerical=0.5)
    frame.loc[frame["joint"] == "unmoving_joint", "numerical_floor"] = 3.0
    synthetic.write_planted(tmp_path, frame)
    found = about(sentences(read_folder(tmp_path)), "joint")
    assert [text[: len(said[0])] for text in found] == said


def test_the_worst_joint_is_told_by_every_signal(tmp_path: Path) -> None:
    """Each with its own joint and unit; a signal of a single joint has none."""
    gaps: synthetic.Gaps = {}
    for signal, moving, unmoving in (("position", 1.0, 2.0), ("velocity", 9.0, 3.0)):
        gaps |= {("mujoco", (), signal, "moving"): moving, ("mujoco", (), signal, "unmoving"): unmoving}
    gaps["mujoco", (), "effort", "moving"] = 1.0
    position, velocity = about(say(tmp_path, gaps), "joint")
    assert position.startswith("unmoving_joint has the largest gap in position: 2.00° in MuJoCo")
    assert velocity.startswith("moving_joint has the largest gap in velocity: 9.00 °/s in MuJoCo")
