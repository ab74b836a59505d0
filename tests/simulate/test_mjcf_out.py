"""MJCF out: plain MuJoCo, stepping the file that was written, moves as our own simulation does, effect by effect."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from realitygap.robot.drive import CASCADE, DC, DUTY, EFFORT, PID, SPEED, TORQUE, VELOCITY, neutral_drive
from realitygap.robot.effects import EFFECTS, Effect
from realitygap.robot.effort_map import EffortMap
from realitygap.robot.mjcf import write_mjcf
from realitygap.robot.plant import Plant
from realitygap.simulate.commands import Commands, on_steps
from realitygap.simulate.effect_bench import command, motion, planted
from realitygap.simulate.rollout import rollout
from realitygap.simulate.start import start_state
from realitygap_engines import Ground, Physics, State, load
from realitygap_engines.law.dynamics import Dynamics
from realitygap_engines.model.mjcf import read_mjcf
from realitygap_engines.model.robot import Joint, Link, Model, Sphere, axis_rotation

STEP = 1e-3
DURATION = 2.0
AGREES = 1e-6
"""[rad or m]"""


def natively(text: str, plant: Plant, start: State, duration: float, value: np.ndarray) -> np.ndarray:
    """Positions of the joints (t, n) where plain MuJoCo steps the file under the commands; a free base's come first."""
    m = mujoco.MjModel.from_xml_string(text)
    d = mujoco.MjData(m)
    names = plant.model.joint_names
    at = [int(m.joint(name).qposadr[0]) for name in names]
    d.qpos[at] = start.position - plant.drive["offset"]
    if plant.model.floating:
        d.qpos[:7] = *start.base_position, *start.base_quaternion
        d.qvel[:3] = start.base_linear
        at = [0, 1, 2, *at]
    controls = {m.actuator(name).id: i for i, name in enumerate(names) if plant.drive["kind"][i]}
    out = []
    for k in range(round(duration / STEP)):
        out.append(d.qpos[at])
        for actuator, i in controls.items():
            first = int(m.actuator_ctrladr[actuator])
            d.ctrl[first] = value[k, i]
            if plant.drive["kd"][i]:  # a pid servo is told the goal's rate, too
                after = value[min(k + 1, len(value) - 1), i]
                d.ctrl[first + 1] = (after - value[max(k - 1, 0), i]) / (2 * STEP)
        mujoco.mj_step(m, d)
    return np.array(out)


def ours(plant: Plant, commands: Commands, start: State, duration: float) -> np.ndarray:
    with load("mujoco").open(plant.machine(), Physics(STEP, ground=plant.ground)) as simulation:
        trace = rollout(simulation, plant, commands, start, duration).trace
    position = trace.position
    assert position is not None
    return np.hstack([trace.base_position, position]) if trace.base_position is not None else position


def difference(plant: Plant, value: np.ndarray, start: State | None = None) -> float:
    """The largest difference of the two motions [rad or m]."""
    start = start or start_state(plant, np.zeros(len(plant.model.joints)))
    commands = Commands(STEP * np.arange(len(value), dtype=np.float64), value, held=False)
    steps = round(DURATION / STEP)
    text, _ = write_mjcf(plant, Physics(STEP, ground=plant.ground))
    stream = on_steps(commands, steps, STEP, np.zeros(len(plant.model.joints)))
    return float(np.abs(natively(text, plant, start, DURATION, stream) - ours(plant, commands, start, DURATION)).max())


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=list(EFFECTS))
def test_an_effect_is_native_and_agrees_or_is_listed(effect: Effect) -> None:
    plant = planted(effect)
    text, lost = write_mjcf(plant, Physics(STEP, ground=plant.ground))
    for sentence in lost:
        assert sentence in text
    if lost:
        assert any(sentence.startswith(effect.name) for sentence in lost), lost
        return
    start = start_state(plant, np.zeros(len(plant.model.joints)))
    if plant.model.floating:
        start.base_linear = np.array([motion(effect).push, 0.0, 0.0])
    time = np.arange(0.0, DURATION + STEP, STEP)
    value = command(time) if plant.model.joints else np.zeros((len(time), 0))
    assert difference(plant, value, start) < AGREES


def chain(floating: bool = False) -> Plant:
    """Three joints, one of them prismatic, with friction, damping and rotors; servos are the caller's."""
    axes = ([0.0, 1.0, 0.0], [0.6, 0.0, 0.8], [0.0, 1.0, 0.0])
    links = [Link("base", 3.0, np.array([0.01, 0.0, 0.0]), np.diag([0.03, 0.04, 0.05]))]
    joints = []
    for i, axis in enumerate(axes):
        origin = np.eye(4)
        origin[:3, :3] = axis_rotation(np.array([0.0, 0.0, 1.0]), 0.3 * i)
        origin[:3, 3] = 0.02, 0.01, -0.15 * bool(i)
        joints.append(Joint(f"j{i}", i == 1, i, origin, np.array(axis)))
        links.append(Link(f"l{i}", 0.6, np.array([0.01, 0.0, -0.07]), np.diag([3e-3, 2e-3, 2e-3])))
    drive = neutral_drive(3)
    drive["coulomb"] = drive["static"] = 0.03
    drive["viscous"], drive["armature"] = 0.05, 0.01
    model = Model("chain", tuple(links), tuple(joints), floating)
    return Plant(model, drive, None, np.zeros(3), np.zeros(3), np.ones(3), np.zeros(2))


def swings() -> np.ndarray:
    """A goal for each joint of the chain: swings, a jump and a rest. Shape (t, 3)."""
    value = command(np.arange(0.0, DURATION + STEP, STEP))
    return np.asarray(value * np.array([1.0, 0.1, -0.8]))


SERVOS = {
    "dc": {"kind": DC, "gain": 2.5, "duty_limit": 0.9, "supply": 12.0, "torque_constant": 1.5, "resistance": 2.5},
    "dc that saturates": {
        "kind": DC,
        "gain": 9.0,
        "duty_limit": 0.2,
        "supply": 12.0,
        "torque_constant": 1.5,
        "resistance": 2.5,
    },
    "p": {"kind": PID, "kp": 40.0},
    "p that saturates": {"kind": PID, "kp": 40.0, "effort_limit": 2.0},
    "pd": {"kind": PID, "kp": 40.0, "kd": 0.8},
    "pid": {"kind": PID, "kp": 40.0, "ki": 30.0, "kd": 0.8},
    "cascade": {"kind": CASCADE, "gain": 2.0, "kv": 0.5, "kp": 30.0},
    "cascade of an offset encoder": {"kind": CASCADE, "gain": 2.0, "kv": 0.5, "kp": 30.0, "offset": 0.1},
    "a cable": {"kind": PID, "kp": 40.0, "cable_stiffness": 8.0, "cable_rest": 0.2, "offset": -0.1},
    "no servo": {},
}


def driven(name: str, **more: Any) -> Plant:
    plant = chain(**more)
    for field, value in SERVOS[name].items():
        plant.drive[field] = value
    return plant


@pytest.mark.parametrize("name", SERVOS)
def test_every_servo_on_a_chain_of_joints_agrees(name: str) -> None:
    assert difference(driven(name), swings()) < AGREES


def test_a_command_that_is_a_duty_an_effort_or_a_velocity_agrees() -> None:
    for kind, meaning, size in ((DC, DUTY, 0.4), (DC, EFFORT, 1.5), (TORQUE, EFFORT, 1.5), (SPEED, VELOCITY, 2.0)):
        plant = driven("dc")
        plant.drive["kind"], plant.drive["meaning"], plant.drive["gain"] = kind, meaning, 0.7
        plant.drive["effort_limit"] = 1.0 if kind != SPEED else np.inf
        assert difference(plant, size * swings()) < AGREES


@pytest.mark.parametrize("delay", [0.02, 0.0105])
def test_a_delay_of_whole_steps_agrees_and_another_nearly(delay: float) -> None:
    plant = driven("pd")
    plant.drive["kd"] = 0.0
    plant.drive["viscous"] = 0.4
    plant.delay[:] = delay
    assert difference(plant, swings()) < (AGREES if delay == 0.02 else 1e-3)


def test_what_a_file_cannot_say_is_told() -> None:
    plant = driven("pd")
    plant.efforts = [lambda time: np.zeros((len(time), 3))]
    plant.maps = [EffortMap(0, ("angle",), ((-1.0, 1.0),), (0.1, 0.2))]
    told = write_mjcf(plant, Physics(STEP))[1]
    assert [sentence.split(",")[0] for sentence in told] == ["efforts over time", "effort_map"]


def test_what_a_sensor_does_is_one_sentence() -> None:
    plant = planted(EFFECTS["effort_hysteresis"], {"effort": 0.3, "onset": 0.2})
    _, lost = write_mjcf(plant, Physics(STEP))
    assert lost == ["effort_hysteresis, of the sensor and not of the robot (hinge)"]


def test_the_file_is_the_machine_that_was_written(tmp_path: Path) -> None:
    """Read again it has the plant's inertia and gravity, limits, friction and servos."""
    plant = driven("cascade")
    joints = tuple(replace(j, lower=-1.0, upper=2.0) for j in plant.model.joints)
    plant.model = replace(plant.model, joints=joints)
    path = tmp_path / "robot.xml"
    text, lost = write_mjcf(plant, Physics(STEP))
    path.write_text(text)
    assert lost == []
    again = read_mjcf(path, floating=False)
    assert [(j.lower, j.upper, j.friction, j.damping) for j in again.joints] == [(-1.0, 2.0, 0.03, 0.05)] * 3
    assert [dict(a.values) for a in again.actuators] == [{"gain": 1.0, "kv": 1.0, "kp": 30.0}] * 3
    q, w, base = (
        np.array([0.3, 0.1, -0.7]),
        np.array([1.0, -0.2, 2.0]),
        np.array([0, 0, 0, 1, *np.zeros(9)], dtype=float),
    )
    ours, read = Dynamics(plant.model), Dynamics(again)
    for dynamics in (ours, read):
        dynamics.update(q, w, base, np.array([0.0, 0.0, -9.81]))
    np.testing.assert_allclose(read.inertia, ours.inertia, rtol=0, atol=1e-12)
    np.testing.assert_allclose(read.bias, ours.bias, rtol=0, atol=1e-12)


def test_a_robot_on_the_ground_agrees() -> None:
    """Free to move, on rigid feet: contacts, dry friction and servos in one step, for as long as nothing slides."""
    plant = driven("pd", floating=True)
    base, *others = plant.model.links
    feet = tuple(Sphere(np.array([x, y, -0.4]), 0.02) for x in (-0.2, 0.2) for y in (-0.2, 0.2))
    plant.model = replace(plant.model, links=(replace(base, spheres=feet), *others))
    plant.ground = Ground(0.8)
    assert difference(plant, 0.5 * swings()) < AGREES
