"""One law in the place of two, on the bundled demo (synthetic)."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from demo_problem import suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.changes import Change, ModelKey, model_key
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.search.merged import merged
from realitygap.diagnose.search.round import Round
from realitygap.diagnose.search.search import needed

STIFFNESS, EFFORT = 0.4, 0.1
LIMIT = 7.0


def test_a_spring_takes_the_place_of_one_at_zero_beside_a_constant_effort(
    problem: Problem, simulations: Simulations
) -> None:
    spring = guess(problem, suspect_of(problem, "cable_spring", "elbow")).at({"stiffness": STIFFNESS})
    effort = guess(problem, suspect_of(problem, "constant_effort", "elbow")).at({"effort": EFFORT})
    elsewhere = guess(problem, suspect_of(problem, "constant_effort", "shoulder"))
    both, train = [spring, effort, elsewhere], problem.of("train")
    left, nothing = residual(simulations, both, train), residual(simulations, [], train)
    assert left is not None
    assert nothing is not None
    everyone = [c.suspect for c in both]
    round_ = Round(simulations, Fit(tuple(both), left), everyone, needed(3), Fit((), nothing), print)
    round_.now = replace(round_.now, fit=replace(round_.now.fit, changes=tuple(both)))

    ((way, needs),) = merged(round_)
    assert needs == -round_.limit
    assert model_key(way) == model_key([elsewhere, replace(spring, free=("stiffness", "rest"))])

    alone = [elsewhere, way[-1].at({"rest": EFFORT / STIFFNESS})]
    other = residual(simulations, alone, train)
    assert other is not None
    assert other == pytest.approx(left, abs=1e-9, nan_ok=True), "−k·(q − rest) is −k·q and a constant k·rest"
    assert np.nanmax(np.abs(other - nothing)) > 1e-3

    round_.now = replace(round_.now, fit=replace(round_.now.fit, changes=tuple(alone)))
    assert not merged(round_), "its shape is free already"


def test_springs_of_several_joints_take_the_place_of_a_payload_together(
    problem: Problem, simulations: Simulations
) -> None:
    springs = [guess(problem, suspect_of(problem, "cable_spring", j)) for j in ("shoulder", "elbow")]
    payload = guess(problem, suspect_of(problem, "payload", "forearm"))
    found = SimpleNamespace(fit=SimpleNamespace(changes=(*springs, payload)))
    ways = merged(cast("Round", SimpleNamespace(now=found, simulations=simulations, limit=LIMIT)))
    shaped = [replace(c, free=("stiffness", "rest")) for c in springs]
    assert [model_key(way) for way, _ in ways] == [model_key([springs[0], shaped[1]]), model_key(shaped)]
    assert {needs for _, needs in ways} == {-LIMIT}


def test_friction_that_builds_up_takes_the_place_of_friction_and_what_gives_way_at_its_joint(
    problem: Problem, simulations: Simulations
) -> None:
    dry, by_side, soft, spring = (
        guess(problem, suspect_of(problem, name, joint))
        for name, joint in (
            ("coulomb_friction", "elbow"),
            ("direction_friction", "shoulder"),
            ("joint_compliance", "elbow"),
            ("cable_spring", "elbow"),
        )
    )

    def ways(*changes: Change) -> list[ModelKey]:
        found = SimpleNamespace(fit=SimpleNamespace(changes=changes))
        tried = merged(cast("Round", SimpleNamespace(now=found, simulations=simulations, limit=LIMIT)))
        return [model_key(way) for way, _ in tried if any("presliding" in c.free for c in way)]

    builds = replace(dry, free=("torque", "presliding"))
    assert ways(dry, by_side, soft) == [model_key([by_side, builds])]
    everywhere = guess(problem, suspect_of(problem, "joint_compliance", "*"))
    assert ways(dry, everywhere) == [model_key([builds])], "what gives way may do so at more joints"
    assert ways(dry, by_side, spring) == [], "a cable is no gear"
    assert ways(by_side, soft) == [], "at another joint"
    assert ways(builds, soft) == [model_key([builds])], "what gives way beside it is asked about again"
