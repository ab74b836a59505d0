"""First guesses of suspects."""

from dataclasses import replace

import numpy as np
import pytest
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import fitted, suspects
from realitygap.diagnose.data.problem import Problem
from realitygap.robot.effects import EFFECTS, Effect, Parameter
from realitygap.robot.effects.place import place
from realitygap.scenario.schema import EffectSpec

OPTIONAL = [(e, p) for e in EFFECTS.values() for p in e.parameters if p.default is not None and p not in fitted(e)]


@pytest.mark.parametrize(("effect", "shape"), OPTIONAL, ids=lambda x: x.name)
def test_what_a_model_has_of_an_effect_stays_where_it_is_not_fitted(
    effect: Effect, shape: Parameter, problem: Problem
) -> None:
    usual = shape.default
    assert usual is not None
    own = 0.7 * usual if usual and np.isfinite(usual) else 0.3
    values = {p.name: p.first for p in effect.parameters if p.default is None}
    spec = EffectSpec(effect=effect.name, target="elbow", **(values | {shape.name: own}))
    again = replace(problem, plant=place(problem.plant, [spec]))
    (suspect,) = [s for s in suspects(again) if s.effect == effect.name and str(s.target) == "elbow"]
    assert guess(problem, suspect).parameters[shape.name] == usual
    assert guess(again, suspect).parameters[shape.name] == own
