"""What parts the rotor from the link is looked for where no rotor is stated: once its inertia is found."""

import sys
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest
import realitygap_engines as engines
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import acting, suspects
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.data.worker import Query, answer
from realitygap.diagnose.search.search import search
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

sys.path.insert(0, str(Path(__file__).parents[1] / "check"))  # plain modules, not a package

from teams import Table, Team

ROTOR, STIFFNESS, ANGLE = 0.22, 1500.0, 0.01
"""kg·m², N·m/rad and rad: a geared drive of an arm's joint, soft (Taghirad, Bélanger 1998) or with play."""
LINK = (
    '<robot name="joint"><link name="base"/><link name="link"><inertial><origin xyz="0 0 -0.2"/><mass value="5"/>'
    '<inertia ixx="0.25" iyy="0.25" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    '<joint name="lift" type="revolute"><parent link="base"/><child link="link"/><axis xyz="0 1 0"/>'
    '<limit lower="-2.6" upper="2.6" effort="90" velocity="6"/></joint></robot>'
)
SCENARIO = {
    "name": "joint",
    "robot": {"urdf": "robot.urdf", "base": "fixed"},
    "servos": [{"joints": "*", "kind": "pid", "kp": 700.0, "kd": 25.0}],
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


def without_rotor(folder: Path, *missing: EffectSpec) -> Problem:
    """One joint whose servo has no armature, and recordings of it at 250 Hz with what is missing."""
    folder.mkdir(exist_ok=True)
    team = Team(["lift"], {"robot.urdf": LINK}, deepcopy(SCENARIO))
    (folder / "robot.urdf").write_text(LINK)
    plant = place(build_plant(ScenarioFile(folder / "s.yaml", validate(folder, Scenario, SCENARIO), SCENARIO)), missing)
    rng, time = np.random.default_rng(3), np.arange(1000) / 250.0
    for k, command in enumerate(courses(time)):
        start = start_state(plant, command[0])
        with engines.load("mujoco").open(plant.machine(), Physics(1e-3)) as simulation:
            trace = Signals(rollout(simulation, plant, Commands(time, command), start, time[-1]).trace.at(time))
        noise = rng.standard_normal((3, len(time), 1))
        position = np.round(trace.position / 2e-5 + 0.3 * noise[0]) * 2e-5
        velocity, effort = trace.velocity + 3e-3 * noise[1], trace.effort + 0.3 * noise[2]
        team.tables[str(k)] = Table(time, command, position, velocity, effort)
    return build_problem(load_scenario(team.write(folder)), "mujoco")


ROTOR_MISSING = EffectSpec(effect="rotor_inertia", target="*", armature=ROTOR)
BEHIND = {
    "joint_compliance": EffectSpec(effect="joint_compliance", target="*", stiffness=STIFFNESS),
    "backlash": EffectSpec(effect="backlash", target="*", angle=ANGLE),
}
"""Effects between rotor and link."""


def test_they_are_suspected_and_act_beside_a_rotor_only(tmp_path: Path) -> None:
    problem = without_rotor(tmp_path, ROTOR_MISSING)
    everyone = {s.effect: s for s in suspects(problem)}
    assert set(BEHIND) <= set(everyone)
    assert not set(BEHIND) & {s.effect for s in acting(problem)}
    rotor = guess(problem, everyone["rotor_inertia"])
    for name in BEHIND:
        there = guess(problem, everyone[name])
        assert answer(problem, Query((there,), 0, "mujoco", 1.0)) is None
        for order in ((rotor, there), (there, rotor)):
            assert answer(problem, Query(order, 0, "mujoco", 1.0)) is not None


@pytest.mark.parametrize("effect", BEHIND)
def test_what_lies_behind_a_rotor_is_named_where_none_was_stated(effect: str, tmp_path: Path) -> None:
    problem, planted = without_rotor(tmp_path, ROTOR_MISSING, BEHIND[effect]), BEHIND[effect].parameters
    with Simulations(problem, 2) as simulations:
        found = search(simulations, suspects(problem), [], lambda _: None)
    named = {c.suspect.effect: c.parameters for c in found.best.fit.changes}
    assert set(named) == {"rotor_inertia", effect}
    assert named["rotor_inertia"]["armature"] == pytest.approx(ROTOR, rel=0.05)
    assert {n: named[effect][n] for n in planted} == pytest.approx(planted, rel=0.1)
