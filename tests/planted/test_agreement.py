"""What is planted is what the list says: the truth, simulated by the project, does what the foreign plant did."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import realitygap as rg
import yaml
from realitygap.robot.effects import EFFECTS

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

import cases
import planted
import plants
import robots
from catalogue import Case
from plants import Hidden, Run, Truth
from recorder import Sensing

CLEAN = Sensing(
    rate=500.0, quantum=1e-8, position_noise=0.0, velocity_noise=1e-7, effort_noise=0.0, disturbance=0.0, jitter=0.0
)
LEFT = 0.12
"""A share of the effect that integrators and contact laws of two simulators may disagree about: the foreign plant's
springs are damped a little, and its bristles give."""
SUDDEN = {"stribeck_friction": 0.2, "backlash": 0.2, "effort_hysteresis": 0.3}
"""More where a joint breaks away or lands: bristles creep before they slip, ends of a gap that are springs rebound;
and of an effort, which steps with every command, half a sample before or after."""
MOTION = {"motor_braking": "lift_and_drop", "effort_limit": "steps", "torque_speed_limit": "steps"}
"""What shows an effect that slow motions do not."""
TWO_LINKS = ("link_mass", "center_of_mass", "payload", "link_inertia", "voltage_sag", "base_tilt", "joint_offset")
ONLY = {"derivative_lag": "slide"}
PLACES = [
    *((e, "skew" if e in TWO_LINKS else ONLY.get(e, "pendulum")) for e in planted.EVERY),
    ("servo_rate", "geared"),
]


def case_folder(effect: str, kind: str, folder: Path) -> tuple[planted.Planted, str]:
    """A scenario with one recording without noise; returns the truth and the recording's name."""
    rng = np.random.default_rng(3)
    robot = robots.BUILDERS[kind](rng)
    while effect == "friction_ripple" and not robot.friction["coulomb"]:
        robot = robots.BUILDERS[kind](rng)
    run = Run(MOTION.get(effect, "sines"), "train", 5, 3.0)
    robot.quantum = 2e-4  # of which bristles give a fifth
    plants.measure(robot, [replace(run, motion="steps")], CLEAN)
    hidden = Hidden((Truth(effect, len(robot.joints) - 1, 1.0, 11),))
    plant, (told,), _ = hidden.plant(robot, run)
    entries = cases._write_runs(robot, [run], [plant], CLEAN, folder, rng)
    scenario = cases._scenario(Case("agreement", "single", kind), robot, CLEAN, entries)
    (folder / "robot.urdf").write_text(robot.urdf())
    (folder / "scenario.yaml").write_text(yaml.safe_dump(scenario))
    return told, Path(entries[0]["path"]).stem


@pytest.mark.parametrize(("effect", "kind"), [x for x in PLACES if x[0] in EFFECTS])
def test_the_truth_removes_its_own_gap(effect: str, kind: str, tmp_path: Path) -> None:
    told, name = case_folder(effect, kind, tmp_path)
    path = tmp_path / "scenario.yaml"
    measured = rg.read_run(path, name).trace
    added = {"effect": told.effect, "target": told.target, **told.parameters}

    def apart(effects: list[dict[str, Any]]) -> float:
        trace = rg.simulate(path, "mujoco", run=name, effects=effects, step_rate=4000).at(measured.time)
        signal = EFFECTS[effect].signals[0] if EFFECTS[effect].changes == "observation" else "position"
        return float(np.sqrt(np.mean((getattr(trace, signal) - getattr(measured, signal)) ** 2)))

    before, after = apart([]), apart([added])
    assert after < SUDDEN.get(effect, LEFT) * before, f"{added}: {before:.3g} -> {after:.3g}"
