"""A joint of an arm (synthetic): recordings of it at 250 Hz with what its scenario lacks, as a diagnosis has them."""

import sys
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import realitygap_engines as engines
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.files.validation import validate
from realitygap.robot.effects.place import place
from realitygap.robot.plant import build_plant
from realitygap.scenario.file import ScenarioFile, load_scenario
from realitygap.scenario.schema import EffectSpec, Scenario
from realitygap.simulate.commands import Commands
from realitygap.simulate.rollout import rollout
from realitygap.simulate.start import start_state
from realitygap_engines import Physics
from realitygap_engines.model.robot import Array
from signals import Signals

sys.path.insert(0, str(Path(__file__).parent / "check"))  # plain modules, not a package

from teams import Table, Team

LINK = (
    '<robot name="joint"><link name="base"/><link name="link"><inertial><origin xyz="0 0 -0.2"/><mass value="5"/>'
    '<inertia ixx="0.25" iyy="0.25" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    '<joint name="lift" type="revolute"><parent link="base"/><child link="link"/><axis xyz="0 1 0"/>'
    '<limit lower="-2.6" upper="2.6" effort="90" velocity="6"/></joint></robot>'
)
SCENARIO = {
    "name": "joint",
    "robot": {"urdf": "robot.urdf", "base": "fixed"},
    "motion": {"recorded": "command"},
    "recordings": {"effort": "motor", "runs": [{"path": str(k)} for k in range(4)]},
}


def courses(time: Array) -> list[Array]:
    """A slow and a fast sum of sines, steps, and quick moves back and forth, shape (t, 1) each [rad]."""
    sines = [sum(a * np.sin(2 * np.pi * f * time + k) for k, (a, f) in enumerate(waves)) for waves in WAVES]
    steps = np.array([0.0, 0.3, -0.2, 0.5, 0.0, -0.3])[(time / 1.0).astype(int) % 6]
    moves = 0.4 * np.clip(3.0 * np.sin(2 * np.pi * 0.4 * time), -1.0, 1.0)
    return [np.asarray(value)[:, None] for value in (*sines, steps, moves)]


WAVES = (((0.4, 0.2), (0.1, 0.7)), ((0.3, 0.5), (0.1, 1.7), (0.04, 3.1)))
"""Amplitudes [rad] and frequencies [Hz]."""


TORQUE = 20.0
"""N·m for each of what is a radian of a position."""


def recorded(folder: Path, servo: Mapping[str, Any], *missing: EffectSpec) -> Problem:
    """The joint with a servo, which is told angles or, of the kind `effort`, torques, and recordings of it with what is
    missing.
    """
    folder.mkdir(exist_ok=True)
    scenario = deepcopy(SCENARIO) | {"servos": [{"joints": "*"} | dict(servo)]}
    told, scale = SCENARIO["motion"], 1.0
    if servo["kind"] == "effort":
        told, scale = {"recorded": "command", "as": "effort"}, TORQUE
    scenario["motion"] = told
    team = Team(["lift"], {"robot.urdf": LINK}, scenario)
    (folder / "robot.urdf").write_text(LINK)
    plant = place(build_plant(ScenarioFile(folder / "s.yaml", validate(folder, Scenario, scenario), scenario)), missing)
    rng, time = np.random.default_rng(3), np.arange(1000) / 250.0
    for k, course in enumerate(courses(time)):
        command = scale * course
        start = start_state(plant, course[0])
        with engines.load("mujoco").open(plant.machine(), Physics(1e-3)) as simulation:
            trace = Signals(rollout(simulation, plant, Commands(time, command), start, time[-1]).trace.at(time))
        noise = rng.standard_normal((3, len(time), 1))
        position = np.round(trace.position / 2e-5 + 0.3 * noise[0]) * 2e-5
        velocity, effort = trace.velocity + 3e-3 * noise[1], trace.effort + 0.3 * noise[2]
        team.tables[str(k)] = Table(time, command, position, velocity, effort)
    file = load_scenario(team.write(folder))
    return build_problem(file.override({"motion": told}), "mujoco")
