"""The page of a diagnosis: every verdict tells its story in one offline file that a person and a machine can read."""

import re
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import chromium
import numpy as np
import pytest
from defusedxml.ElementTree import fromstring
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.data.units import unit_there
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.responses import residual
from realitygap.diagnose.judge.gaps import Shown
from realitygap.diagnose.judge.held_out import Verdict
from realitygap.diagnose.judge.locate import locate
from realitygap.diagnose.judge.worsened import Worsened, in_units
from realitygap.diagnose.result import story, story_text
from realitygap.diagnose.result.diagnosis import Closest, Diagnosis
from realitygap.diagnose.result.story import _Value, write_story
from realitygap.diagnose.result.story_figures import Curves, Pair, draw_curves, draw_pairs
from realitygap.diagnose.result.story_text import quantity, verdict
from realitygap.diagnose.result.workflow import summary
from realitygap.diagnose.search.exchange import Rival
from realitygap.diagnose.search.search import Found
from realitygap.diagnose.search.yardstick import Yardstick
from realitygap.robot.effects import EFFECTS
from realitygap.scenario.file import load_scenario

DEMO = Path(__file__).parents[2] / "scenarios" / "demo" / "scenario.yaml"
FRICTION = Suspect("coulomb_friction", "elbow", (1,))
VERDICTS = {"explained": (9.0, 1.1), "partly explained": (9.0, 3.0), "no gap": (1.0, 1.0), "unexplained": (9.0, 9.0)}
"""Mean squared residuals before and after that lead to each verdict."""


@pytest.fixture(scope="module")
def judged() -> Any:
    """The demo with its floors, the fit of what is missing, and what was simulated before and after: no search."""
    problem = build_problem(load_scenario(DEMO), "mujoco")
    change = Change(FRICTION, (("torque", 0.6447),), ("torque",))
    with Simulations(problem, 2) as simulations:
        yardstick = Yardstick(simulations, [change])
        base = yardstick.score(Fit((), residual(simulations, [], yardstick.train)))
        done = yardstick.fit([change])
        every = range(len(problem.cases))
        signals = [dict(enumerate(simulations.of(c, every))) for c in (list[Change](), done.fit.changes)]
    return problem, yardstick, base, done, *signals


@pytest.fixture(scope="module")
def told(judged: Any) -> Callable[[str], Diagnosis]:
    """A function from a verdict to the diagnosis that has it; the costs are invented, everything else is not."""
    problem, yardstick, base, done, before, after = judged
    floors = yardstick.floors

    def make(verdict: str) -> Diagnosis:
        was, left = (dict.fromkeys(range(len(problem.cases)), cost) for cost in VERDICTS[verdict])
        named = verdict in ("explained", "partly explained")
        best = done if named else base
        rival = Rival(Suspect("viscous_friction", "elbow", (1,)), done, 0.4, 0.6)
        gains, rivals = {FRICTION: 41.0}, {FRICTION: [rival]}
        found = Found(base, best, best, 6.0, {FRICTION: 6.0}, floors, yardstick, gains=gains, rivals=rivals)
        gain = Change(Suspect("controller_gain", "elbow", (1,)), (("gain", 4.0),), ("gain",))
        result = Diagnosis(
            problem=problem,
            engines=["mujoco", "dart", "drake"],
            found=found,
            changes=best.fit.changes,
            floors=floors,
            costs=(was, left),
            shown={FRICTION: Shown(3.0, 1.05, {"dart": (3.1, 1.2)})} if named else {},
            predicted=Verdict(30.0, 5.0),
            where=locate(problem, floors, before) if verdict != "no gap" else [],
            left=locate(problem, floors, before)[:1] if verdict == "partly explained" else [],
            worsened=[Worsened("shoulder", "velocity", "deg/s", 1.0, 1.4)] if named else [],
            units=in_units(problem, problem.of("held_out"), before, after),
            faults=["sines_2: 3 readings repeat the one before <them>"],
            closest=[Closest(gain, 3.0, 2.9, "it gains 2.0 in evidence over something else; a name needs 6.0")],
            before=before,
            after=after if named else before,
        )
        assert result.verdict == verdict
        return result

    return make


class _Page(HTMLParser):
    """What a test wants to know of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: list[str | None] = []
        self.links: list[str | None] = []
        self.loads: list[str] = []
        self.open: list[str] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        if "id" in values:
            self.ids.append(values["id"])
        if tag == "a":
            self.links.append(values["href"])
        if tag in ("script", "link", "img", "iframe", "object", "embed", "video"):
            self.loads.append(tag)
        if tag not in ("meta", "br", "path", "use", "rect", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag in ("path", "use", "rect"):
            return
        assert self.open, f"</{tag}> without a start"
        assert self.open.pop() == tag

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        pass

    def handle_data(self, data: str) -> None:
        if "style" not in self.open:
            self.text += data + " "


def page_of(result: Diagnosis, folder: Path) -> tuple[str, _Page, str]:
    text = write_story(result, folder).read_text(encoding="utf-8")
    page = _Page(text)
    return text, page, " ".join(page.text.split())


@pytest.mark.parametrize("verdict", VERDICTS)
def test_every_verdict_is_a_whole_offline_page(told: Callable[[str], Diagnosis], tmp_path: Path, verdict: str) -> None:
    text, page, words = page_of(told(verdict), tmp_path)
    assert page.open == []
    assert page.loads == []
    assert "url(http" not in text
    assert "@import" not in text
    assert len([i for i in page.ids if not i.startswith(("m", "p", "C"))]) == len(
        {i for i in page.ids if not i.startswith(("m", "p", "C"))}
    )
    for link in page.links:
        assert link[1:] in page.ids if link.startswith("#") else link.startswith(("revised/", "diagnosis.json"))
    assert verdict in words
    assert "Virtual recordings." in words  # the demo's are
    assert "triangle_1" in words
    assert "<them>" in words  # what was found in files is escaped


@pytest.mark.parametrize("verdict", ["explained", "partly explained"])
def test_a_finding_stands_with_its_value_its_evidence_and_its_doubts(
    told: Callable[[str], Diagnosis], tmp_path: Path, verdict: str
) -> None:
    result = told(verdict)
    _, _, words = page_of(result, tmp_path)
    told_value = result.to_json()["findings"][0]["parameters"]["torque"]
    assert f"{told_value['value']:.3f} N·m" in words
    assert f"{told_value['low']:.3f} to {told_value['high']:.3f} N·m" in words
    assert "0.276 N·m" in words  # what the model had
    assert EFFECTS["coulomb_friction"].page.signature in words
    assert "3.00 → 1.05" in words
    assert "DART" in words
    assert "Drake cannot express it, or failed" in words
    assert "viscous friction at elbow : its own fit is behind by 0.4 in evidence" in words
    assert "velocity of shoulder: 1.00 → 1.40 °/s" in words
    assert "it gains 2.0 in evidence over something else" in words
    assert ("Something else is missing" in words) == (verdict == "partly explained")


@pytest.mark.parametrize("verdict", ["no gap", "unexplained"])
def test_nothing_named_promises_no_mended_model(told: Callable[[str], Diagnosis], tmp_path: Path, verdict: str) -> None:
    _, page, words = page_of(told(verdict), tmp_path)
    assert not [link for link in page.links if link.startswith("revised/")]
    assert "simulated after" not in words
    assert ("Nothing is missing" in words) == (verdict == "no gap")
    assert ("no effect explains it better than something else would" in words) == (verdict == "unexplained")


@pytest.mark.parametrize(
    ("after", "said"),
    [
        (1.06, ": with it the gap on held-out motions falls from 3.0 to 1.1 times the floor"),
        (3.02, ": but with it the gap on held-out motions stays at 3.0 times the floor"),
        (10.0, ": but with it the gap on held-out motions rises from 3.0 to 10 times the floor"),
    ],
)
def test_the_verdict_says_which_way_the_gap_went(told: Callable[[str], Diagnosis], after: float, said: str) -> None:
    result = told("partly explained")
    assert said in verdict(replace(result, costs=(result.costs[0], dict.fromkeys(result.costs[1], after**2))))


@pytest.mark.parametrize("kind", ["partly explained", "unexplained"])
@pytest.mark.parametrize("cut", [False, True])
def test_what_was_not_tried_is_not_said_to_explain_nothing(
    told: Callable[[str], Diagnosis], tmp_path: Path, kind: str, cut: bool
) -> None:
    result = told(kind)
    _, _, words = page_of(replace(result, found=replace(result.found, cut=cut)), tmp_path)
    assert ("The search ended with its time, before all was tried" in words) == cut
    assert any(no in words for no in ("which no effect explains", "that no effect explains")) != cut
    assert ("effects at every place where they could act" in words) == (kind == "unexplained" and not cut)


def test_the_same_diagnosis_is_the_same_page(told: Callable[[str], Diagnosis], tmp_path: Path) -> None:
    first, second = (write_story(told("explained"), tmp_path / n).read_text("utf-8") for n in "ab")
    assert first == second


def curves(offset: float) -> Curves:
    t = np.linspace(0, 2, 400)
    return Curves(t, np.sin(t), np.sin(t) + offset, np.sin(t) + 0.001, np.full(400, 0.002), "deg", "position", [(0, 1)])


@pytest.mark.parametrize(("offset", "panels"), [(0.5, 2), (0.02, 3)])
def test_curves_that_hardly_part_are_drawn_close_up_too(offset: float, panels: int) -> None:
    drawn = fromstring(draw_curves(curves(offset), "a <title>"))
    labels = [t.text for t in drawn.iter("{http://www.w3.org/2000/svg}text")]
    assert ("close up" in labels) == (panels == 3)
    assert drawn.get("aria-label") == "a <title>"


def test_figures_take_the_colours_of_the_page() -> None:
    text = draw_pairs([Pair("MuJoCo", 30.0, 1.1, "held out"), Pair("DART", 29.0, None, "held out")], "gaps")
    assert "var(--before)" in text
    assert "var(--ink)" in text
    colours = set(re.findall(r"#[0-9a-f]{6}", text))
    assert not colours & {"#1d2126", "#5c646d", "#000000", "#d55e00", "#0072b2"}


@pytest.mark.parametrize(
    ("value", "unit", "words"),
    [(0.25, "N·m", "0.250 N·m"), (0.0147, "rad", "0.842° (0.0147 rad)"), (1.5, "", "1.50"), (np.inf, "N/m", "∞ N/m")],
)
def test_angles_are_read_in_degrees(value: float, unit: str, words: str) -> None:
    assert quantity(value, unit) == words


def test_a_gain_has_the_unit_of_its_servo(judged: Any) -> None:
    gain = EFFECTS["controller_gain"].parameter("gain")
    assert unit_there(judged[0], Suspect("controller_gain", "elbow", (1,)), gain) == "duty/rad"


@pytest.mark.skipif(chromium.PROGRAM is None, reason="needs Chromium: install it (Debian: apt install chromium)")
@pytest.mark.parametrize(("width", "dark"), [(1280, False), (1280, True), (380, False)])
def test_a_browser_shows_it_without_complaint_and_without_scrolling_sideways(
    told: Callable[[str], Diagnosis], tmp_path: Path, width: int, dark: bool
) -> None:
    path = write_story(told("partly explained"), tmp_path)
    with chromium.Browser(width, 900, dark=dark) as browser:
        browser.open(path)
        assert browser.complaints == []
        assert browser.run("document.documentElement.scrollWidth") <= width
        ink = browser.run("getComputedStyle(document.querySelector('svg.figure text')).fill")
        paper = browser.run("getComputedStyle(document.body).backgroundColor")
        light = [sum(map(int, re.findall(r"\d+", c)[:3])) / 3 for c in (ink, paper)]
        assert abs(light[0] - light[1]) > 90  # text of figures stands out from the page
        browser.press("Tab")
        assert browser.run("document.activeElement.className") == "skip"


def test_many_findings_are_told_by_effect_and_in_a_table(
    told: Callable[[str], Diagnosis], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(story, "MANY", 0)
    monkeypatch.setattr(story_text, "MANY", 0)
    text, page, words = page_of(told("partly explained"), tmp_path)
    assert not page.open, "an element is left open"
    assert "Coulomb friction at elbow is missing or wrong" in words
    assert words.count("the model had") == 2, "in the table, and in the finding's own"
    assert text.count("<details>") == 1


def test_an_effect_at_many_joints_is_one_row_and_many_places_unfold(
    told: Callable[[str], Diagnosis], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, number in {"MANY": 0, "FIRST": 0, "FEW": 1}.items():
        monkeypatch.setattr(story, name, number)
    result = told("partly explained")
    other = Suspect("coulomb_friction", "shoulder", (0,))
    both = (*result.changes, Change(other, (("torque", 0.2),), ("torque",)))
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
    assert text.count("<details>") == 4, "places, both findings together, and each"


def test_a_parameter_that_one_of_many_joints_has_is_its_own_row(monkeypatch: pytest.MonkeyPatch) -> None:
    """A speed that a profile does not limit is not told, and tables of efforts stand at their own knots."""
    monkeypatch.setattr(story, "MANY", 0)
    monkeypatch.setattr(story, "FEW", 1)
    one: dict[str, Any] = {
        "name": "command profile",
        "target": "elbow",
        "sits_at": "joint",
        "before": "3",
        "after": "1",
    }
    fast, slow = _Value(9.0, 8.0, 10.0, "rad/s²", None), _Value(7.0, 6.0, 8.0, "rad/s²", None)
    both = {
        "parameters": [("speed", "2 rad/s", "1 to 3", "none"), ("acceleration", "9 rad/s²", "8 to 10", "none")],
        "values": {"speed": _Value(2.0, 1.0, 3.0, "rad/s", None), "acceleration": fast},
    }
    less = {"parameters": [("acceleration", "7 rad/s²", "6 to 8", "none")], "values": {"acceleration": slow}}
    rows = story._table([one | both, one | less | {"target": "knee"}])
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


@pytest.mark.parametrize("joints", [1, 2, 3, 4, 7])
def test_the_table_tells_no_value_that_none_of_the_joints_has(joints: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of few joints each has its row; of many, values, intervals and what the model had reach from and to."""
    monkeypatch.setattr(story, "MANY", 0)
    at = [
        _Value(0.1 * k, 0.1 * k - 0.05, 0.1 * k + 0.02, "N·m", (0.03 + 0.01 * (k % 2),) * 2)
        for k in range(1, joints + 1)
    ]
    found: list[dict[str, Any]] = [
        {"name": "coulomb friction", "target": f"j{k}", "sits_at": "joint", "before": "3", "after": "1"}
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
        Change(Suspect("coulomb_friction", "shoulder", (0,)), (("torque", 0.2),), ("torque",)),
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
            Change(FRICTION, (("torque", 0.2),), ("torque",)),
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
    _, page, words = page_of(result, tmp_path)
    assert f"revised/robot.urdf : {said}" in words
    assert "revised/robot.urdf" in page.links


def test_what_the_model_had_is_told_of_all_the_joints_of_a_finding(told: Callable[[str], Diagnosis]) -> None:
    result = told("explained")
    joints, plant = ("shoulder", "elbow"), result.problem.plant
    drive = plant.drive.copy()
    drive["coulomb"][[plant.model.joint_names.index(n) for n in joints]] = 0.05, 0.03
    result = replace(result, problem=replace(result.problem, plant=replace(plant, drive=drive)))
    both = Change(Suspect("coulomb_friction", "*", (0, 1)), (("torque", 0.2),), ("torque",))
    assert (
        story_text.lacks(result, both)
        == "coulomb friction at all joints is wrong (0.200 N·m instead of 0.0300 to 0.0500 N·m)"
    )
    (torque,) = both.suspect.kind.parameters
    assert story_text.model_value(result.problem, both.suspect, torque) == "0.0300 to 0.0500 N·m"


def test_a_limit_that_is_not_there_is_not_told(told: Callable[[str], Diagnosis], tmp_path: Path) -> None:
    profile = Suspect("command_profile", "elbow", (1,))
    change = Change(profile, (("speed", np.inf), ("acceleration", 40.0)), ("acceleration",))
    result = replace(told("explained"), changes=(change,), shown={profile: Shown(3.0, 1.05)})
    _, _, words = page_of(result, tmp_path)
    assert "40.0 rad/s²" in words
    assert list(result.to_json()["findings"][0]["parameters"]) == ["acceleration"]
    assert any("acceleration 40" in line and "speed" not in line for line in summary(result))
