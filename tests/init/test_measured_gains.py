"""The gains of a first scenario's servos, where measured efforts tell them: of an arm that is simulated (synthetic)."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import realitygap as rg
from first_scenario import EPOCH, STATE, arm, goal
from realitygap.init.draft import Draft, init
from realitygap.scenario.servos import CascadeServo, PidServo

Keep = Callable[[pd.DataFrame], Path]
KP, KD = 20.0, 0.6
JOINTS = ("shoulder", "elbow")


def drafted(
    folder: Path, servo: dict[str, Any], noise: float = 0.0, unit: float = 1.0, keep: Keep | None = None
) -> Draft:
    """The first scenario of an arm with such servos and friction, whose commands were streamed in every sample; its
    effort is recorded in a `unit` [N·m]. `keep` writes another recording than a table of it.
    """
    urdf = arm(folder / "arm.urdf", effort=30.0)
    time = np.arange(0.0, 6.0, 0.005)
    asked = pd.DataFrame({"time": time, "shoulder_command": 0.4 * goal(time), "elbow_command": 0.3 * goal(1.1 * time)})
    for joint in JOINTS:
        asked[f"{joint}_position"] = asked[f"{joint}_command"].iloc[0]
    asked.to_csv(folder / "asked.csv", index=False)
    plant = {
        "name": "arm", "robot": {"urdf": str(urdf), "base": "fixed"}, "servos": [{"joints": "*"} | servo],
        "motion": {"recorded": "command", "held": False}, "ground": "none", "physics": {"step_rate": 1000},
        "recordings": {"effort": "none", "runs": [{"path": str(folder / "asked.csv")}],
                       "columns": {"command": "command", "position": "position"}},
    }  # fmt: skip
    plant["effects"] = [{"effect": "coulomb_friction", "target": "*", "torque": 0.3}]
    trace = rg.simulate(rg.load_scenario(plant, folder), "mujoco").at(time)
    rng = np.random.default_rng(3)
    frame = asked[["time", "shoulder_command", "elbow_command"]].copy()
    assert trace.position is not None
    assert trace.velocity is not None
    assert trace.effort is not None
    for j, joint in enumerate(JOINTS):
        frame[f"{joint}_position"] = trace.position[:, j]
        frame[f"{joint}_velocity"] = trace.velocity[:, j]
        frame[f"{joint}_effort"] = (trace.effort[:, j] + noise * rng.normal(size=len(time))) / unit
    if keep is not None:
        return init(urdf, [keep(frame)], folder / "out")
    frame.to_csv(folder / "run.csv", index=False)
    return init(urdf, [folder / "run.csv"], folder / "out")


@pytest.mark.parametrize(
    ("servo", "kind"),
    [
        ({"kind": "pid", "kp": KP, "kd": KD}, PidServo),
        ({"kind": "cascade", "gain": KD, "kv": 1.0, "kp": KP / KD}, CascadeServo),
    ],
    ids=["D on the error", "D on the speed"],
)
def test_gains_and_what_the_d_acts_on_are_those_that_the_effort_tells(
    servo: dict[str, Any], kind: type[PidServo | CascadeServo], tmp_path: Path
) -> None:
    draft = drafted(tmp_path, servo, noise=0.02)
    found = rg.load_scenario(draft.path).scenario.servos
    assert [s.joints for s in found] == [[joint] for joint in JOINTS]
    for own in found:
        assert isinstance(own, kind)
        kp, kd = (own.kp, own.kd) if isinstance(own, PidServo) else (own.gain * own.kv * own.kp, own.gain * own.kv)
        assert kp == pytest.approx(KP, rel=0.03)
        assert kd == pytest.approx(KD, rel=0.1)
    assert sum("of the measured effort" in line for line in draft.guessed) == 2


@pytest.mark.parametrize(("noise", "unit"), [(5.0, 1.0), (0.02, 0.001)], ids=["noise", "thousandths"])
def test_an_effort_that_is_none_of_error_and_speed_or_of_no_such_joint_tells_no_gains(
    noise: float, unit: float, tmp_path: Path
) -> None:
    """As one that is mostly noise, or in another unit: the URDF's limits are the guess."""
    draft = drafted(tmp_path, {"kind": "pid", "kp": KP, "kd": KD}, noise, unit)
    (servo,) = rg.load_scenario(draft.path).scenario.servos
    assert isinstance(servo, PidServo)
    assert servo.kp == pytest.approx(300.0)
    assert not any("of the measured effort" in line for line in draft.guessed)


ANGLES = ("command", "position", "velocity")


@pytest.mark.parametrize("form", ["csv", "bag", "mcap"])
@pytest.mark.parametrize("turned", [ANGLES, ("command", "position"), ("velocity",)], ids="+".join)
def test_so_are_those_of_a_recording_whose_values_are_degrees(
    turned: tuple[str, ...], form: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    def keep(frame: pd.DataFrame) -> Path:
        of = {signal: [f"{joint}_{signal}" for joint in JOINTS] for signal in (*ANGLES, "effort")}
        for signal in turned:
            frame[of[signal]] = np.rad2deg(frame[of[signal]])
        if form == "csv":
            frame.to_csv(tmp_path / "run.csv", index=False)
            return tmp_path / "run.csv"
        told = []
        for k, t in enumerate(frame["time"]):
            stamp = {"stamp": EPOCH + t, "name": list(JOINTS)}
            measured = {s: frame[of[s]].iloc[k].to_list() for s in ("position", "velocity", "effort")}
            told.append(("/joint_states", EPOCH + t, STATE, stamp | measured))
            told.append(
                ("/joint_goals", EPOCH + t, STATE, stamp | {"position": frame[of["command"]].iloc[k].to_list()})
            )
        return write_bag(tmp_path / ("run.bag" if form == "bag" else "run"), form, told)

    draft = drafted(tmp_path, {"kind": "pid", "kp": KP, "kd": KD}, keep=keep)
    scenario = rg.load_scenario(draft.path).scenario
    assert scenario.recordings is not None
    units = scenario.recordings.columns.units
    assert {s for s in ANGLES if getattr(units, s) == "deg"} == set(turned)
    for own in scenario.servos:
        assert isinstance(own, PidServo)
        assert own.kp == pytest.approx(KP, rel=0.03)
        assert own.kd == pytest.approx(KD, rel=0.1)
