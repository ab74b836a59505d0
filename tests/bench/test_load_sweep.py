"""The servo bench gives back what was planted: the thesis' tables 3.1 and 4.4 to 4.8."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from realitygap.bench import servo
from realitygap.bench.estimate import jackknife, mean
from realitygap.bench.load_sweep import drive_constants, lines, new_against_used
from realitygap.bench.torque_speed import fit_line
from realitygap.scenario.schema import Scenario
from realitygap.scenario.servos import DcServo
from thesis_servo import BENCH, TABLES, planted_sweep


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    out = tmp_path_factory.mktemp("servo")
    return "\n".join(servo.run(BENCH, out).lines), out


def test_the_committed_points_are_the_planted_ones() -> None:
    committed = pd.read_csv(BENCH.parent / "torque_speed.csv")
    pd.testing.assert_frame_equal(committed, planted_sweep(), check_exact=False, atol=1e-7)


@pytest.mark.parametrize(("kind", "supply"), TABLES)
def test_tables_4_4_and_4_5_come_back(kind: str, supply: float) -> None:
    found = {(k, s): x for k, s, x in lines(BENCH, planted_sweep(), "torque_on_speed")}[kind, supply]
    max_torque, stall, max_speed, no_load = TABLES[kind, supply]
    assert found.max_torque == pytest.approx(max_torque, abs=1e-6)
    assert found.stall_torque.value == pytest.approx(stall, abs=1e-6)
    assert found.max_speed == pytest.approx(max_speed, abs=1e-6)
    assert found.no_load_speed.value == pytest.approx(no_load, abs=1e-6)


def test_the_comparison_with_the_data_sheet_is_table_4_6(report: tuple[str, Path]) -> None:
    rows = [line.split() for line in report[0].splitlines()]
    assert ["MX", "64", "at", "14.8", "V", "4.00", "8.49", "7.3", "8.17", "-45%", "+4%"] in rows
    assert ["MX", "106", "at", "14.8", "V", "6.80", "6.82", "10.0", "5.76", "-32%", "+18%"] in rows


def test_the_line_is_said_not_to_hold(report: tuple[str, Path]) -> None:
    text = report[0]
    assert "maximum torque lies +1.11 N·m from the fitted stall torque and the maximum speed +1.49 rad/s" in text
    assert text.count("the straight line does not hold") == len(TABLES)


def test_table_4_8_is_not_its_own_mean(report: tuple[str, Path]) -> None:
    assert "MX 106: the stated mean of 0.10 N·m is not the mean of its motors, which is 0.075 N·m" in report[0]
    assert "MX 64: the stated mean" not in report[0]


def test_new_and_used_motors_are_told_apart_by_a_test() -> None:
    sweep = planted_sweep()
    difference, p, _ = new_against_used(sweep[sweep["type"] == "MX 106"], "torque_on_speed") or pytest.fail("no test")
    assert difference.low < -1.9 < difference.high
    assert p < 0.01
    difference, p, _ = new_against_used(sweep[sweep["type"] == "MX 64"], "torque_on_speed") or pytest.fail("no test")
    assert p > 0.05


def test_the_servo_text_is_a_scenario_servo(report: tuple[str, Path]) -> None:
    text = (report[1] / "servos.yaml").read_text(encoding="utf-8")
    data = yaml.safe_load(text) | {
        "name": "x",
        "robot": {"urdf": "robot.urdf"},
        "motion": {"keyframes": "motion.json"},
        "ground": "flat",
    }
    scenario = Scenario.model_validate(data)
    mx106 = next(s for s in scenario.servos if s.name == "MX_106")
    assert isinstance(mx106, DcServo)
    assert isinstance(mx106.supply, float)
    assert mx106.torque_constant / mx106.resistance * mx106.supply == pytest.approx(6.80 + 0.075, rel=0.01)
    limits = (report[1] / "limits.xml").read_text(encoding="utf-8")
    assert '<limit effort="7.57" velocity="8.22"/>\n<dynamics friction="0.075"/>' in limits


def test_the_figures_are_written(report: tuple[str, Path]) -> None:
    assert {f.name for f in report[1].glob("*.png")} == {
        *("torque_speed_MX_64.png", "torque_speed_MX_106.png"),
        *("new_and_used_MX_64.png", "new_and_used_MX_106.png"),
    }


def test_the_intervals_hold_what_they_promise() -> None:
    rng = np.random.default_rng(1)
    speed, hits = np.linspace(0.2, 6.0, 12), np.zeros(2)
    for _ in range(400):
        line = fit_line(speed, 7.0 * (1 - speed / 6.5) + rng.normal(0, 0.4, 12))
        hits += [line.stall_torque.low <= 7.0 <= line.stall_torque.high]
        hits[1] += (line.no_load_speed.low <= 6.5 <= line.no_load_speed.high) - (
            line.stall_torque.low <= 7.0 <= line.stall_torque.high
        )
    assert np.all(np.abs(hits / 400 - 0.95) < 0.035)


def test_the_regression_follows_the_variable_with_the_error() -> None:
    rng = np.random.default_rng(2)
    torque = np.repeat(np.linspace(0, 6, 7), 40)
    speed = 6.5 * (1 - torque / 7) + rng.normal(0, 0.8, len(torque))
    right, wrong = fit_line(speed, torque, "speed_on_torque"), fit_line(speed, torque, "torque_on_speed")
    assert right.stall_torque.low < 7.0 < right.stall_torque.high
    assert not wrong.stall_torque.low < 7.0 < wrong.stall_torque.high


def test_a_straight_line_raises_no_alarm() -> None:
    speed = np.linspace(0, 6, 8)
    torque = 7 * (1 - speed / 6.5) + np.array([0.1, -0.1, 0.05, -0.05, -0.05, 0.05, -0.1, 0.1])
    line = fit_line(speed, torque)
    assert line.curvature_p > 0.05
    assert line.max_torque <= line.stall_torque.high


def test_drive_constants_are_the_planted_ones_for_every_supply() -> None:
    constant, resistance, coulomb = 2.19, 2.96, 0.1
    speed, supply = np.tile(np.linspace(0.5, 5, 6), 3), np.repeat([12.8, 14.8, 16.0], 6)
    torque = constant / resistance * (supply - constant * speed) - coulomb
    found = drive_constants(speed, torque, supply, coulomb)
    assert [x.value for x in found] == pytest.approx([constant, resistance], rel=1e-9)


def test_the_jackknife_of_a_mean_is_students_interval() -> None:
    values = np.random.default_rng(3).normal(5, 2, 12)
    (found,) = jackknife(list(values), lambda v: np.array([np.mean(v)]))
    expected = mean(values)
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high))
