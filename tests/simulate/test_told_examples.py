"""The bundled examples of robots that are told efforts or velocities, or followed: what was planted explains them."""

from pathlib import Path

import numpy as np
import pytest
from realitygap.scenario.file import load_scenario
from realitygap.scenario.schema import EffectSpec
from realitygap.simulate.experiment import experiments, simulate

SCENARIOS = Path(__file__).parents[2] / "scenarios"
FRICTION = EffectSpec(effect="coulomb_friction", target="elbow", torque=0.15)
GAIN = EffectSpec(effect="controller_gain", target="turn", gain=1.1)


@pytest.mark.parametrize(
    ("name", "planted", "signal", "joint"),
    [
        ("effort_driven/scenario", FRICTION, "position", "elbow"),
        ("effort_driven/measured", FRICTION, "position", "elbow"),
        ("effort_driven/followed", FRICTION, "effort", "elbow"),
        ("velocity_driven/scenario", GAIN, "position", "turn"),
    ],
)
def test_what_was_planted_explains_the_recordings(name: str, planted: EffectSpec, signal: str, joint: str) -> None:
    file = load_scenario(SCENARIOS / f"{name}.yaml")
    gaps = []
    for effects in ((), (planted,)):
        found = []
        for e in experiments(file, effects=effects):
            assert e.recording is not None
            measured = e.recording.trace
            trace, j = simulate(e, "mujoco").trace.at(measured.time), measured.index(joint)
            found.append(float(np.mean(np.abs(getattr(trace, signal) - getattr(measured, signal))[:, j])))
        gaps.append(max(found))
    assert gaps[1] < (0.5 if signal == "effort" else 0.1) * gaps[0]
