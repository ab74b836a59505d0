"""First guesses of suspects."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from demo_problem import suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import fitted, suspects
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.demanded import demanded
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.linear import linear_at
from realitygap.robot.effects import EFFECTS, Effect, Parameter
from realitygap.robot.effects.place import place
from realitygap.scenario.schema import EffectSpec
from recorded_joint import recorded

OPTIONAL = [(e, p) for e in EFFECTS.values() for p in e.parameters if p.default is not None and p not in fitted(e)]


@pytest.mark.parametrize(("effect", "shape"), OPTIONAL, ids=lambda x: x.name)
def test_what_a_model_has_of_an_effect_stays_where_it_is_not_fitted(
    effect: Effect, shape: Parameter, problem: Problem
) -> None:
    usual = shape.default
    assert usual is not None
    own = 0.7 * usual if usual and np.isfinite(usual) else min(0.3, 0.5 * shape.high)
    values = {p.name: p.first for p in effect.parameters if p.default is None}
    spec = EffectSpec(effect=effect.name, target="elbow", **(values | {shape.name: own}))
    again = replace(problem, plant=place(problem.plant, [spec]))
    (suspect,) = [s for s in suspects(again) if s.effect == effect.name and str(s.target) == "elbow"]
    assert guess(problem, suspect).parameters[shape.name] == usual
    assert guess(again, suspect).parameters[shape.name] == own


@pytest.mark.parametrize(("stiffness", "rest"), [(8.0, 0.6), (8.0, -1.5)])
def test_a_spring_is_begun_with_where_it_rests(stiffness: float, rest: float, tmp_path: Path) -> None:
    """By its stiffness about zero alone straight lines promised the lesser part of what it does."""
    servo = {"kind": "pid", "kp": 300.0, "kd": 25.0, "armature": 0.2}
    problem = recorded(tmp_path, servo, EffectSpec(effect="cable_spring", target="*", stiffness=stiffness, rest=rest))
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [])
        nothing = Fit((), demanded(simulations, (), criterion.train))
        blocks = criterion.responses(nothing, [suspect_of(problem, "cable_spring", "lift")])
        at_zero, anywhere = (linear_at(criterion.plain(nothing), blocks).gain_of(i) for i in range(2))
    assert anywhere.change.parameters == pytest.approx({"stiffness": stiffness, "rest": rest}, rel=0.1)
    assert anywhere.gain > 1.2 * at_zero.gain
