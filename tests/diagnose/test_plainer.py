"""A name says no more than it has to, on recordings of the bundled demo (synthetic) with planted effects."""

from dataclasses import replace

import pytest
from demo_problem import FRICTION, demo_problem, suspect_of
from realitygap.diagnose.data.changes import Change, Suspect, model_key
from realitygap.diagnose.result.diagnosis import why
from realitygap.diagnose.search.exchange import Exchanged, _plainer, exchanged
from realitygap.diagnose.search.rivals import ODDS, Rival
from realitygap.diagnose.search.simpler import limits, narrower
from realitygap.robot.effort_map import Table
from stood import Effects, stood


def _creeping(more: float) -> Effects:
    """Friction that is so much more at creeping."""
    values = {"static": more * FRICTION, "coulomb": FRICTION, "velocity": 0.3, "exponent": 2.0}
    return {("stribeck_friction", "elbow"): values}


@pytest.mark.parametrize(("more", "named"), [(1.12, "coulomb_friction"), (2.0, "stribeck_friction")])
def test_what_laws_are_off_by_is_not_told_by_a_name_that_says_more(more: float, named: str) -> None:
    """Friction that is 12 % more at creeping is dry friction, whichever of both was found."""
    dry: Effects = {("coulomb_friction", "elbow"): {"torque": FRICTION}}
    for found, other in ((_creeping(more), "coulomb_friction"), (dry, "stribeck_friction")):
        at = stood(_creeping(more), found, [(other, "elbow"), ("viscous_friction", "shoulder")])
        with at.simulations:
            out = exchanged(at.round_, [], Exchanged())
        better = at.round_.now if out.better is None else out.better
        assert [c.suspect.effect for c in better.fit.changes] == [named]
        assert out.plainer == (found is not dry and named == "coulomb_friction")
        if named == "coulomb_friction" and found is dry:
            (rival,) = (r for of in out.rivals.values() for r in of if r.suspect.effect == "stribeck_friction")
            assert rival.behind < -ODDS, "the recordings do tell it"
            assert "better" in why(rival)


def test_an_effort_over_speed_that_does_what_viscous_friction_does_is_that() -> None:
    """Though a law is less likely beforehand, an effort that no law explains is none that one explains."""
    missing: Effects = {("viscous_friction", "elbow"): {"coefficient": 0.8}}
    table = Table(("speed",), ((-8.0, 8.0),))
    suspect = Suspect("effort_map", "elbow", (1,), table=table)
    line = Change(suspect, tuple(zip(table.names, (6.4, -6.4), strict=True)), table.names)
    at = stood(missing, [line], [("coulomb_friction", "elbow")])
    with at.simulations:
        out = exchanged(at.round_, [], Exchanged())
        assert _plainer(at.round_, replace(law := _law(out), behind=2.0 * ODDS), suspect, out.without[suspect])
        assert not _plainer(at.round_, replace(law, behind=2.0 * ODDS, same=False), suspect, out.without[suspect])
    assert law.same
    assert out.better is not None
    assert model_key(out.better.fit.changes) == at.right


def _law(out: Exchanged) -> Rival:
    (rival,) = (r for of in out.rivals.values() for r in of if r.suspect.effect == "viscous_friction")
    return rival


def test_a_spring_that_rests_elsewhere_is_one_finding() -> None:
    """Not a spring and a constant effort; straight lines tell those."""
    missing: Effects = {("cable_spring", "elbow"): {"stiffness": 1.0, "rest": 0.6}}
    wrong: Effects = {("cable_spring", "elbow"): {"stiffness": 1.0}, ("constant_effort", "elbow"): {"effort": 0.6}}
    at = stood(missing, wrong, [("viscous_friction", "shoulder")])
    with at.simulations:
        better = exchanged(at.round_, [], Exchanged()).better
    assert better is not None
    (spring,) = better.fit.changes
    assert spring.suspect.effect == "cable_spring"
    assert spring.parameters == pytest.approx({"stiffness": 1.0, "rest": 0.6}, rel=0.05)


def test_a_line_over_speed_that_no_speed_reaches_is_a_limit_of_the_effort() -> None:
    missing: Effects = {("effort_limit", "elbow"): {"effort": 3.0}}
    wrong: Effects = {("torque_speed_limit", "elbow"): {"stall_torque": 3.0, "no_load_speed": 250.0}}
    at = stood(missing, wrong, [("viscous_friction", "shoulder")])
    with at.simulations:
        better = exchanged(at.round_, [], Exchanged()).better
    assert better is not None
    assert model_key(better.fit.changes) == at.right


def test_a_narrower_name_is_a_special_case_of_the_same_law_there() -> None:
    problem = demo_problem()
    dry, slow, heavy, line, effort = (
        suspect_of(problem, *at)
        for at in (
            ("coulomb_friction", "elbow"),
            ("stribeck_friction", "elbow"),
            ("payload", "forearm"),
            ("torque_speed_limit", "elbow"),
            ("effort_limit", "elbow"),
        )
    )
    assert narrower(dry, slow)
    assert not narrower(slow, dry)
    assert not narrower(dry, suspect_of(problem, "stribeck_friction", "shoulder"))
    assert not narrower(dry, heavy)
    assert not narrower(suspect_of(problem, "viscous_friction", "elbow"), slow)
    assert narrower(suspect_of(problem, "link_mass", "forearm"), heavy)
    assert limits(problem, effort, line)
    assert not limits(problem, dry, slow)
