"""Servos that are told efforts or velocities: closed forms in every engine, and what a scenario may say of them."""

from pathlib import Path

import numpy as np
import pytest
import realitygap_engines as engines
from realitygap.files.errors import InputError
from realitygap.robot.drive import EFFORT, PID, POSITION, SPEED, TORQUE, VELOCITY
from realitygap.robot.effects import EFFECTS
from realitygap.robot.plant import Plant, build_plant
from realitygap.scenario.file import load_scenario
from realitygap.simulate.commands import Commands
from realitygap.simulate.effect_bench import arm
from realitygap.simulate.experiment import experiments
from realitygap.simulate.rollout import rollout
from realitygap.simulate.start import start_state
from realitygap.trace.trace import Trace
from realitygap_engines import Physics

H = 1e-3
every = pytest.mark.parametrize("engine", engines.available())


def upright(kind: int, meaning: int, gain: float) -> Plant:
    """The bench's arm without friction, under no gravity but its own bearing: what it takes is J·ω' = τ."""
    plant = arm()
    d = plant.drive
    d["kind"], d["meaning"], d["gain"] = kind, meaning, gain
    d["coulomb"] = d["static"] = d["viscous"] = 0.0
    d["armature"] = 0.1
    return plant


def turned(plant: Plant, command: float, engine: str) -> Trace:
    physics = Physics(H, gravity=(0.0, 0.0, 0.0))
    with engines.load(engine).open(plant.machine(), physics) as simulation:
        commands = Commands(np.zeros(1), np.array([[command]]))
        return rollout(simulation, plant, commands, start_state(plant, np.zeros(1)), 0.5).trace


INERTIA = 0.5 * 0.15**2 + 1e-3 + 0.1


@every
def test_an_effort_servo_gives_what_it_is_told(engine: str) -> None:
    plant = upright(TORQUE, EFFORT, 1.5)
    plant.drive["effort_limit"] = 0.4
    for command, given in ((0.2, 0.3), (-1.0, -0.4)):
        trace = turned(plant, command, engine)
        assert trace.velocity is not None
        assert trace.effort is not None
        np.testing.assert_allclose(trace.effort, given, rtol=1e-12)
        np.testing.assert_allclose(trace.velocity[-1, 0], given / INERTIA * trace.time[-1], rtol=4e-3)


@every
def test_a_velocity_servo_closes_in_exponentially(engine: str) -> None:
    trace = turned(upright(SPEED, VELOCITY, 0.8), 2.0, engine)
    assert trace.velocity is not None
    exact = 2.0 * (1 - np.exp(-trace.time * 0.8 / INERTIA))
    assert np.abs(trace.velocity[:, 0] - exact).max() < 0.02


@every
def test_a_pid_servo_is_damped_by_its_derivative_gain(engine: str) -> None:
    """J·q'' = kp·(c − q) − kd·q', as an oscillator (Åström & Hägglund 1995)."""
    plant, kp, kd, goal = upright(PID, POSITION, 0.0), 20.0, 0.6, 0.3
    plant.drive["kp"] = kp
    EFFECTS["derivative_gain"].apply(plant, [0], {"gain": kd})
    trace = turned(plant, goal, engine)
    assert trace.position is not None
    decay, pace = 0.5 * kd / INERTIA, np.sqrt(kp / INERTIA - (0.5 * kd / INERTIA) ** 2)
    swing = np.cos(pace * trace.time) + decay / pace * np.sin(pace * trace.time)
    exact = goal * (1.0 - np.exp(-decay * trace.time) * swing)
    assert np.abs(trace.position[:, 0] - exact).max() < 2e-3
    assert exact.max() > 1.3 * goal


URDF = """<robot name="arm"><link name="base"/><link name="arm"><inertial><mass value="0.5"/>
<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="finger"><inertial><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/>
</inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint>
<joint name="grip" type="revolute"><parent link="arm"/><child link="finger"/><origin xyz="0 0 -0.2"/><axis xyz="1 0 0"/>
<limit lower="-0.5" upper="0.5" effort="1" velocity="1"/></joint></robot>"""
SCENARIO = """
name: told
robot: {urdf: arm.urdf, base: fixed, hold: {grip: 0.1}}
servos: [{joints: hinge, kind: effort}]
motion: {recorded: current, as: effort}
recordings: {effort: {topic: current, measures: motor, factor: {hin*: 2.5}}, runs: [{path: run.csv}]}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    time = np.arange(0.0, 1.0, 0.01)
    rows = "\n".join(f"{t},{0.1 * t},{0.1},{0.3 * np.sin(6 * t)}" for t in time)
    (tmp_path / "run.csv").write_text("time,position,velocity,current\n" + rows)
    (tmp_path / "arm.urdf").write_text(URDF)
    return tmp_path


def scenario(folder: Path, *changes: tuple[str, str]) -> Path:
    text = SCENARIO
    for change in changes:
        assert change[0] in text
        text = text.replace(*change)
    (folder / "scenario.yaml").write_text(text)
    return folder / "scenario.yaml"


def test_a_measured_effort_can_be_the_command_with_its_factor(folder: Path) -> None:
    (found,) = experiments(load_scenario(scenario(folder)))
    assert found.recording is not None
    assert found.recording.trace.effort is None  # it is not compared with itself
    assert any("drives the motion" in note for note in found.recording.notes)
    np.testing.assert_allclose(found.commands.value[:, 0], 2.5 * 0.3 * np.sin(6 * found.commands.time), atol=1e-12)


def test_another_command_keeps_its_own_unit(folder: Path) -> None:
    path = scenario(folder, ("recorded: current", "recorded: position"))
    (found,) = experiments(load_scenario(path))
    np.testing.assert_allclose(found.commands.value[:, 0], 0.1 * found.commands.time, atol=1e-12)


def test_velocities_are_commands_too(folder: Path) -> None:
    path = scenario(
        folder, ("kind: effort", "kind: velocity, gain: 0.5"), ("current, as: effort", "velocity, as: velocity")
    )
    (found,) = experiments(load_scenario(path))
    np.testing.assert_allclose(found.commands.value, 0.1)
    assert found.plant.drive["kind"][0] == SPEED


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ([(", as: effort", "")], "found effort, which takes commands that are effort, but the motion's are position"),
        ([("kind: effort", "kind: velocity, gain: 1.0")], "velocity, which takes"),
        ([("kind: effort", "kind: pid, kp: 1.0"), ("as: effort", "as: velocity")], "found pid"),
        ([("grip: 0.1", "finger*: 0.1")], "finger.* matches no joint; the robot has hinge, grip"),
        ([("grip: 0.1", "grip: 1.0")], "outside the limits of grip"),
        ([("grip: 0.1", '"*": 0.1')], "holds all of hinge, grip"),
        ([("robot: {", "effects: [{effect: backlash, target: grip, angle: 0.1}]\nrobot: {")], "no joint grip"),
    ],
)
def test_what_does_not_fit_is_told(folder: Path, changes: list[tuple[str, str]], told: str) -> None:
    with pytest.raises(InputError, match=told) as error:
        experiments(load_scenario(scenario(folder, *changes)))
    assert "scenario.yaml" in str(error.value)


def test_a_held_joint_is_part_of_its_link(folder: Path) -> None:
    plant = build_plant(load_scenario(scenario(folder)))
    assert plant.model.joint_names == ["hinge"]
    assert plant.model.mass == pytest.approx(1.6)
