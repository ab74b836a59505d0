"""A servo whose D acts on the measured speed alone moves as one that is late by kd/kp, and is told so."""

from typing import Any

import numpy as np
import pytest
import realitygap as rg
import yaml
from demo_problem import DEMO, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.problem import build_problem
from realitygap.diagnose.result.derivative_on_speed import derivative_on_speed

KP, KD = 40.0, 0.8
PID = {"kind": "pid", "kp": KP, "kd": KD}


def with_servo(servo: dict[str, Any], *effects: dict[str, Any]) -> rg.ScenarioFile:
    """The demo with servos of another kind, which follow its commands as samples of a trajectory."""
    content = yaml.safe_load(DEMO.read_text(encoding="utf-8"))
    content["servos"] = [{"joints": "*"} | servo]
    content["motion"]["held"] = False
    return rg.load_scenario(content | {"effects": list(effects)}, DEMO.parent)


@pytest.mark.parametrize(
    ("low", "high", "more", "told"),
    [(0.015, 0.025, {}, True), (0.025, 0.03, {}, False), (0.015, 0.025, {"ki": 1.0}, False)],
)
def test_a_delay_of_kd_over_kp_may_be_a_derivative_on_the_speed_alone(
    low: float, high: float, more: dict[str, float], told: bool
) -> None:
    problem = build_problem(with_servo(PID | more), "mujoco")
    delay, oil = (guess(problem, suspect_of(problem, e, "*")) for e in ("command_delay", "viscous_friction"))
    mass = guess(problem, suspect_of(problem, "link_mass", problem.plant.model.links[-1].name))
    said = derivative_on_speed(problem, [oil, mass, delay], lambda *_: (low, high))
    assert len(said) == told
    if told:
        assert "kd/kp, 0.0200 s" in said[0]
        assert "with gain 0.800, kv 1 and kp 50.0" in said[0]


def test_the_servo_that_it_proposes_moves_as_one_that_is_late() -> None:
    """Of what parts a D on the error from one on the speed, the delay leaves a tenth where nothing is fast."""
    late = {"effect": "command_delay", "target": "*", "time": KD / KP}
    proposed = with_servo({"kind": "cascade", "gain": KD, "kv": 1.0, "kp": KP / KD})
    own, delayed = with_servo(PID), with_servo(PID, late)
    a, b, c = (rg.simulate(s, "mujoco", run="triangle_1") for s in (proposed, own, delayed))
    apart, left = (float(np.std(t.position - a.position)) for t in (b, c))
    assert left < 0.1 * apart
