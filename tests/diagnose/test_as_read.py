"""What depends on a joint's angle turns with the joint's zero in a model, on the bundled demo (synthetic)."""

import math

import pytest
from demo_problem import demo_problem, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.changes import as_read


def test_what_stood_before_turns_with_a_zero_that_comes_or_goes() -> None:
    problem = demo_problem()
    ripple, friction, offset = (
        guess(problem, suspect_of(problem, name, "elbow"))
        for name in ("torque_ripple", "coulomb_friction", "joint_offset")
    )
    ripple, offset = ripple.at({"periods": 20.0, "phase": 0.5}), offset.at({"angle": 0.2})
    before = [ripple, friction]
    turned, *others = as_read([*before, offset], before, problem.plant)
    assert others == [friction, offset]
    assert turned.parameters["phase"] == pytest.approx(math.remainder(0.5 - 20.0 * 0.2, 2.0 * math.pi))
    back, kept = as_read([turned, friction], [turned, friction, offset], problem.plant)
    assert back.parameters["phase"] == pytest.approx(0.5)
    assert kept == friction
    assert as_read([ripple, offset], [friction], problem.plant) == [ripple, offset]
    shoulder = guess(problem, suspect_of(problem, "joint_offset", "shoulder"))
    assert as_read([ripple, shoulder], [ripple], problem.plant) == [ripple, shoulder]
