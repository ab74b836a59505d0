"""The page of a diagnosis: every verdict tells its story in one offline file that a person and a machine can read."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import chromium
import numpy as np
import pytest
from defusedxml.ElementTree import fromstring
from matplotlib.figure import Figure
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.units import unit_there
from realitygap.diagnose.judge.gaps import Shown
from realitygap.diagnose.propose.words import odds as bet
from realitygap.diagnose.result.diagnosis import Diagnosis
from realitygap.diagnose.result.odds import odds
from realitygap.diagnose.result.story import write_story
from realitygap.diagnose.result.story_figures import Curves, Pair, _close_up, _roomy, draw_curves, draw_pairs
from realitygap.diagnose.result.story_text import interval, quantity, verdict
from realitygap.diagnose.result.summary import summary
from realitygap.robot.effects import EFFECTS
from told_story import VERDICTS, page_of


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
    rival = "viscous friction at elbow : fitted in its place, it makes the recordings 1.5 times less probable, which is"
    assert f"{rival} too little to decide (in logarithms 0.4 ± 0.6)" in words
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
        (1.06, ": with it the gap on held-out motions falls from 3.00 to 1.06 times the floor"),
        (3.002, ": but with it the gap on held-out motions stays at 3.00 times the floor"),
        (10.0, ": but with it the gap on held-out motions rises from 3.00 to 10.0 times the floor"),
    ],
)
def test_the_verdict_says_which_way_the_gap_went(told: Callable[[str], Diagnosis], after: float, said: str) -> None:
    result = told("partly explained")
    assert said in verdict(replace(result, costs=(result.costs[0], dict.fromkeys(result.costs[1], after**2))))


@pytest.mark.parametrize(
    ("times", "said"),
    [(1.49, "1.5"), (9.9, "9.9"), (40.0, "40"), (9000.0, "9000"), (2e5, "10⁵"), (1e9, "more than 10⁶")],
)
def test_evidence_is_told_as_odds(times: float, said: str) -> None:
    assert odds(np.log(times)) == said


def test_what_propose_says_of_odds_is_written_alike() -> None:
    assert [bet(x) for x in (20.0, -20.0)] == ["more than 10⁶ : 1", "1 : more than 10⁶"]
    assert bet(np.log(2e5)) == "10⁵ : 1"


@pytest.mark.parametrize("use", ["train", "held_out"])
def test_the_page_says_the_rule_by_which_it_counts_as_explained(
    told: Callable[[str], Diagnosis], tmp_path: Path, use: str
) -> None:
    result = told("explained")
    _, _, words = page_of(result, tmp_path)
    (said,) = re.findall(r"left is at most ([\d.]+) floors, or at most (\d+) % of what it was, on held-out and", words)
    floors, share = float(said[0]), float(said[1]) / 100.0
    cases = result.problem.of(use)
    for before, most in ((3.0, floors), (100.0, 100.0 * share)):
        for after, named in ((0.999 * most, "explained"), (1.001 * most, "partly explained")):
            was, left = dict.fromkeys(result.costs[0], before**2), dict.fromkeys(result.costs[1], 0.0)
            now = replace(result, costs=(was, left | dict.fromkeys(cases, after**2)))
            assert now.verdict == named
            assert (f"at most {said[1]} % of what it was" in verdict(now)) == (
                named == "explained" and before == 100.0 and use == "held_out"
            )
    assert f"Counts as no gap up to {said[0]} floors" in page_of(told("no gap"), tmp_path)[2]


@pytest.mark.parametrize(
    ("others", "said"),
    [
        ({}, ""),
        (
            {"dart": (9.0, 1.0605)},
            "2 engines agree on the gap that is left on held-out motions within 1.0 %: from 1.05 floors in "
            "MuJoCo to 1.06 in DART.",
        ),
        (
            {"dart": (9.0, 1.2), "drake": (9.0, 0.8)},
            "3 engines agree on the gap that is left on held-out motions within 50 %: "
            "from 0.800 floors in Drake to 1.20 in DART.",
        ),
        (
            {"dart": (9.0, 1.0501)},
            "2 engines agree on the gap that is left on held-out motions within 0.10 %: 1.05 floors in each of them.",
        ),
    ],
)
def test_the_page_says_how_closely_engines_agree_on_what_is_left(
    told: Callable[[str], Diagnosis], tmp_path: Path, others: dict[str, tuple[float, float]], said: str
) -> None:
    result = told("explained")
    result = replace(result, shown={result.changes[-1].suspect: Shown(3.0, 1.05, others)})
    _, _, words = page_of(result, tmp_path)
    assert ("engines agree on" in words) == bool(others)
    assert said in words


@pytest.mark.parametrize("kind", ["explained", "partly explained", "unexplained"])
@pytest.mark.parametrize("cut", [False, True])
def test_what_was_not_tried_is_not_said_to_explain_nothing(
    told: Callable[[str], Diagnosis], tmp_path: Path, kind: str, cut: bool
) -> None:
    result = told(kind)
    _, _, words = page_of(replace(result, found=replace(result.found, cut=cut)), tmp_path)
    assert ("The search ended with its time, before all was tried" in words) == cut
    nothing_else = ("which no effect explains", "that no effect explains", "nothing worth a name is left")
    assert any(no in words for no in nothing_else) != cut
    assert ("effects at every place where they could act" in words) == (kind == "unexplained" and not cut)


@pytest.mark.parametrize(("count", "folded"), [(10, False), (11, True)])
def test_many_faults_of_recordings_unfold(
    told: Callable[[str], Diagnosis], tmp_path: Path, count: int, folded: bool
) -> None:
    faults = [f"run_{k}: a fault" for k in range(count)]
    text, page, words = page_of(replace(told("explained"), faults=faults), tmp_path)
    assert page.open == []
    assert all(fault in words for fault in faults)
    assert ("<summary>3 more</summary>" in text) == folded


def test_notes_are_sentences_and_names_in_them_stay(told: Callable[[str], Diagnosis], tmp_path: Path) -> None:
    notes = ["link_mass at forearm is not named: too little", "sines_1 is judged over windows", "elbow sticks"]
    _, _, words = page_of(replace(told("explained"), notes=notes), tmp_path)
    for said in ("Link mass at forearm is not named: too little.", "sines_1 is judged over windows.", "elbow sticks."):
        assert said in words


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
    assert labels.count("position [°]") == panels - 1, "every panel says its quantity and unit"
    assert labels.count("time [s]") == panels
    assert drawn.get("aria-label") == "a <title>"


@pytest.mark.parametrize("reach", [40.0, 300.0, 2500.0])
def test_a_logarithmic_axis_has_room_above_and_between_its_numbers(reach: float) -> None:
    axes = Figure(figsize=(5.6, 1.2)).subplots()
    axes.plot([0.0, 1.0], [-reach, reach])
    _roomy(axes)
    assert axes.get_ylim()[1] > 1.5 * reach
    named = [t.get_text() for t in axes.get_yticklabels() if t.get_text()]
    largest = f"{10 ** int(np.log10(reach))}"
    assert named == [f"−{largest}", "0", largest]


@pytest.mark.parametrize("after", [True, False])
def test_the_close_up_is_where_the_curves_are_seen_to_part(after: bool) -> None:
    """At the turn where they part by most, not where the floor is least."""
    time = np.linspace(0.0, 5.0, 2001)
    measured = 20.0 * np.sin(2.0 * np.pi * time)
    before = measured + 0.05 * (time < 1.0) + 0.8 * np.exp(-(((time - 3.25) / 0.3) ** 2))
    sigma = np.where(time < 1.0, 1e-3, 0.1)
    close = _close_up(Curves(time, measured, before, measured if after else None, sigma, "deg", "position"))
    assert close is not None
    start, end = close
    assert start < 3.25 < end
    assert 0.05 <= end - start <= 0.5


def test_what_the_columns_of_where_and_when_say_is_a_click_away(
    told: Callable[[str], Diagnosis], tmp_path: Path
) -> None:
    text, _, _ = page_of(told("explained"), tmp_path)
    section = text[text.index('id="where"') : text.index('id="found"')]
    lead = section[: section.index("<table")]
    assert len(re.sub(r"<[^>]*>", "", lead[lead.index("<p") :]).split()) < 40
    assert "<details><summary>What the columns say</summary>" in section


def test_figures_take_the_colours_of_the_page() -> None:
    text = draw_pairs([Pair("MuJoCo", 30.0, 1.1, "held out"), Pair("DART", 29.0, None, "held out")], "gaps")
    assert "var(--before)" in text
    assert "var(--ink)" in text
    colours = set(re.findall(r"#[0-9a-f]{6}", text))
    assert not colours & {"#1d2126", "#5c646d", "#000000", "#d55e00", "#0072b2"}


@pytest.mark.parametrize(
    ("value", "unit", "words"),
    [
        (0.25, "N·m", "0.250 N·m"),
        (0.0147, "rad", "0.842° (0.0147 rad)"),
        (1.5, "", "1.50"),
        (np.inf, "N/m", "∞ N/m"),
        (0.0018, "s", "1.80 ms"),
        (0.01, "s", "0.0100 s"),
        (0.0, "s", "0 s"),
        (0.002, "m", "0.00200 m"),
    ],
)
def test_angles_are_read_in_degrees_and_short_times_in_milliseconds(value: float, unit: str, words: str) -> None:
    assert quantity(value, unit) == words


@pytest.mark.parametrize(
    ("low", "high", "unit", "words"),
    [
        (0.0, 0.0018, "s", "0 to 1.80 ms"),
        (0.004, 0.012, "s", "0.00400 to 0.0120 s"),
        (-0.1, 0.2, "rad", "−5.73 to 11.5°"),
        (0.1, np.inf, "N·m", "0.100 to ∞ N·m"),
    ],
)
def test_both_ends_of_an_interval_have_one_unit(low: float, high: float, unit: str, words: str) -> None:
    assert interval(low, high, unit) == words


def test_the_terminal_rounds_as_the_page_does(told: Callable[[str], Diagnosis], tmp_path: Path) -> None:
    result = told("partly explained")
    _, _, words = page_of(result, tmp_path)
    lines = summary(result)
    pairs = [found for line in lines for found in re.findall(r"([\d.]+) -> ([\d.]+)", line)]
    assert len(pairs) > 5
    drawn = ("3.10", "1.20")  # by engine: a picture on the page
    assert [pair for pair in pairs if pair != drawn and " → ".join(pair) not in words] == []
    (found,) = (line for line in lines if line.startswith("  coulomb_friction at elbow: "))
    torque = result.to_json()["findings"][0]["parameters"]["torque"]
    assert f"torque {torque['value']:.3f} N·m [{torque['low']:.3f} to {torque['high']:.3f} N·m]; " in found


def test_a_short_delay_is_told_in_milliseconds_and_written_in_seconds(
    told: Callable[[str], Diagnosis], tmp_path: Path
) -> None:
    delay = Suspect("command_delay", "*", (0, 1))
    change = Change(delay, (("time", 0.0018),), ("time",))
    result = replace(told("explained"), changes=(change,), shown={delay: Shown(3.0, 1.05)})
    _, _, words = page_of(result, tmp_path)
    assert "Command delay at all joints is missing (1.80 ms)" in words
    assert "0.0018" not in words
    assert "time 1.80 ms" in " ".join(summary(result))
    told_time = result.to_json()["findings"][0]["parameters"]["time"]
    assert (told_time["value"], told_time["unit"]) == (0.0018, "s")


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
        if width < 600:
            assert_tables_are_cards(browser)
        ink = browser.run("getComputedStyle(document.querySelector('svg.figure text')).fill")
        paper = browser.run("getComputedStyle(document.body).backgroundColor")
        light = [sum(map(int, re.findall(r"\d+", c)[:3])) / 3 for c in (ink, paper)]
        assert abs(light[0] - light[1]) > 90  # text of figures stands out from the page
        browser.press("Tab")
        assert browser.run("document.activeElement.className") == "skip"


def assert_tables_are_cards(browser: chromium.Browser) -> None:
    """Every value stands beside the name of its column, and nothing is reached by scrolling sideways only."""
    wide = (
        "[...document.querySelectorAll('.scroll')].filter(n => n.scrollWidth > n.clientWidth).map(n => n.textContent)"
    )
    assert browser.run(wide) == []
    cells = """[...document.querySelectorAll('table.plain')].flatMap(table => {
      const names = [...table.querySelectorAll('thead th')].map(n => n.textContent.trim().replace(/\\s+/g, ' '));
      return [...table.querySelectorAll('tbody tr')].flatMap(row => [...row.children].map((cell, k) =>
        [JSON.stringify(names[k]), getComputedStyle(cell, '::before').content, getComputedStyle(cell).display])); })"""
    found = browser.run(cells)
    assert len(found) > 20
    assert [name for name, _, _ in found] == [shown for _, shown, _ in found]
    assert {display for _, _, display in found} == {"flow-root"}
