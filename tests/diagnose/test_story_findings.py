"""What was found, on the page of a diagnosis: the table of all findings, their cards, and the mended model."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.judge.gaps import Shown
from realitygap.diagnose.library import Diagnosed
from realitygap.diagnose.propose.told import found_changes
from realitygap.diagnose.result import story, story_text
from realitygap.diagnose.result.diagnosis import Diagnosis
from realitygap.diagnose.result.story import _Value
from realitygap.diagnose.result.summary import summary
from realitygap.diagnose.result.workflow import write_diagnosis
from realitygap.robot.effects import EFFECTS
from told_story import FRICTION, Page, page_of


def test_many_findings_are_told_by_effect_and_in_a_table(
    told: Callable[[str], Diagnosis], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(story, "MANY", 0)
    monkeypatch.setattr(story_text, "MANY", 0)
    text, page, words = page_of(told("partly explained"), tmp_path)
    assert not page.open, "an element is left open"
    assert "Coulomb friction at elbow is missing or wrong" in words
    assert words.count("the model had") == 2, "in the table, and in the finding's own"
    assert text.count("<details>") == 2, "what the columns say, and the finding"


def test_an_effect_at_many_joints_is_one_row_and_many_places_unfold(
    told: Callable[[str], Diagnosis], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, number in {"MANY": 0, "FIRST": 0, "FEW": 1}.items():
        monkeypatch.setattr(story, name, number)
    result = told("partly explained")
    other = Suspect("coulomb_friction", "shoulder", (0,))
    both = (*result.changes, Change(other, (("torque", 0.2), ("onset", 0.0), ("presliding", 0.0)), ("torque",)))
    place = result.where[0]
    result = replace(
        result, changes=both, shown={**result.shown, other: Shown(1.05, 1.02)}, where=[place, place, place]
    )
    text, page, words = page_of(result, tmp_path)
    assert not page.open, "an element is left open"
    known = [result.to_json()["findings"][k]["parameters"]["torque"] for k in (0, 1)]
    low, high = min(k["low"] for k in known), max(k["high"] for k in known)
    assert f"coulomb friction 2 joints torque 0.200 to {known[0]['value']:.3f} N·m" in words
    assert f"all within {low:.3f} to {high:.3f} N·m 0.276 N·m" in words, "the intervals, and what the model had"
    assert "coulomb friction at 2 joints, in one step: 3.00 → 1.05 floors coulomb friction at elbow" in words
    assert "3 more, with smaller gaps" in words
    assert text.count("<details>") == 5, "places, what their columns say, both findings together, and each"


def test_a_parameter_that_one_of_many_joints_has_is_its_own_row(monkeypatch: pytest.MonkeyPatch) -> None:
    """A speed that a profile does not limit is not told, and tables of efforts stand at their own knots."""
    monkeypatch.setattr(story, "MANY", 0)
    monkeypatch.setattr(story, "FEW", 1)
    one: dict[str, Any] = {
        "name": "command profile",
        "target": "elbow",
        "sits_at": "joint",
        "indices": (0,),
        "before": "3",
        "after": "1",
    }
    fast, slow = _Value(9.0, 8.0, 10.0, "rad/s²", None), _Value(7.0, 6.0, 8.0, "rad/s²", None)
    both = {
        "parameters": [("speed", "2 rad/s", "1 to 3", "none"), ("acceleration", "9 rad/s²", "8 to 10", "none")],
        "values": {"speed": _Value(2.0, 1.0, 3.0, "rad/s", None), "acceleration": fast},
    }
    less = {"parameters": [("acceleration", "7 rad/s²", "6 to 8", "none")], "values": {"acceleration": slow}}
    rows = story._table([one | both, one | less | {"target": "knee", "indices": (1,)}])
    assert rows == [
        ("command profile", "elbow", "speed", "2 rad/s", "1 to 3", "none"),
        (
            "command profile",
            "2 joints",
            "acceleration",
            "7.00 to 9.00 rad/s²",
            "all within 6.00 to 10.0 rad/s²",
            "none",
        ),
    ]


def test_findings_at_many_joints_each_are_as_many_joints(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(story, "MANY", 0)
    one: dict[str, Any] = {"name": "coulomb friction", "sits_at": "joint", "parameters": [], "values": {}}
    ((title, _),) = story._groups([one | {"indices": (0, 1, 2)}, one | {"indices": (3, 4)}])
    assert title == "coulomb friction at 5 joints"


def test_sentences_call_effects_by_words_and_joints_by_their_names() -> None:
    said = "coulomb_friction at left_knee widens the gap of base_tilted"
    assert story_text.in_words(said) == "coulomb friction at left_knee widens the gap of base_tilted"


@pytest.mark.parametrize("joints", [1, 2, 3, 4, 7])
def test_the_table_tells_no_value_that_none_of_the_joints_has(joints: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of few joints each has its row; of many, values, intervals and what the model had reach from and to."""
    monkeypatch.setattr(story, "MANY", 0)
    at = [
        _Value(0.1 * k, 0.1 * k - 0.05, 0.1 * k + 0.02, "N·m", (0.03 + 0.01 * (k % 2),) * 2)
        for k in range(1, joints + 1)
    ]
    found: list[dict[str, Any]] = [
        {
            "name": "coulomb friction",
            "target": f"j{k}",
            "sits_at": "joint",
            "indices": (k,),
            "before": "3",
            "after": "1",
        }
        | {"parameters": [("torque", f"{v.value} N·m", "its own", "its own")], "values": {"torque": v}}
        for k, v in enumerate(at)
    ]
    rows = story._table(found)
    if joints <= story.FEW:
        assert [row[1:] for row in rows] == [(f"j{k}", *f["parameters"][0]) for k, f in enumerate(found)]
    else:
        ends = (f"0.100 to {0.1 * joints:.3f} N·m", f"all within 0.0500 to {0.1 * joints + 0.02:.3f} N·m")
        assert rows == [("coulomb friction", f"{joints} joints", "torque", *ends, "0.0300 to 0.0400 N·m")]


def test_cards_are_numbered_in_their_order(
    told: Callable[[str], Diagnosis], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of many findings, those of an effect are one card; where they stand among the others does not matter."""
    monkeypatch.setattr(story, "MANY", 0)
    result = told("partly explained")
    first = result.changes[0]
    others = [
        Change(
            Suspect("coulomb_friction", "shoulder", (0,)),
            (("torque", 0.2), ("onset", 0.0), ("presliding", 0.0)),
            ("torque",),
        ),
        Change(Suspect("viscous_friction", "shoulder", (0,)), (("coefficient", 0.2),), ("coefficient",)),
        Change(Suspect("viscous_friction", "elbow", (1,)), (("coefficient", 0.2),), ("coefficient",)),
    ]
    changes = (others[1], first, others[0], Change(Suspect("rotor_inertia", "elbow", (1,)), (("armature", 0.1),)))
    shown = {c.suspect: Shown(3.0, 1.05) for c in changes}
    text, page, _ = page_of(replace(result, changes=changes, shown=shown), tmp_path)
    assert not page.open, "an element is left open"
    assert re.findall(r"<summary><b>(\d+)\. ([a-z ]+) at", text) == [
        ("1", "viscous friction"),
        ("2", "coulomb friction"),
        ("3", "rotor inertia"),
    ]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            Change(FRICTION, (("torque", 0.2), ("onset", 0.0), ("presliding", 0.0)), ("torque",)),
            "the robot as it was: what was found stands in the scenario",
        ),
        (
            Change(Suspect("link_mass", "forearm", (2,)), (("mass", 0.2),), ("mass",)),
            "the robot, with the masses and inertias that were found wrong",
        ),
    ],
    ids=["friction", "mass"],
)
def test_the_mended_robot_is_told_as_what_it_is(
    told: Callable[[str], Diagnosis], tmp_path: Path, change: Change, said: str
) -> None:
    result = replace(told("explained"), changes=(change,), shown={change.suspect: Shown(3.0, 1.05)})
    write_diagnosis(result, tmp_path)
    page = Page((tmp_path / "report.html").read_text(encoding="utf-8"))
    words = " ".join(page.text.split())
    assert f"revised/robot.urdf : {said}" in words
    others = said.replace("the robot", "the robot of runs that have another one", 1)
    assert f"revised/arm_heavy.urdf : {others}" in words
    assert "revised/robot.urdf" in page.links


def test_what_the_model_had_is_told_of_all_the_joints_of_a_finding(told: Callable[[str], Diagnosis]) -> None:
    result = told("explained")
    joints, plant = ("shoulder", "elbow"), result.problem.plant
    drive = plant.drive.copy()
    drive["coulomb"][[plant.model.joint_names.index(n) for n in joints]] = 0.05, 0.03
    result = replace(result, problem=replace(result.problem, plant=replace(plant, drive=drive)))
    both = Change(
        Suspect("coulomb_friction", "*", (0, 1)), (("torque", 0.2), ("onset", 0.0), ("presliding", 0.0)), ("torque",)
    )
    assert (
        story_text.lacks(result, both)
        == "coulomb friction at all joints is wrong (0.0300 to 0.0500 N·m in the model, 0.200 N·m by the recordings)"
    )
    torque, *_ = both.suspect.kind.parameters
    assert story_text.model_value(result.problem, both.suspect, torque) == "0.0300 to 0.0500 N·m"


@pytest.mark.parametrize(
    ("effect", "values", "said"),
    [
        (
            "center_of_mass",
            {"x": 0.01, "y": 0.0, "z": -0.1},
            "is wrong (x 0 m and z −0.112 m in the model, x 0.0100 m and z −0.100 m by the recordings)",
        ),
        ("link_inertia", {"scale": 1.2}, "is wrong (scale 1.00 in the model, scale 1.20 by the recordings)"),
        ("joint_compliance", {"stiffness": 60.0, "damping": 0.0}, "is missing (60.0 N·m/rad)"),
        ("velocity_filter", {"time": 0.02, "scale": 1.1}, "is missing (time 0.0200 s and scale 1.10)"),
    ],
)
def test_what_every_model_has_is_wrong_and_not_missing(
    told: Callable[[str], Diagnosis], effect: str, values: dict[str, float], said: str
) -> None:
    sits = {"link": ("forearm", 2), "joint": ("elbow", 1)}
    target, index = sits[EFFECTS[effect].sits_at]
    change = Change(Suspect(effect, target, (index,)), tuple(values.items()), tuple(values))
    assert said in story_text.lacks(told("explained"), change)


@pytest.mark.parametrize(
    ("load", "coefficient", "velocity", "said"),
    [
        (0.0, "none", "none", "is missing (coefficient 0.350)"),
        (0.1, "0.100", "57.3 °/s (1.00 rad/s)", "is wrong (coefficient 0.100 in the model, coefficient 0.350 by the"),
    ],
)
def test_a_model_has_of_an_effect_what_the_scenario_gave_it_and_else_no_shape_of_it(
    told: Callable[[str], Diagnosis], load: float, coefficient: str, velocity: str, said: str
) -> None:
    result = told("explained")
    plant = result.problem.plant
    drive = plant.drive.copy()
    drive["load"] = load
    result = replace(result, problem=replace(result.problem, plant=replace(plant, drive=drive)))
    own = {p.name: p.default or 0.0 for p in EFFECTS["load_dependent_friction"].parameters} | {"coefficient": 0.35}
    change = Change(Suspect("load_dependent_friction", "elbow", (1,)), tuple(own.items()), ("coefficient",))
    parameters = {p.name: p for p in change.suspect.kind.parameters}
    had = [story_text.model_value(result.problem, change.suspect, parameters[n]) for n in ("coefficient", "velocity")]
    assert had == [coefficient, velocity]
    assert said in story_text.lacks(result, change)


def test_the_page_says_what_its_numbers_are_and_what_to_do_next(
    told: Callable[[str], Diagnosis], tmp_path: Path
) -> None:
    _, _, words = page_of(told("explained"), tmp_path)
    for said in ("the largest in floors first", "position gap on held-out motions", "Run it in this folder with"):
        assert said in words
    assert "What to record next" in words
    assert "In this folder, realitygap propose . designs such motions" in words


@pytest.mark.parametrize("asymmetry", [0.0, -0.2])
def test_a_shape_that_is_there_is_part_of_the_sentence(
    told: Callable[[str], Diagnosis], tmp_path: Path, asymmetry: float
) -> None:
    friction, here = Suspect("direction_friction", "elbow", (1,)), asymmetry != 0.0
    values = (("forward", 0.4), ("backward", 0.5), ("asymmetry", asymmetry), ("presliding", 0.0))
    change = Change(friction, values, ("forward", "backward", *(["asymmetry"] if here else [])))
    result = replace(told("explained"), changes=(change,), shown={friction: Shown(3.0, 1.05)})
    _, _, words = page_of(result, tmp_path)
    assert ("backward 0.500 N·m and asymmetry −0.200 by the recordings" in words) == here


def test_a_limit_that_is_not_there_is_not_told(told: Callable[[str], Diagnosis], tmp_path: Path) -> None:
    profile = Suspect("command_profile", "elbow", (1,))
    change = Change(profile, (("speed", np.inf), ("acceleration", 40.0)), ("acceleration",))
    result = replace(told("explained"), changes=(change,), shown={profile: Shown(3.0, 1.05)})
    _, _, words = page_of(result, tmp_path)
    assert "40.0 rad/s²" in words
    assert list(result.to_json()["findings"][0]["parameters"]) == ["acceleration"]
    assert any("acceleration 40" in line and "speed" not in line for line in summary(result))


@pytest.mark.parametrize("onset", [0.0, 0.02])
def test_a_shape_that_is_not_there_is_not_told(told: Callable[[str], Diagnosis], onset: float) -> None:
    friction = Suspect("coulomb_friction", "elbow", (1,))
    shape = ["onset"] if onset else []
    change = Change(friction, (("torque", 0.2), ("onset", onset), ("presliding", 0.0)), ("torque", *shape))
    result = replace(told("explained"), changes=(change,), shown={friction: Shown(3.0, 1.05)})
    assert list(result.to_json()["findings"][0]["parameters"]) == ["torque", *shape]
    assert any("onset" in line for line in summary(result)) == (onset != 0.0)


def test_what_laws_are_off_by_stands_beside_the_findings_and_is_none(
    told: Callable[[str], Diagnosis], tmp_path: Path
) -> None:
    result = told("explained")
    gain = Change(Suspect("controller_gain", "elbow", (1,)), (("gain", 5.2),), ("gain",))
    result = replace(
        result, adjusted=(gain,), shown={**result.shown, gain.suspect: Shown(1.05, 1.01, {"dart": (1.2, 1.1)})}
    )
    _, page, words = page_of(result, tmp_path)
    assert not page.open, "an element is left open"
    assert "with it, and controller gain at elbow adjusted as far as laws are ordinarily off, the gap" in words
    assert "Adjusted besides: 1.05 → 1.01 floors" in words
    assert "The gap rises with them" not in words
    rising = replace(result, shown={**result.shown, gain.suspect: Shown(1.01, 1.05)})
    assert "The gap rises with them: they were fitted together" in page_of(rising, tmp_path)[2]
    assert "controller gain elbow gain 5.20 duty/rad" in words
    assert "1. coulomb friction at elbow" in words
    assert "2. " not in words.split("Adjusted besides")[0].split("What was found")[1], "it is no finding"
    content = Diagnosed(result, result.to_json())
    assert [f.effect for f in content.findings] == ["coulomb_friction"]
    assert [(f.effect, f.held_out, f.engines) for f in content.adjusted] == [
        ("controller_gain", (1.05, 1.01), {"dart": (1.2, 1.1)})
    ]
    lines = summary(result)
    at = lines.index("  adjusted, as far as laws are ordinarily off; held out 1.05 -> 1.01")
    assert lines[at + 1] == "    controller_gain at elbow: gain 5.20 duty/rad"
    assert lines[at + 2] == "    dart: 1.20 -> 1.10"
    nothing = replace(told("unexplained"), adjusted=(gain,), shown=result.shown)
    assert nothing.verdict == "unexplained", "what laws are off by is no name"
    said = " With controller gain at elbow adjusted as far as laws are ordinarily off it stays at 3.00."
    assert story_text.verdict(nothing).endswith(said)
    costs = nothing.costs[0], dict.fromkeys(nothing.costs[0], 0.81)  # squares
    closed = replace(nothing, costs=costs)
    assert closed.verdict == "unexplained", "it is no name either where nothing else is left"
    assert story_text.verdict(closed) == (
        "Nothing is missing that is more than laws are ordinarily off by: with controller gain at elbow adjusted the "
        "gap on held-out motions falls from 3.00 to 0.900 times the floor."
    )
    revised = content.revised.save(tmp_path / "revised").read_text(encoding="utf-8")
    assert "effect: controller_gain" in revised


def test_where_a_mistake_is_likely_nothing_is_said_to_explain_nothing(
    told: Callable[[str], Diagnosis], tmp_path: Path
) -> None:
    result = told("unexplained")
    _, _, words = page_of(replace(result, blamed=(result.where[0].joint,)), tmp_path)
    assert "A mistake is likely where the gap is, so that nothing was looked for there" in words
    assert "that no effect explains" not in words
    assert "No fault of sensor or clock" not in words


def test_findings_that_are_read_again_are_the_same_changes(told: Callable[[str], Diagnosis]) -> None:
    stop = Suspect("joint_stop", "elbow", (1,))
    values = (("lower", -np.inf), ("upper", 0.8), ("stiffness", 30.0))
    result = told("explained")
    friction = dict(result.changes[0].values)
    assert friction["onset"] == 0.0
    changes = (*result.changes, Change(stop, values))
    result = replace(result, changes=changes, shown={c.suspect: Shown(3.0, 1.05) for c in changes})
    again = found_changes(result.problem, result.to_json()["findings"], Path("diagnosis.json"))
    assert [dict(c.values) for c in again] == [pytest.approx(friction, rel=1e-4), dict(values)]
