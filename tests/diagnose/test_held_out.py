"""Held-out runs of the bundled demo (synthetic) speak of every finding, after the model is chosen."""

from dataclasses import replace

import pytest
from demo_problem import FRICTION, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.changes import Change, Suspect, model_key
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.judge.held_out import CHOSE, Against, Verdict, _asked, _wider, certain_of, predicted, supported
from realitygap.diagnose.judge.worsened import InUnits
from realitygap.diagnose.likelihood.floors import measure
from realitygap.diagnose.result.not_named import held_out_against, vague
from realitygap.diagnose.result.workflow import _against_all
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.found import Found


@pytest.fixture(scope="module")
def found(problem: Problem, simulations: Simulations) -> Found:
    """The missing friction, and beside it an offset that the robot has not, as if training runs had shown it."""
    friction = Change(
        suspect_of(problem, "coulomb_friction", "elbow"),
        (("torque", FRICTION), ("onset", 0.0), ("presliding", 0.0)),
        ("torque",),
    )
    offset = guess(problem, suspect_of(problem, "joint_offset", "elbow")).at({"angle": 0.02})
    criterion = Criterion(simulations, [friction])

    def scored(*changes: Change) -> Scored:
        left = residual(simulations, changes, criterion.train)
        assert left is not None
        return criterion.score(Fit(changes, left))

    base, best = scored(), scored(friction, offset)
    without = {friction.suspect: scored(offset), offset.suspect: scored(friction)}
    floors = measure(simulations, best.fit.changes)
    gains = {s: best.evidence - other.evidence for s, other in without.items()}
    return Found(base, best, best, 6.0, dict.fromkeys(gains, 6.0), floors, criterion, gains=gains, without=without)


def test_a_finding_that_held_out_runs_speak_against_is_dropped_and_no_other(
    problem: Problem, simulations: Simulations, found: Found
) -> None:
    left, against = supported(simulations, found, [])
    assert [s.effect for s in against] == ["joint_offset"]
    assert max(a.verdict.gain for a in against.values()) < 0.0
    assert [c.suspect.effect for c in left.best.fit.changes] == ["coulomb_friction"]
    assert left.best.fit.value[0] == pytest.approx(FRICTION, rel=0.04)
    assert set(left.gains) == {suspect_of(problem, "coulomb_friction", "elbow")}
    assert left.gains[suspect_of(problem, "coulomb_friction", "elbow")] > 10.0
    assert predicted(simulations, left.floors, left.best.fit.changes).gain > 10.0


def test_what_held_out_runs_say_against_a_finding_counts_many_times(simulations: Simulations, found: Found) -> None:
    friction, offset = (c.suspect for c in found.best.fit.changes)
    changes, without = found.best.fit.changes, found.without[offset].fit.changes
    lost = -predicted(simulations, found.floors, changes, without).least
    assert lost > 0.0
    for gained, dropped in ((CHOSE * lost + 5.0, [offset]), (CHOSE * lost + 7.0, [])):
        gains = {friction: found.gains[friction], offset: gained}
        assert list(supported(simulations, replace(found, gains=gains), [])[1]) == dropped, "a name needs 6"


def test_what_held_out_runs_say_by_chance_speaks_for_nothing(simulations: Simulations, found: Found) -> None:
    friction, offset = (c.suspect for c in found.best.fit.changes)
    verdicts = [Verdict(3.1, error) for error in (20.3, 0.5)]
    by_chance, told = (Against(verdict, (1.4, 1.4), verdict) for verdict in verdicts)
    assert by_chance.weight == pytest.approx(CHOSE * (3.2 - 1.64 * 20.3))
    assert told.weight == pytest.approx(3.2 - 1.64 * 0.5)
    said = "with it held-out runs are 22 times more probable, "
    assert f"{said}which may be chance (in logarithms 3.1 ± 20.3)" in held_out_against(offset, by_chance)
    assert f"{said}and it explains less than laws leave" in held_out_against(friction, told)


def test_what_held_out_runs_do_not_show_is_not_named(problem: Problem, simulations: Simulations, found: Found) -> None:
    """A stop beyond the angles of the runs that were kept back, however much it gained on the others, and whatever they
    say of other values that are fitted without it.
    """
    (friction, _), far = found.best.fit.changes, {"lower": -60.0, "upper": 60.0}
    stop = guess(problem, suspect_of(problem, "joint_stop", "elbow")).at(far)
    best = replace(found.best, fit=replace(found.best.fit, changes=(friction, stop)))
    alone = replace(best, fit=replace(best.fit, changes=(friction.at({"torque": 1.2 * FRICTION}),)))
    reached = replace(found, best=best, without={stop.suspect: alone}, gains={stop.suspect: 100.0})
    told = _asked(simulations, reached, stop.suspect)
    assert told.silent
    assert abs(told.verdict.gain) > 1.0
    assert "shows on training runs only" in held_out_against(stop.suspect, told)
    left, against = supported(simulations, replace(reached, least={stop.suspect: 6.0}), [friction.suspect])
    assert list(against) == [stop.suspect]
    assert model_key(left.best.fit.changes) == model_key([friction])
    verdicts = [Verdict(3.0, 1.0), Verdict(-0.5, 0.0)]
    assert not any(Against(verdict, (1.4, 1.4), verdict).silent for verdict in verdicts)


def test_what_widens_the_gap_is_not_named_however_probable_it_makes_the_runs(
    simulations: Simulations, found: Found
) -> None:
    friction = found.best.fit.changes[0]
    for torque, widens in ((FRICTION, False), (2.0, True)):
        fit = replace(found.best.fit, changes=(friction.at({"torque": torque}),))
        alone = replace(found, best=replace(found.best, fit=fit), without={friction.suspect: found.base})
        told = _asked(simulations, alone, friction.suspect)
        assert told.widens == widens
        assert ("widens the held-out gap, from" in held_out_against(friction.suspect, told)) == widens
        against = _against_all(simulations, found, fit.changes, Verdict(50.0, 1.0), [])
        assert ("widens the held-out gap" in against) == widens


def test_held_out_runs_have_to_speak_for_what_was_found_beyond_how_they_scatter(
    simulations: Simulations, found: Found
) -> None:
    changes = found.without[found.best.fit.changes[1].suspect].fit.changes
    said = {v: _against_all(simulations, found, changes, v, []) for v in (Verdict(8.2, 5.7), Verdict(-8.2, 0.1))}
    found_there = "with what was found on training runs, held-out runs are 3641 times "
    assert list(said.values()) == [
        f"{found_there}more probable, which may be chance (in logarithms 8.2 ± 5.7): nothing is named",
        f"{found_there}less probable (in logarithms -8.2 ± 0.1): nothing is named",
    ]
    for told in (Verdict(8.2, 4.0), Verdict(0.0, 0.0)):
        assert not _against_all(simulations, found, changes, told, [])


def test_a_wider_gap_speaks_against_nothing_that_brings_every_signal_closer(
    simulations: Simulations, found: Found
) -> None:
    wrong = found.best.fit.changes[0].at({"torque": 2.0})
    closer, further = InUnits("position", "deg", 0.73, 0.71), InUnits("velocity", "deg/s", 3.2, 3.3)

    def against(*units: InUnits) -> str:
        return _against_all(simulations, found, [wrong], Verdict(50.0, 1.0), units)

    assert "widens the held-out gap" in against(closer, further)
    assert not against(closer, replace(further, after=2.6))


def test_what_takes_signals_further_off_on_the_whole_is_not_named(simulations: Simulations, found: Found) -> None:
    position, velocity = InUnits("position", "deg", 1.08, 1.33), InUnits("velocity", "deg/s", 17.8, 17.9)
    changes = found.without[found.best.fit.changes[1].suspect].fit.changes

    def against(*units: InUnits) -> str:
        return _against_all(simulations, found, changes, Verdict(50.0, 1.0), units)

    for after in (17.9, 17.7, 15.0):
        said = against(position, replace(velocity, after=after))
        assert f"further off on the whole (position from 1.08 to 1.33°, velocity from 17.8 to {after:.3g}" in said
    assert not against(position, replace(velocity, after=14.0))
    assert not against()


def test_what_the_recordings_told_stays(problem: Problem, simulations: Simulations, found: Found) -> None:
    offset = suspect_of(problem, "joint_offset", "elbow")
    left, against = supported(simulations, replace(found), [offset])
    assert not against
    assert left.best is found.best


def test_a_finding_needs_that_all_runs_together_say_enough_for_it(simulations: Simulations, found: Found) -> None:
    friction, offset = (c.suspect for c in found.best.fit.changes)
    without = found.without[friction].fit.changes
    together = found.gains[friction] + predicted(simulations, found.floors, found.best.fit.changes, without).least
    assert not supported(simulations, replace(found, least={friction: together - 1.0}), [offset])[1]
    assert list(supported(simulations, replace(found, least={friction: together + 1.0}), [offset])[1]) == [friction]


def test_what_held_out_runs_speak_for_beside_all_that_was_found_is_not_asked_again(
    simulations: Simulations, found: Found
) -> None:
    friction, offset = (c.suspect for c in found.best.fit.changes)
    poor = replace(found, gains={friction: 1e9, offset: found.gains[offset]}, least={friction: 1e6, offset: 6.0})
    left, against = supported(simulations, poor, [])
    assert list(against) == [offset]
    assert left.gains[friction] < poor.least[friction]


def test_a_finding_is_not_named_where_its_interval_holds_what_the_model_has(
    problem: Problem, simulations: Simulations, found: Found
) -> None:
    friction, offset = found.best.fit.changes
    best = found.criterion.fit([friction, offset])
    assert best is not None
    vague = replace(found, best=best, cautious=found.criterion.cautious(best.fit), gains={}, without={})
    left, dropped = certain_of(simulations, vague, [])
    assert dropped == [offset.suspect], "the robot has none"
    assert left.fuller is best, "what it was found beside is adjusted from there"
    assert model_key(left.best.fit.changes) == model_key([friction])
    assert certain_of(simulations, vague, [offset.suspect]) == (vague, [])


def test_others_are_told_beside_what_is_adjusted_only_where_there_are_some() -> None:
    friction, gain = Suspect("coulomb_friction", "elbow", (1,)), Suspect("controller_gain", "elbow", (1,))
    assert "others" not in vague(friction, {friction})
    assert "before others were adjusted beside it" in vague(friction, {friction, gain})
    assert "adjusted" not in vague(friction, {gain})


def test_an_interval_is_as_wide_as_a_value_moved_by_what_is_not_named(found: Found) -> None:
    friction = found.best.fit.changes[0]
    own = found.criterion.fit([friction])
    assert own is not None
    elsewhere = replace(own.fit, changes=(own.fit.changes[0].at({"torque": float(own.fit.value[0]) + 0.3}),))
    assert _wider(own, own.fit).deviation[0] <= own.deviation[0] < 0.2
    assert _wider(own, elsewhere).deviation[0] == pytest.approx(0.3, rel=0.1)


def test_a_verdict_is_what_stretches_leave_of_a_gain() -> None:
    """An error of 1 leaves 1.64 less, and what changes nothing may seem to gain or lose 0.1."""
    told = {1.5: (True, False), 1.6: (False, False), 1.7: (False, False), 1.8: (False, True)}
    assert {gain: (Verdict(gain, 1.0).worse, Verdict(gain, 1.0).better) for gain in told} == told


@pytest.mark.parametrize(
    ("alone", "gaps", "silent", "widens"),
    [
        (Verdict(-0.05, 0.04), (0.5, 1.19), True, False),
        (Verdict(0.05, 0.06), (0.5, 1.21), False, True),
        (Verdict(0.11, 0.0), (2.0, 2.39), False, False),
        (Verdict(0.0, 0.0), (2.0, 2.41), True, True),
    ],
)
def test_what_says_nothing_is_silent_and_what_is_below_the_floor_is_no_wider(
    alone: Verdict, gaps: tuple[float, float], silent: bool, widens: bool
) -> None:
    told = Against(Verdict(5.0, 1.0), gaps, alone)
    assert (told.silent, told.widens) == (silent, widens)
