"""The judge, and the tables of what it judged."""

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

import judge
import matching
import run
import summary
from recorder import Sensing

TRUTH: dict[str, Any] = {
    "case": "c",
    "kind": "single",
    "robot": "planar",
    "truth": [{"effect": "coulomb_friction", "target": "elbow", "parameters": {"torque": 0.2}, "twins": []}],
    "outside": None,
    "tolerated": [],
    "sensing": asdict(Sensing()),
    "joints": ["shoulder", "elbow"],
}
NOTHING = {**TRUTH, "kind": "nothing", "truth": []}
TILT = {
    **TRUTH,
    "truth": [
        {
            "effect": "base_tilt",
            "target": "base",
            "parameters": {"roll": 0.0, "pitch": 0.1},
            "twins": [["joint_offset", "shoulder"]],
        }
    ],
}
BUS = {**TRUTH, "truth": [{"effect": "command_delay", "target": "*", "parameters": {"time": 0.01}, "twins": []}]}


def found(effect: str, target: object, *others: tuple[str, str], **parameters: float) -> dict[str, Any]:
    return {
        "effect": effect,
        "target": target,
        "parameters": {k: {"value": v, "low": v, "high": v, "unit": ""} for k, v in parameters.items()},
        "cannot_tell_from": [{"effect": e, "target": t, "why": ""} for e, t in others],
    }


def diagnosis(*findings: dict[str, Any], before: float = 5.0, after: float = 1.2) -> dict[str, Any]:
    return {"verdict": "explained", "findings": list(findings), "gap": {"held_out": {"before": before, "after": after}}}


FRICTION = found("coulomb_friction", "elbow", torque=0.21)
ELSE = [("viscous_friction", "elbow"), ("backlash", "elbow"), ("torque_ripple", "elbow")]


@pytest.mark.parametrize(
    ("truth", "findings", "first", "exact", "wrong", "missed"),
    [
        (TRUTH, [FRICTION], True, True, 0, 0),
        (TRUTH, [], False, False, 0, 1),
        (TRUTH, [found("coulomb_friction", "shoulder")], False, False, 1, 1),
        (TRUTH, [found("coulomb_friction", ["elb*"])], True, True, 0, 0),
        (TRUTH, [found("coulomb_friction", "*")], False, False, 1, 1),
        (TRUTH, [found("stribeck_friction", "elbow", ("coulomb_friction", "elbow"))], True, True, 0, 0),
        (TRUTH, [found("stribeck_friction", "elbow", *ELSE, ("coulomb_friction", "elbow"))], False, False, 1, 1),
        (TRUTH, [FRICTION, found("rotor_inertia", "elbow")], True, False, 1, 0),
        (TRUTH, [found("rotor_inertia", "elbow"), FRICTION], False, False, 1, 0),
        (TRUTH, [FRICTION, FRICTION], True, False, 1, 0),
        (TILT, [found("joint_offset", "shoulder")], True, True, 0, 0),
        (TILT, [found("joint_offset", "elbow")], False, False, 1, 1),
        (BUS, [found("command_delay", ["shoulder", "elbow"])], True, True, 0, 0),
        (NOTHING, [], None, True, 0, 0),
        (NOTHING, [FRICTION], None, False, 1, 0),
        ({**NOTHING, "tolerated": [["coulomb_friction", "elbow"]]}, [FRICTION], None, True, 0, 0),
    ],
)
def test_the_judge(
    truth: dict[str, Any], findings: list[dict[str, Any]], first: bool | None, exact: bool, wrong: int, missed: int
) -> None:
    score = judge.judge(truth, diagnosis(*findings))
    assert (score.first_right, score.exact, score.wrong, score.missed) == (first, exact, wrong, missed)


LEANS = {
    **TRUTH,
    "truth": [
        {
            "effect": "direction_friction",
            "target": "elbow",
            "parameters": {"forward": 0.1, "backward": 0.3},
            "twins": [],
        }
    ],
}
LEANS_IN_TWO = {
    **TRUTH,
    "truth": [
        {"effect": "coulomb_friction", "target": "elbow", "parameters": {"torque": 0.2}, "twins": []},
        {"effect": "constant_effort", "target": "elbow", "parameters": {"effort": 0.1}, "twins": []},
    ],
}


def test_friction_that_leans_is_one_law_in_two_wordings() -> None:
    two = [found("coulomb_friction", "elbow", torque=0.2), found("constant_effort", "elbow", effort=0.1)]
    one = found("direction_friction", "elbow", forward=0.1, backward=0.3)
    for truth, findings in ((LEANS, two), (LEANS_IN_TWO, [one])):
        score = judge.judge(truth, diagnosis(*findings))
        assert score.exact
        assert score.parameter_error == pytest.approx(0.0, abs=1e-9)
    assert not judge.judge(LEANS, diagnosis(two[0])).exact


def spread_truth(shared: bool) -> dict[str, Any]:
    one = {"effect": "coulomb_friction", "parameters": {"torque": 0.2}, "twins": []}
    places = ["*"] if shared else TRUTH["joints"]
    return {**TRUTH, "kind": "several", "truth": [{**one, "target": t} for t in places]}


@pytest.mark.parametrize("shared", [True, False])
def test_several_effects_are_counted_at_each_joint(shared: bool) -> None:
    truth = spread_truth(shared)
    whole = judge.judge(truth, diagnosis(found("coulomb_friction", "*", torque=0.2)))
    apart = judge.judge(truth, diagnosis(*(found("coulomb_friction", j, torque=0.2) for j in truth["joints"])))
    assert (whole.exact, apart.exact) == (True, True)
    part = judge.judge(truth, diagnosis(FRICTION, found("backlash", "elbow")))
    assert (part.truths, part.names, part.names_right, part.wrong, part.missed) == (2, 2, 1, 1, 1)
    told = found("stribeck_friction", "*", ("coulomb_friction", "*"))
    assert judge.judge(truth, diagnosis(told)).names_right == 2


def test_the_judge_counts_intervals_that_hold_the_truth() -> None:
    wide, narrow = found("coulomb_friction", "elbow", torque=0.21), found("coulomb_friction", "elbow", torque=0.21)
    wide["parameters"]["torque"] |= {"low": 0.19, "high": 0.23}
    narrow["parameters"]["torque"] |= {"low": 0.205, "high": 0.215}
    scores = [judge.judge(TRUTH, diagnosis(f)) for f in (wide, narrow)]
    assert [(s.fitted, s.covered) for s in scores] == [(1, 1), (1, 0)]


def test_a_phase_is_the_same_one_turn_on() -> None:
    planted_ripple = {"amplitude": 0.1, "periods": 8.0, "phase": -3.1}
    truth = {"effect": "torque_ripple", "target": "elbow", "parameters": planted_ripple, "twins": []}
    ripple = found("torque_ripple", "elbow", **planted_ripple)
    ripple["parameters"]["phase"] |= {"low": 3.1, "high": 3.3}
    assert judge.coverage(ripple, truth) == (2, 2)  # periods are held


def test_an_unnamed_effort_is_right_outside_the_list_alone() -> None:
    shape = found("effort_map", "elbow") | {"variables": ["angle"]}
    outside = {**NOTHING, "kind": "outside", "outside": {"what": "an effort", "variables": ["position"]}}
    score = judge.judge(outside, diagnosis(shape))
    assert (score.silent, score.variables_right) == (True, True)
    speed = judge.judge(outside, diagnosis({**shape, "variables": ["speed"]}))
    assert (speed.silent, speed.variables_right) == (True, False)
    assert not judge.judge(NOTHING, diagnosis(shape)).silent


def test_what_keeps_laws_nearly_right_is_a_wrong_name_and_known_as_such() -> None:
    truth = {**NOTHING, "kind": "nearly_nothing", "besides": [["friction_ripple", "elbow"]]}
    score = judge.judge(truth, diagnosis(found("friction_ripple", "elbow"), FRICTION))
    assert (score.exact, score.wrong, score.besides) == (False, 2, 1)


def test_of_sealed_seeds_only_totals_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    score = judge.judge({**TRUTH, "case": "6/single_000"}, diagnosis(FRICTION))
    run.report([score], {}, tmp_path, "blind_sealed", run.sealed(6))
    assert [p.name for p in tmp_path.iterdir()] == ["blind_sealed_kinds.csv"]
    told = capsys.readouterr().out + (tmp_path / "blind_sealed_kinds.csv").read_text()
    assert "100 % (1/1)" in told
    assert "single_000" not in told
    assert not run.sealed(1)


def test_a_truth_is_used_once_and_plain_names_go_first() -> None:
    truths = [dict(TRUTH["truth"][0]), {**TRUTH["truth"][0], "effect": "stribeck_friction"}]
    both = [found("stribeck_friction", "elbow", ("coulomb_friction", "elbow")), FRICTION]
    assert matching.match(both, truths, TRUTH["joints"]) == [1, 0]


def test_the_judge_measures_parameters_and_gap() -> None:
    score = judge.judge(TRUTH, diagnosis(FRICTION))
    assert score.parameter_error == pytest.approx(0.05)
    assert score.gap_removed == pytest.approx(3.8 / 4.0)
    tilted = found("base_tilt", "base", roll=0.01, pitch=0.1)
    assert judge.judge(TILT, diagnosis(tilted)).parameter_error == pytest.approx(0.1)


def test_a_payload_is_judged_by_its_mass_and_by_its_place() -> None:
    planted_load = {"mass": 0.2, "x": 0.03, "y": 0.0, "z": -0.04}
    truth = {**TRUTH, "truth": [{"effect": "payload", "target": "hand", "parameters": planted_load, "twins": []}]}
    load = found("payload", "hand", mass=0.22, x=0.03, y=0.005, z=-0.04)
    assert judge.judge(truth, diagnosis(load)).parameter_error == pytest.approx(0.5 * (0.1 + 0.1))


def test_a_diagnosis_that_was_not_written_is_right_nowhere() -> None:
    score = judge.judge(NOTHING, None)
    assert (score.exact, score.silent, score.verdict) == (False, False, "failed")


def test_the_tables_count_what_was_judged(tmp_path: Path) -> None:
    wrong = judge.judge({**TRUTH, "case": "d"}, diagnosis(found("backlash", "elbow")))
    scores = [judge.judge(TRUTH, diagnosis(FRICTION)), wrong, judge.judge(NOTHING, diagnosis())]
    counts = summary.confusion(scores)
    assert counts["coulomb_friction", "coulomb_friction"] == 1
    assert counts["coulomb_friction", "backlash"] == 1
    assert counts["nothing", "nothing"] == 1
    rows = {what: reached for what, _, reached in summary.goals(scores, {"c": 12.0})}
    assert rows["single effects: first name right"] == "50 % (1/2)"
    assert rows["nothing missing: nothing named"] == "100 % (1/1)"
    summary.write_scores(scores, tmp_path / "blind.csv")
    summary.write_confusion(scores, tmp_path, "blind")
    assert len((tmp_path / "blind.csv").read_text().splitlines()) == 4
    assert (tmp_path / "blind_confusion.png").stat().st_size > 0
