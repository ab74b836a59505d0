"""Dry friction that builds up over an angle is told by its shape, and by no spring of the joint."""

from pathlib import Path

import pytest
from demo_problem import suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import building_up, richer
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.search.criterion import Criterion
from realitygap.scenario.schema import EffectSpec
from recorded_joint import recorded

SERVO = {"kind": "pid", "kp": 300.0, "kd": 12.0, "armature": 0.1}
TORQUE, OVER = 4.0, 3e-3


def test_friction_that_builds_up_is_no_compliance(tmp_path: Path) -> None:
    builds_up = EffectSpec(effect="coulomb_friction", target="lift", torque=TORQUE, presliding=OVER)
    problem = recorded(tmp_path, SERVO, builds_up)
    with Simulations(problem, 1) as simulations:
        criterion = Criterion(simulations, [])
        left = criterion.motions.residual([])
        assert left is not None
        criterion.set_effective_fraction(left)
        dry = guess(problem, suspect_of(problem, "coulomb_friction", "lift"))
        plain = criterion.fit([dry], Fit((), left), "compared")
        assert plain is not None
        begun = [richer(problem.plant, dry), building_up(problem.plant, dry)]
        assert [c and c.free for c in begun] == [("torque", "onset"), ("torque", "presliding")]
        grows, builds = (criterion.fit([c], plain.fit, "compared") for c in begun if c is not None)
        spring = guess(problem, suspect_of(problem, "joint_compliance", "lift"))
        gives = criterion.fit([*plain.fit.changes, spring], plain.fit, "compared")
    assert builds is not None
    values = builds.fit.changes[0].parameters
    assert values["torque"] == pytest.approx(TORQUE, rel=0.02)
    assert values["presliding"] == pytest.approx(OVER, rel=0.1)
    for other in (plain, grows, gives):
        assert other is None or builds.evidence > other.evidence + 20.0
