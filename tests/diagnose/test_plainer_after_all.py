"""What a search had no time to ask: whether a plainer name says as much, on the bundled demo (synthetic)."""

from dataclasses import replace
from pathlib import Path

import pytest
import recorded_joint
from demo_problem import demo_problem, planted, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge import plainer as plainer_module
from realitygap.diagnose.judge.held_out import Verdict
from realitygap.diagnose.judge.joined import joined
from realitygap.diagnose.judge.plainer import plainer
from realitygap.diagnose.judge.renamed import retold
from realitygap.diagnose.search.alike import in_place
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.found import Found
from realitygap.diagnose.search.rivals import Rival
from realitygap.robot.effort_map import Table
from realitygap.scenario.schema import EffectSpec


@pytest.mark.parametrize(("forward", "backward"), [(0.60, 0.61), (0.35, 0.85)])
def test_friction_that_hardly_differs_by_side_is_dry_friction(forward: float, backward: float) -> None:
    bare = demo_problem()
    sides, dry = (suspect_of(bare, e, "elbow") for e in ("direction_friction", "coulomb_friction"))
    missing = guess(bare, sides).at({"forward": forward, "backward": backward})
    problem = planted(missing)
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [missing])
        best = criterion.fit([missing])
        alone = criterion.fit([])
        assert best is not None
        assert alone is not None
        criterion.set_discrepancy(
            best.fit, criterion.responses(best.fit, [s for s in suspects(problem) if s.target == "elbow"])
        )
        best, alone = criterion.score(best.fit), criterion.score(alone.fit)
        gains, without = {sides: best.evidence - alone.evidence}, {sides: alone}
        found = Found(alone, best, best, 6.0, {sides: 7.0}, criterion.floors, criterion, gains, without)
        kept = plainer(simulations, found, suspects(problem), [sides])
        told = plainer(simulations, found, suspects(problem), [])
    assert kept is found, "what the recordings tell by themselves"
    if backward - forward > 0.1:
        assert told is found
        return
    (change,) = told.best.fit.changes
    assert change.suspect == dry
    assert change.parameters["torque"] == pytest.approx(0.5 * (forward + backward), rel=0.03)
    assert told.without == {dry: alone}
    assert told.gains[dry] == pytest.approx(told.best.evidence - alone.evidence)
    assert told.least == {sides: 7.0, dry: 7.0}
    assert [r.suspect for r in told.rivals[dry]] == [sides]


def test_an_effort_without_a_law_loses_its_place_to_a_law_that_makes_the_same_traces_or_explains_as_much() -> None:
    bare = demo_problem()
    oil = guess(bare, suspect_of(bare, "viscous_friction", "elbow")).at({"coefficient": 0.8})
    dry = suspect_of(bare, "coulomb_friction", "elbow")
    table = Table(("speed",), ((-8.0, 8.0),))
    unnamed = Suspect("effort_map", "elbow", (1,), table=table)
    line = Change(unnamed, tuple(zip(table.names, (6.4, -6.4), strict=True)), table.names)
    problem = planted(oil)
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [oil])
        fits = [criterion.fit(changes) for changes in ([line], [oil], [])]
        assert fits[0] is not None
        criterion.set_discrepancy(fits[0].fit, criterion.responses(fits[0].fit, [oil.suspect, dry]))
        best, law, none = (criterion.score(scored.fit) for scored in fits if scored is not None)
        gains, without = {unnamed: best.evidence - none.evidence}, {unnamed: none}
        found = Found(none, best, best, 6.0, {}, criterion.floors, criterion, gains, without)
        for behind, same in ((4.0, True), (4.0, False), (0.5, False)):
            rivals = {unnamed: [Rival(oil.suspect, law, behind, 4.0, same=same)]}
            told = plainer(simulations, replace(found, rivals=rivals), [oil.suspect, dry], [])
            (change,) = told.best.fit.changes
            lawful = same or behind < 1.0
            assert change.suspect == (oil.suspect if lawful else unnamed)
            if lawful:
                assert change.parameters["coefficient"] == pytest.approx(0.8, rel=0.02)
                assert [r.suspect for r in told.rivals[oil.suspect]] == [unnamed]


@pytest.mark.parametrize("behind", [1.0, -1.0])
def test_held_out_runs_do_not_keep_a_richer_name_that_training_runs_find_less_likely(
    monkeypatch: pytest.MonkeyPatch, behind: float
) -> None:
    """They judge what the training runs chose: a search may only not have come to the plain name."""
    bare = demo_problem()
    sides, dry = (suspect_of(bare, e, "elbow") for e in ("direction_friction", "coulomb_friction"))
    missing = guess(bare, sides).at({"forward": 0.60, "backward": 0.61})
    problem = planted(missing)
    monkeypatch.setattr(plainer_module, "predicted", lambda *_: Verdict(10.0, 1.0))
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [missing])
        best, plain = criterion.fit([missing]), criterion.fit([guess(bare, dry).at({"torque": 0.605})])
        assert best is not None
        assert plain is not None
        criterion.set_discrepancy(best.fit, criterion.responses(best.fit, [sides, dry]))
        likeliest = criterion.refined(criterion.score(plain.fit))
        assert likeliest is not None
        best = replace(criterion.score(best.fit), evidence=likeliest.evidence - behind)
        told = plainer(simulations, Found(best, best, best, 6.0, {}, criterion.floors, criterion), [dry], [])
    assert [c.suspect for c in told.best.fit.changes] == [dry if behind > 0.0 else sides]


def test_a_richer_name_is_compared_where_its_evidence_is_best() -> None:
    """Values as if laws were exact, or of before something was adjusted, may have less evidence than a plain name."""
    bare = demo_problem()
    sides, dry = (suspect_of(bare, e, "elbow") for e in ("direction_friction", "coulomb_friction"))
    missing = guess(bare, sides).at({"forward": 0.35, "backward": 0.85})
    problem = planted(missing)
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [missing])
        best, plain = criterion.fit([missing]), criterion.fit([guess(bare, dry).at({"torque": 0.6})])
        assert best is not None
        assert plain is not None
        criterion.set_discrepancy(best.fit, criterion.responses(best.fit, [sides, dry]))
        away = replace(criterion.score(best.fit), evidence=criterion.score(plain.fit).evidence - 100.0)
        found = Found(away, away, away, 6.0, {}, criterion.floors, criterion)
        assert plainer(simulations, found, [dry], []) is found


def test_the_models_without_another_finding_have_the_plain_name_too() -> None:
    """Where that finding goes afterwards, the richer name does not come back."""
    bare = demo_problem()
    sides, dry = (suspect_of(bare, e, "elbow") for e in ("direction_friction", "coulomb_friction"))
    oil = guess(bare, suspect_of(bare, "viscous_friction", "shoulder")).at({"coefficient": 1.2})
    missing = guess(bare, sides).at({"forward": 0.60, "backward": 0.61})
    problem = planted(missing, oil)
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [missing, oil])
        best, alone = criterion.fit([missing, oil]), criterion.fit([missing])
        assert best is not None
        assert alone is not None
        criterion.set_discrepancy(best.fit, criterion.responses(best.fit, suspects(problem)))
        best, alone = criterion.score(best.fit), criterion.score(alone.fit)
        found = Found(alone, best, best, 6.0, {}, criterion.floors, criterion, without={oil.suspect: alone})
        told = plainer(simulations, found, suspects(problem), [])
    assert {c.suspect for c in told.best.fit.changes} == {oil.suspect, dry}
    assert {c.suspect for c in told.without[oil.suspect].fit.changes} == {dry}
    assert told.gains[oil.suspect] == told.best.evidence - told.without[oil.suspect].evidence > 0.0


def test_what_does_most_of_what_a_finding_does_with_fewer_values_takes_its_place(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """As straight lines beside it tell: a load on a turntable does what its rotor does."""
    monkeypatch.setattr(recorded_joint, "LINK", recorded_joint.LINK.replace('axis xyz="0 1 0"', 'axis xyz="0 0 1"'))
    servo = {"kind": "pid", "kp": 30.0, "kd": 1.5, "armature": 0.05}
    problem = recorded_joint.recorded(tmp_path, servo, EffectSpec(effect="rotor_inertia", target="*", armature=0.09))
    of = {s.effect: s for s in suspects(problem)}
    load = guess(problem, of["payload"]).at({"mass": 1.0, "x": 0.2, "y": 0.0, "z": 0.0})
    load = replace(load, free=("mass", "x"))
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [load])
        best = criterion.fit([load])
        assert best is not None
        criterion.set_discrepancy(best.fit, criterion.responses(best.fit, suspects(problem)))
        best = criterion.score(best.fit)
        found = Found(best, best, best, 6.0, {load.suspect: 7.0}, criterion.floors, criterion)
        told = plainer(simulations, found, suspects(problem), [])
    (change,) = told.best.fit.changes
    same = {of["rotor_inertia"], of["link_inertia"]}
    assert change.suspect in same
    assert told.best.evidence > best.evidence, "a value less"
    rivals = [r.suspect for r in told.rivals[change.suspect]]
    assert set(rivals) >= {*same, load.suspect} - {change.suspect}


@pytest.mark.parametrize("adjusted", [False, True], ids=["both named", "the spring adjusted"])
def test_a_spring_beside_a_constant_effort_is_one_that_rests_elsewhere(adjusted: bool) -> None:
    bare = demo_problem()
    spring, effort = (guess(bare, suspect_of(bare, e, "elbow")) for e in ("cable_spring", "constant_effort"))
    problem = planted(spring.at({"stiffness": 1.0, "rest": 0.6}))
    with Simulations(problem, 2) as simulations:
        two = [spring.at({"stiffness": 1.0}), effort.at({"effort": 0.6})]
        criterion = Criterion(simulations, two)
        best = criterion.fit(two)
        assert best is not None
        criterion.set_discrepancy(
            best.fit, criterion.responses(best.fit, [s for s in suspects(problem) if s.target == "elbow"])
        )
        best = criterion.score(best.fit)
        found = Found(best, best, best, 6.0, {effort.suspect: 9.0}, criterion.floors, criterion)
        found = replace(found, adjusted=(spring.suspect,) if adjusted else ())
        kept = joined(simulations, found, [], [effort.suspect])
        told = joined(simulations, found, [], [])
    assert kept is found, "what the recordings tell by themselves"
    (change,) = told.best.fit.changes
    assert change.suspect == spring.suspect
    assert change.parameters == pytest.approx({"stiffness": 1.0, "rest": 0.6}, rel=0.05)
    assert told.adjusted == (), "what takes the place of a name is one"
    assert told.gains[spring.suspect] > 100.0
    assert told.least[spring.suspect] == 9.0
    assert [c.suspect for c in told.without[spring.suspect].fit.changes] == []


def test_a_heavier_link_of_more_inertia_is_a_load_at_its_end() -> None:
    bare = demo_problem()
    mass, inertia, load = (
        guess(bare, suspect_of(bare, e, "forearm")) for e in ("link_mass", "link_inertia", "payload")
    )
    friction = guess(bare, suspect_of(bare, "coulomb_friction", "shoulder"))
    problem = planted(load.at({"mass": 0.12, "x": 0.0, "y": 0.0, "z": -0.3}), friction)
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [friction, mass, inertia])
        best = criterion.fit([friction, mass, inertia])
        assert best is not None
        criterion.set_discrepancy(
            best.fit, criterion.responses(best.fit, [s for s in suspects(problem) if s.target in ("forearm", "elbow")])
        )
        best = criterion.score(best.fit)
        least = {friction.suspect: 7.0, mass.suspect: 9.0, inertia.suspect: 8.0}
        gains = {friction.suspect: 10.0}
        found = Found(best, best, best, 6.0, least, criterion.floors, criterion, gains)
        kept = joined(simulations, found, suspects(problem), [mass.suspect])
        told = joined(simulations, found, suspects(problem), [])
        blocks = criterion.responses(best.fit, [load.suspect])
        two = [c for c in best.fit.changes if c.suspect != friction.suspect]
        lines = in_place(criterion, best.fit, two, blocks)
    assert kept is found, "what the recordings tell by themselves"
    (same, change) = told.best.fit.changes
    assert same.suspect == friction.suspect
    assert change.suspect == load.suspect
    assert change.parameters["mass"] == pytest.approx(0.12, rel=0.1)
    assert change.parameters["z"] == pytest.approx(-0.3, rel=0.1)
    assert told.gains == {s: told.best.evidence - other.evidence for s, other in told.without.items()}
    assert set(told.gains) == {friction.suspect, load.suspect}, "the others are asked anew beside it"
    assert lines is not None
    assert lines.gain_of(0).change.parameters["z"] < 0.0, "straight lines lead to where the link lies"


def test_a_spring_that_rests_elsewhere_and_dry_friction_are_plainer_than_friction_by_side() -> None:
    bare = demo_problem()
    spring, sides, dry = (
        suspect_of(bare, e, "elbow") for e in ("cable_spring", "direction_friction", "coulomb_friction")
    )
    missing = (guess(bare, dry).at({"torque": 0.6}), guess(bare, spring).at({"stiffness": 0.8, "rest": 0.2}))
    problem = planted(*missing)
    begun = [
        guess(problem, spring).at({"stiffness": 0.8}),
        guess(problem, sides).at({"forward": 0.75, "backward": 0.45}),
    ]
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, begun)
        fits = [criterion.fit(changes) for changes in (begun, begun[1:], begun[:1], [])]
        assert fits[0] is not None
        criterion.set_discrepancy(fits[0].fit, criterion.responses(fits[0].fit, [spring, sides, dry]))
        best, no_spring, no_friction, none = (criterion.score(scored.fit) for scored in fits if scored is not None)
        without = {spring: no_spring, sides: no_friction}
        gains = {s: best.evidence - alone.evidence for s, alone in without.items()}
        found = Found(none, best, best, 6.0, {}, criterion.floors, criterion, gains, without)
        told = plainer(simulations, found, suspects(problem), [])
    values = {c.suspect: c.parameters for c in told.best.fit.changes}
    assert set(values) == {spring, dry}
    assert values[dry]["torque"] == pytest.approx(0.6, rel=0.03)
    assert values[spring]["stiffness"] == pytest.approx(0.8, rel=0.05)
    assert values[spring]["rest"] == pytest.approx(0.2, rel=0.1)
    assert [r.suspect for r in told.rivals[dry]] == [sides]


def test_a_mass_beside_another_centre_of_it_is_no_plainer_than_a_load() -> None:
    bare = demo_problem()
    mass, centre, load = (suspect_of(bare, e, "forearm") for e in ("link_mass", "center_of_mass", "payload"))
    sides, dry = (suspect_of(bare, e, "elbow") for e in ("direction_friction", "coulomb_friction"))
    beside = [guess(bare, centre)]
    assert plainer_module._in_parts(load, mass, beside)
    assert not plainer_module._in_parts(load, mass, [])
    assert not plainer_module._in_parts(sides, dry, beside)


def test_values_are_fitted_as_if_laws_were_exact_once_another_name_stands() -> None:
    """Models that are compared are where their evidence is best."""
    bare = demo_problem()
    dry, oil = (guess(bare, suspect_of(bare, e, "elbow")) for e in ("coulomb_friction", "viscous_friction"))
    problem = planted(dry.at({"torque": 0.6}))
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [dry])
        best, other = criterion.fit([dry.at({"torque": 0.5})], care="quick"), criterion.fit([oil])
        assert best is not None
        assert other is not None
        found = Found(best, best, best, 6.0, {}, criterion.floors, criterion, gains={dry.suspect: 9.0})
        assert retold(simulations, found, found) is found, "the same name"
        told = retold(simulations, found, replace(found, best=other))
        whole = criterion.fit(best.fit.changes, best.fit)
    assert whole is not None
    assert told.best.fit.changes == whole.fit.changes
    assert told.gains == found.gains, "as models were compared"
    assert told.cautious.fit.changes == whole.fit.changes
