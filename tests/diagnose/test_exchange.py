"""What stands in the place of a finding, on recordings of the bundled demo (synthetic) with planted effects."""

from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
from demo_problem import FRICTION, demo_problem, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.changes import model_key
from realitygap.diagnose.data.problem import build_problem
from realitygap.diagnose.search.alike import alike
from realitygap.diagnose.search.exchange import Exchanged, _in_turn, exchanged, renamed
from realitygap.diagnose.search.rivals import ODDS, Place, Rival, _said_otherwise
from realitygap.diagnose.search_budget import SearchBudget
from realitygap.scenario.file import load_scenario
from stood import Effects, stood

PULL = 0.9
"""A constant effort at the elbow besides its friction [N·m], larger than that."""


def test_two_laws_stand_in_the_place_of_one_that_does_the_most_of_both() -> None:
    """Friction by direction is dry friction beside a constant effort that is no larger, while a joint moves."""
    missing = {("coulomb_friction", "elbow"): {"torque": FRICTION}, ("constant_effort", "elbow"): {"effort": PULL}}
    wrong = {("direction_friction", "elbow"): {"forward": 0.01, "backward": FRICTION + PULL}}
    at = stood(missing, wrong, [("viscous_friction", "elbow")])
    with at.simulations:
        better = exchanged(at.round_, [], Exchanged()).better
    assert better is not None
    assert model_key(better.fit.changes) == at.right
    assert better.evidence - at.round_.now.evidence > at.round_.limit


def test_one_of_several_is_tried_as_what_excludes_it_too() -> None:
    """Friction that falls with speed beside a constant effort, where straight lines tell of friction and that effort:
    friction by direction excludes it, and alone it gains nothing in the place of that.
    """
    problem = demo_problem()
    everyone = [s for s in suspects(problem) if s.kind.law == "friction"]
    effort, dry, wrong = (
        guess(problem, suspect_of(problem, name, "elbow"))
        for name in ("constant_effort", "coulomb_friction", "direction_friction")
    )
    round_ = SimpleNamespace(simulations=SimpleNamespace(problem=problem), everyone=everyone)
    place = cast("Place", SimpleNamespace(round_=round_, change=wrong))
    ((kept, other),) = _said_otherwise(place, [effort, dry])
    assert kept is effort
    assert (other.suspect.effect, other.suspect.target) == ("stribeck_friction", "elbow")
    assert "static" in other.free


def test_a_limit_stands_in_the_place_of_what_mends_it() -> None:
    missing = {("torque_speed_limit", "elbow"): {"stall_torque": 6.0, "no_load_speed": 9.1}}
    others = [(o, "elbow") for o in ("viscous_friction", "torque_constant", "voltage_sag")]
    at = stood(missing, {("supply_voltage", "elbow"): {"supply": 13.0}}, others)
    with at.simulations:
        better = renamed(at.round_, [], [c.suspect for c in at.round_.now.fit.changes])
        assert renamed(at.round_, [], []) is None
    assert better is not None
    assert model_key(better.fit.changes) == at.right


def test_one_supply_of_all_stands_in_the_place_of_what_mends_each_joint() -> None:
    """A gain does at the elbow what a lower supply does, but where it is at its limit."""
    wrong = {
        ("supply_voltage", "shoulder"): {"supply": 13.0},
        ("controller_gain", "elbow"): {"gain": 13.0 / 15.0 * 5.048},
    }
    at = stood({("supply_voltage", "*"): {"supply": 13.0}}, wrong, [("viscous_friction", "elbow")])
    with at.simulations:
        shoulder = [c.suspect for c in at.round_.now.fit.changes if c.suspect.target == "shoulder"]
        better = renamed(at.round_, [], shoulder)
    assert better is not None
    assert model_key(better.fit.changes) == at.right


def test_of_the_same_law_more_is_asked() -> None:
    """Friction by load does a third of what dry friction does, less than is asked of another law, and is tried."""
    missing = {("load_dependent_friction", "elbow"): {"coefficient": 0.1}}
    others = [(o, "elbow") for o in ("torque_constant", "rotor_inertia")]
    at = stood(missing, {("coulomb_friction", "elbow"): {"torque": 0.4}}, others)
    with at.simulations:
        (finding,) = at.round_.now.fit.changes
        same = alike(at.round_, finding)
    assert [s.effect for s in same] == ["load_dependent_friction"]


def test_two_wrong_names_are_exchanged_at_once() -> None:
    joints = ("shoulder", "elbow")
    missing: Effects = {("viscous_friction", j): {"coefficient": 0.3} for j in joints}
    at = stood(missing, {("coulomb_friction", j): {"torque": 0.4} for j in joints}, [])
    with at.simulations:
        better = renamed(at.round_, [], [c.suspect for c in at.round_.now.fit.changes])
    assert better is not None
    assert model_key(better.fit.changes) == at.right


def test_late_nothing_is_told_beside_what_was_left_out() -> None:
    """A shoulder's viscous friction that does nothing goes, and what dry friction gains is what it gains without it."""
    dry: Effects = {("coulomb_friction", "elbow"): {"torque": FRICTION}}
    at = stood(dry, {**dry, ("viscous_friction", "shoulder"): {"coefficient": 0.001}}, [])
    friction, other = at.round_.now.fit.changes
    with at.simulations:
        early = exchanged(at.round_, [], Exchanged())
        at.round_.budget = SearchBudget(steps=0.0)
        late = exchanged(at.round_, [], Exchanged())
        known = [at.round_.adjusted(changes) for changes in ([], [other])]
        now = at.round_.adjusted([friction])
    assert early.better is not None
    assert model_key(early.better.fit.changes) == at.right
    assert list(late.without) == list(late.gains) == [friction.suspect]
    assert late.without[friction.suspect].fit.changes == ()
    for out in (early, late):
        assert out.fuller is not None
        assert {c.suspect for c in out.fuller.fit.changes} == {friction.suspect, other.suspect}
    fresh, stale = (
        Exchanged(gains={friction.suspect: 1.0}, without={friction.suspect: s}) for s in known if s is not None
    )
    assert now is not None
    assert not fresh.forget_beside(now)
    assert fresh.gains
    assert stale.forget_beside(now)
    assert not stale.gains
    assert not stale.without


URDF = """<robot name="arm"><link name="base"/><link name="arm">
<inertial><origin xyz="0 0 -0.5"/><mass value="0.6"/>
<inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint></robot>"""
SCENARIO = """
name: told
robot: {urdf: arm.urdf, base: fixed}
servos: [{joints: hinge, kind: effort}]
motion: {recorded: torque, as: effort}
recordings:
  runs: [{path: run.csv, window: [0.0, 2.0], use: train}, {path: run.csv, window: [2.0, 4.0], use: held_out}]
"""


def test_a_gain_does_what_a_mass_does(tmp_path: Path) -> None:
    """Of a point that hangs from a hinge, where nothing rubs: all that counts is the torque per mass."""
    time = np.arange(0.0, 4.0, 0.01)
    torque = 1.2 * np.sin(4.0 * time) + 0.5 * np.sin(9.0 * time)
    position = np.round(0.3 * np.sin(4.0 * time) / 1.5e-3) * 1.5e-3
    rows = "\n".join(f"{t:.2f},{q:.4f},{u:.4f}" for t, q, u in zip(time, position, torque, strict=True))
    (tmp_path / "run.csv").write_text("time,position,torque\n" + rows)
    (tmp_path / "arm.urdf").write_text(URDF)
    (tmp_path / "scenario.yaml").write_text(SCENARIO)
    heavy = {("link_mass", "arm"): {"mass": 0.8}}
    others = [("controller_gain", "hinge"), ("coulomb_friction", "hinge"), ("constant_effort", "hinge")]
    at = stood(heavy, heavy, others, build_problem(load_scenario(tmp_path / "scenario.yaml"), "mujoco"))
    with at.simulations:
        (finding,) = at.round_.now.fit.changes
        same, *_ = alike(at.round_, finding)
        rivals = exchanged(at.round_, [], Exchanged()).rivals[finding.suspect]
    assert same.effect == rivals[0].suspect.effect == "controller_gain"
    assert rivals[0].open


def test_all_names_that_are_surely_wrong_are_exchanged_in_turn() -> None:
    missing = {
        ("viscous_friction", "shoulder"): {"coefficient": 1.2},
        ("coulomb_friction", "elbow"): {"torque": FRICTION},
        ("constant_effort", "elbow"): {"effort": PULL},
    }
    wrong = {
        ("coulomb_friction", "shoulder"): {"torque": 0.8},
        ("viscous_friction", "elbow"): {"coefficient": 0.6},
        ("joint_offset", "elbow"): {"angle": 0.05},
    }
    at = stood(missing, wrong, [])
    with at.simulations:
        round_, found = at.round_, at.round_.now.fit.changes
        rivals = {}
        for gone, (effect, place) in zip(found, missing, strict=True):
            right = guess(round_.simulations.problem, suspect_of(round_.simulations.problem, effect, place))
            scored = round_.adjusted([*(c for c in found if c is not gone), right], round_.now.fit)
            assert scored is not None
            rivals[gone.suspect] = [Rival(right.suspect, scored, round_.now.evidence - scored.evidence, 0.0)]
        better = _in_turn(round_, rivals)
        one = dict(list(rivals.items())[:1])
        assert _in_turn(round_, one) is _in_turn(round_, {}) is None, "one alone is offered elsewhere"
    assert better is not None
    assert model_key(better.fit.changes) == at.right
    assert better.evidence > max(r.scored.evidence for (r,) in rivals.values()) + ODDS
