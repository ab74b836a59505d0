"""What parts the rotor from the link is looked for where no rotor is stated: once its inertia is found."""

from pathlib import Path

import pytest
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import acting, suspects
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.data.worker import Query, answer
from realitygap.diagnose.search.search import search
from realitygap.scenario.schema import EffectSpec
from recorded_joint import recorded

ROTOR, STIFFNESS, ANGLE = 0.22, 1500.0, 0.01
"""kg·m², N·m/rad and rad: a geared drive of an arm's joint, soft (Taghirad, Bélanger 1998) or with play."""
SERVO = {"kind": "pid", "kp": 700.0, "kd": 25.0}
"""Without the armature of its motor."""
ROTOR_MISSING = EffectSpec(effect="rotor_inertia", target="*", armature=ROTOR)
BEHIND = {
    "joint_compliance": EffectSpec(effect="joint_compliance", target="*", stiffness=STIFFNESS),
    "backlash": EffectSpec(effect="backlash", target="*", angle=ANGLE),
}
"""Effects between rotor and link."""


def test_they_are_suspected_and_act_beside_a_rotor_only(tmp_path: Path) -> None:
    problem = recorded(tmp_path, SERVO, ROTOR_MISSING)
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
    problem, planted = recorded(tmp_path, SERVO, ROTOR_MISSING, BEHIND[effect]), BEHIND[effect].parameters
    with Simulations(problem, 2) as simulations:
        found = search(simulations, suspects(problem), [], lambda _: None)
    named = {c.suspect.effect: c.parameters for c in found.best.fit.changes}
    assert set(named) == {"rotor_inertia", effect}
    assert named["rotor_inertia"]["armature"] == pytest.approx(ROTOR, rel=0.05)
    assert {n: named[effect][n] for n in planted} == pytest.approx(planted, rel=0.1)
