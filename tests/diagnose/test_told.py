"""What recordings show by themselves: velocity filters in the demo, and late speeds of one joint (all synthetic)."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.candidates.told import deviations, told_by_recordings
from realitygap.diagnose.data.problem import Problem
from realitygap.recording.faults import low_pass
from realitygap.robot.effects.place import place
from realitygap.scenario.schema import EffectSpec
from recorded_joint import recorded

Z95 = 1.96


@pytest.mark.parametrize("scale", [0.8, 1.25])
@pytest.mark.parametrize("time", [0.0131, 0.0274])
def test_a_filter_is_seen_and_its_interval_holds_it(problem: Problem, scale: float, time: float) -> None:
    cases = []
    for case in problem.cases:
        period = float(np.median(np.diff(case.measured.time)))
        travel = np.asarray(np.gradient(case.value("position"), case.measured.time, axis=0))
        slow = np.column_stack([scale * low_pass(travel[:, j], time, period) for j in range(travel.shape[1])])
        cases.append(replace(case, measured=replace(case.measured, velocity=slow)))
    planted = replace(problem, cases=tuple(cases))
    (found,) = told_by_recordings(planted, suspects(planted))
    off = deviations(planted, found)
    for name, true in (("scale", scale), ("time", time)):
        assert abs(found.parameters[name] - true) < Z95 * off[name]
        assert Z95 * off[name] < 0.02 * true


LATE = "derivative_lag"
KINDS: dict[str, dict[str, float]] = {
    "cascade": {"gain": 1.0, "kv": 25.0, "kp": 28.0},
    "pid": {"kp": 700.0, "kd": 25.0},
}
OF_THE_SERVO = [
    EffectSpec(effect="current_lag", target="*", time=0.012),
    EffectSpec(effect="command_delay", target="*", time=0.012),
    EffectSpec(effect="controller_gain", target="*", gain=500.0),
    EffectSpec(effect="coulomb_friction", target="*", torque=6.0),
    EffectSpec(effect="effort_limit", target="*", effort=60.0),
]
"""What is not a late speed."""


@pytest.mark.parametrize("lag", [0.006, 0.02])
def test_a_late_speed_is_seen_and_its_interval_holds_it(lag: float, tmp_path: Path) -> None:
    planted = recorded(tmp_path, KINDS["cascade"] | {"kind": "cascade"}, EffectSpec(effect=LATE, target="*", time=lag))
    (found,) = told_by_recordings(planted, suspects(planted))
    assert found.suspect.effect == LATE
    assert abs(found.parameters["time"] - lag) < Z95 * deviations(planted, found)["time"]
    assert Z95 * deviations(planted, found)["time"] < 0.2 * lag


@pytest.mark.parametrize("other", OF_THE_SERVO, ids=lambda e: e.effect)
@pytest.mark.parametrize("kind", KINDS)
def test_nothing_else_is_a_late_speed(kind: str, other: EffectSpec, tmp_path: Path) -> None:
    planted = recorded(tmp_path, KINDS[kind] | {"kind": kind}, other)
    assert not told_by_recordings(planted, suspects(planted))


def test_an_effort_that_never_changes_tells_of_no_late_speed(tmp_path: Path) -> None:
    planted = recorded(tmp_path, KINDS["cascade"] | {"kind": "cascade"}, EffectSpec(effect=LATE, target="*", time=0.02))
    still = [replace(c, measured=replace(c.measured, effort=np.zeros_like(c.value("effort")))) for c in planted.cases]
    constant = replace(planted, cases=tuple(still))
    assert not told_by_recordings(constant, suspects(constant))


def test_a_lag_that_the_scenario_has_is_none(tmp_path: Path) -> None:
    late = EffectSpec(effect=LATE, target="*", time=0.01)
    planted = recorded(tmp_path, KINDS["cascade"] | {"kind": "cascade"}, late)
    known = [replace(c, experiment=c.experiment.with_plant(place(c.experiment.plant, [late]))) for c in planted.cases]
    stated = replace(planted, plant=place(planted.plant, [late]), cases=tuple(known))
    assert told_by_recordings(planted, suspects(planted))
    assert not told_by_recordings(stated, suspects(stated))
