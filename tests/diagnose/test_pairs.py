"""Two laws in the place of one finding, and moves by two steps, on recordings of the bundled demo (synthetic)."""

from dataclasses import replace

from demo_problem import demo_problem, planted, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.changes import Change, model_key
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.judge.advice import experiment
from realitygap.diagnose.result.diagnosis import _listed, why
from realitygap.diagnose.result.story_text import rival_label
from realitygap.diagnose.search.ahead import by_two_steps
from realitygap.diagnose.search.pairs import pairs_for
from realitygap.diagnose.search.rivals import LOOKED, Place, Rival, rivals_of
from realitygap.diagnose.search.round import Round
from realitygap.diagnose.search.search import needed

LENGTH = 0.1115
"""From the elbow to the forearm's centre of mass [m]."""


def of(bare: Problem, effect: str, target: str, **values: float) -> Change:
    return guess(bare, suspect_of(bare, effect, target)).at(values)


def stood(simulations: Simulations, at: list[Change], others: list[Change]) -> Round:
    left = residual(simulations, [], simulations.problem.of("train"))
    assert left is not None
    everyone = [c.suspect for c in [*at, *others]]
    return Round(simulations, Fit(tuple(at), left), everyone, needed(len(everyone)), Fit((), left), print)


def test_a_pair_is_told_that_does_what_one_finding_with_two_values_does() -> None:
    """Of a forearm the zero of the elbow and the inertia about it are most of what another centre of mass changes."""
    bare = demo_problem()
    missing = [of(bare, "joint_offset", "elbow", angle=0.05), of(bare, "link_inertia", "forearm", scale=1.15)]
    wrong = of(bare, "center_of_mass", "forearm", x=0.05 * LENGTH, y=0.0, z=-1.03 * LENGTH)
    dry, heavy = of(bare, "coulomb_friction", "elbow", torque=0.1), of(bare, "link_mass", "forearm", mass=0.3)
    others = [*missing, dry, of(bare, "torque_constant", "elbow", torque_constant=2.0), heavy]
    with Simulations(planted(*missing), 2) as simulations:
        round_ = stood(simulations, [wrong], others)
        (finding,) = round_.now.fit.changes
        alone = round_.adjusted([], round_.now.fit)
        assert alone is not None
        place = Place.of(round_, finding, alone, late=False, looked=LOOKED)
        near = rivals_of(place, [])
        (pair,) = pairs_for(place, near)
        assert set(pair.suspects) == {c.suspect for c in missing}
        assert pair.scored.evidence > max(n.scored.evidence for n in near)
        assert pairs_for(replace(place, change=dry), near) == [], "a finding with one value"


def test_a_pair_is_told_as_two_that_stand_there_together() -> None:
    bare = demo_problem()
    one, other = (suspect_of(bare, *s) for s in (("joint_offset", "elbow"), ("link_inertia", "forearm")))
    with Simulations(bare, 2) as simulations:
        scored = stood(simulations, [], []).now
    rival = Rival(one, scored, -0.5, 1.0, other)
    tilt, mass = (suspect_of(bare, *s) for s in (("base_tilt", "base"), ("center_of_mass", "forearm")))
    assert "turn the robot by 180°" in experiment({mass: [(other, tilt)]})
    assert experiment({mass: [(other,)]}).startswith(f"{mass} or {other}: a motion with another load, another gain")
    assert "gain" not in experiment({mass: [(other,)]}, followed=True)
    assert rival_label(rival) == "joint offset at elbow and link inertia at forearm"
    assert why(rival) == "fitted in its place, they explain the recordings as well"
    assert why(rival, one).startswith("fitted in its place beside link_inertia at forearm, it explains")
    assert "they make the recordings 7" in why(replace(rival, behind=2.0))
    assert rival.suspects == (one, other)
    alone = [
        Rival(suspect_of(bare, e, "elbow"), scored, b, 1.0) for e, b in (("coulomb_friction", 0.9), ("dead_band", 9))
    ]
    assert _listed([rival, *alone]) == [alone[0], rival], "pairs last, and what is far behind not at all"
    assert _listed([rival, alone[0], replace(alone[0], suspect=mass)]) == [alone[0], replace(alone[0], suspect=mass)]
    assert replace(rival, beside=None).suspects == (one,)


def test_two_steps_lead_through_what_gains_too_little_alone() -> None:
    """Beside a delay that was refused a spring is found; through what is not missing nothing is."""
    bare = demo_problem()
    missing = [of(bare, "command_delay", "elbow", time=0.03), of(bare, "joint_compliance", "elbow", stiffness=15.0)]
    wrong = of(bare, "controller_gain", "shoulder", gain=5.05)
    with Simulations(planted(*missing), 2) as simulations:
        round_ = stood(simulations, [], [*missing, wrong])
        assert by_two_steps(round_, [], set()) is None, "nothing came near"
        step, away = (round_.criterion.fit([c]) for c in (missing[0], wrong))
        assert step is not None
        assert away is not None
        round_.near = [step]
        both = by_two_steps(round_, [], set())
        assert both is not None
        assert by_two_steps(round_, [], {model_key(both.fit.changes)}) is None, "where the search has been"
        assert {c.suspect for c in both.fit.changes} == {c.suspect for c in missing}
        stood_there = stood(simulations, list(both.fit.changes), [wrong])
        stood_there.near = [away]
        assert by_two_steps(stood_there, [], set()) is None
