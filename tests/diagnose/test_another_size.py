"""A fit finds the friction of a pendulum that swings freely, whose last swings bend what it does (synthetic)."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from demo_problem import suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit, resized
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.search.criterion import Criterion
from realitygap.scenario.file import load_scenario

DRY, MASS, LENGTH, INERTIA = 0.15, 0.8, 0.2, 0.011
ARM = f"""<robot name="pendulum"><link name="base"/><link name="arm"><inertial><origin xyz="0 0 -{LENGTH}"/>
<mass value="{MASS}"/><inertia ixx="{INERTIA}" iyy="{INERTIA}" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint></robot>"""
SCENARIO = """name: free_swing
robot: {urdf: arm.urdf, base: fixed}
servos: [{joints: "*", kind: effort}]
motion: {recorded: command, as: effort}
recordings: {virtual: true, runs: [{path: swing.csv}]}
accept: [drives_nothing]
"""


def _swing() -> str:
    """A fall from 0.9 rad, with dry friction that stops within a step and sensor noise of 0.3 mrad."""
    noise, h, every = np.random.default_rng(8), 1e-4, 50
    inertia, angle, speed, rows = INERTIA + MASS * LENGTH**2, 0.9, 0.0, ["time,position_hinge,command_hinge"]
    for k in range(60000):
        if k % every == 0:
            rows.append(f"{k * h:.4f},{angle + noise.normal(0.0, 3e-4):.6f},0")
        pulled = -MASS * 9.81 * LENGTH * np.sin(angle)
        there = speed + h * pulled / inertia
        speed = np.sign(there) * max(abs(there) - h * DRY / inertia, 0.0)
        angle += h * speed
    return "\n".join(rows)


@pytest.fixture(scope="module")
def problem(tmp_path_factory: pytest.TempPathFactory) -> Problem:
    folder: Path = tmp_path_factory.mktemp("swing")
    (folder / "arm.urdf").write_text(ARM, encoding="utf-8")
    (folder / "swing.csv").write_text(_swing(), encoding="utf-8")
    (folder / "scenario.yaml").write_text(SCENARIO, encoding="utf-8")
    return build_problem(load_scenario(folder / "scenario.yaml"), "mujoco")


@pytest.fixture(scope="module")
def simulations(problem: Problem) -> Iterator[Simulations]:
    with Simulations(problem, 1) as opened:
        yield opened


@pytest.mark.parametrize("begun", [0.0124, 0.1, 0.2, 0.3])
def test_friction_is_found_from_where_steps_promise_nothing(
    problem: Problem, simulations: Simulations, begun: float
) -> None:
    criterion = Criterion(simulations, [])
    left = residual(simulations, [], criterion.train)
    assert left is not None
    criterion.set_effective_fraction(left)
    dry = guess(problem, suspect_of(problem, "coulomb_friction", "hinge")).at({"torque": begun})
    found = criterion.fit([dry], Fit((), left), "compared")
    assert found is not None
    assert found.fit.changes[0].parameters["torque"] == pytest.approx(DRY, rel=0.01)


def test_of_the_last_change_more_is_tried_and_no_more_than_there_can_be(
    problem: Problem, simulations: Simulations
) -> None:
    criterion = Criterion(simulations, [])
    oil, dry = (guess(problem, suspect_of(problem, e, "hinge")) for e in ("viscous_friction", "coulomb_friction"))
    left = residual(simulations, [oil, dry], criterion.train)
    assert left is not None
    for times, of in ((2.0, 2.0), (0.5, 0.5), (-1.0, 0.0)):
        other = resized(criterion.motions, Fit((oil, dry), left), times)
        assert other is not None
        assert other.changes[0] == oil
        assert other.changes[1].parameters["torque"] == pytest.approx(of * dry.parameters["torque"])
        anew = residual(simulations, other.changes, criterion.train)
        assert anew is not None
        np.testing.assert_allclose(other.residual, anew, atol=1e-9)
    assert resized(criterion.motions, Fit((), left), 2.0) is None
