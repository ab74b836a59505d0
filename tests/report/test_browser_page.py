"""The page as a whole in a real browser: any width, dark and light, few results and very many."""

import json
import re
import shutil
from pathlib import Path

import chromium
import pytest
import synthetic
from invented_page import JOINTS
from realitygap.page.cards import with_column_names
from realitygap.page.shell import style
from realitygap.report import write_page
from realitygap_engines import ENGINES

VIEW = '<meta name="viewport" content="width=device-width">'


@pytest.mark.parametrize("width", [390, 1280])
def test_names_and_values_of_all_engines_stay_in_their_columns(
    shared: chromium.Browser, tmp_path: Path, width: int
) -> None:
    gaps = {(e, (), "position", g): 0.0699 + 0.01 * i for i, e in enumerate(ENGINES) for g in ("moving", "unmoving")}
    synthetic.write_planted(tmp_path, synthetic.planted(gaps, noise=1e-3, numerical=1e-3))
    shared.complaints.clear()
    shared.resize(width, 900)
    shared.open(write_page(tmp_path))
    shared.wait("document.querySelectorAll('.heat td[data-r]').length > 0")
    overlaps = """[...document.querySelectorAll('.heat thead tr, .heat tbody tr')].flatMap(row => {
      const text = [...row.querySelectorAll('th[scope=col], td[data-r]')].map(cell => {
        const range = document.createRange(); range.selectNodeContents(cell); return range.getBoundingClientRect(); });
      return text.slice(1).map((t, i) => t.left - text[i].right); }).filter(space => space < 1).length"""
    assert shared.run("document.querySelectorAll('.heat thead th').length") == len(ENGINES)
    assert shared.run(overlaps) == 0
    assert re.fullmatch(r"0  \d\.\d+°", shared.texts(".legend span:first-child")[0]), (
        "a degree sign stands at its number"
    )
    assert shared.run("document.documentElement.scrollWidth") <= width
    assert shared.complaints == []
    shared.resize(1280, 900)


def test_what_comes_with_the_recording_has_no_switch_and_is_not_compared(
    shared: chromium.Browser, tmp_path: Path
) -> None:
    cells = [
        synthetic.cell(recording=recording, robot_revision=revision, use=use)
        for recording, revision, use in (("kick", "old", "train"), ("squat", "new", "held_out"))
    ]
    synthetic.write_folder(tmp_path, joints=JOINTS, cells=cells, error=lambda _: 0.01)
    shared.complaints.clear()
    shared.open(write_page(tmp_path))
    shared.wait("document.querySelector('#detail svg.plot') !== null")
    assert shared.texts("#switches legend") == ["signal", "recording"]
    assert shared.texts("#improvement h3") in ([], ["Improvement from one recording to another"])
    assert "not measured alike" not in shared.run("document.getElementById('improvement').textContent")
    assert shared.complaints == []


@pytest.mark.parametrize("width", [360, 768, 1280])
def test_nothing_is_wider_than_the_window(browser: chromium.Browser, width: int) -> None:
    browser.resize(width, 800)
    browser.open(Path(browser.run("decodeURIComponent(location.pathname)")))
    browser.wait("document.querySelector('#detail svg.plot') !== null")
    assert browser.run("document.documentElement.scrollWidth") <= width
    lines = "[...document.querySelectorAll('.heat thead th')].map(n => n.clientHeight)"
    assert max(browser.run(lines)) < 30, "an engine's name is broken"
    cut = "[...document.querySelectorAll('.sortable td')].filter(n => n.getBoundingClientRect().right > innerWidth)"
    if width < 500:
        assert browser.run(f"{cut}.length") == 0, "a value of a table lies outside of the window"
        labels = (
            "[...document.querySelectorAll('.sortable tbody td')].map(n => getComputedStyle(n, '::before').content)"
        )
        assert '"position [°]"' in browser.run(labels)


def test_a_long_name_of_a_column_stays_beside_its_value_on_a_phone(shared: chromium.Browser, tmp_path: Path) -> None:
    head = "<thead><tr><th>servos.drive.friction.coulomb</th></tr></thead>"
    cell = '<td class="num" data-label="servos.drive.friction.coulomb"><span>0.5</span></td>'
    page = tmp_path / "page.html"
    table = f"<table class=sortable>{head}<tbody><tr>{cell}</tr></tbody></table>"
    page.write_text(f"<!doctype html>{VIEW}<style>{style()}</style>{table}", encoding="utf-8")
    shared.resize(390, 900)
    shared.open(page)
    lines = "(n => n.clientHeight / parseFloat(getComputedStyle(n).lineHeight))(document.querySelector('td'))"
    assert shared.run(lines) > 1.9, "the name is not broken into lines"
    shared.resize(1280, 900)


LONG = "servos.drive.friction.coulomb"


def long_key(folder: Path) -> Path:
    """A page whose cells differ in a key that is longer than its values."""
    cells = [synthetic.cell(overrides=json.dumps({LONG: own})) for own in (0.2756, 0.5)]
    synthetic.write_folder(folder, joints=JOINTS, cells=cells, error=lambda _: 0.0101)
    return write_page(folder)


def test_a_switch_is_as_wide_as_its_choices_whatever_its_name(shared: chromium.Browser, tmp_path: Path) -> None:
    shared.open(long_key(tmp_path))
    shared.wait("document.querySelector('#detail svg.plot') !== null")
    assert shared.texts("#switches legend")[-1] == LONG
    right = "(n => n.getBoundingClientRect().right)"
    tails = f"[...document.querySelectorAll('.segments')].map(s => {right}(s) - {right}(s.lastElementChild))"
    assert max(shared.run(tails)) < 4


def test_a_long_key_on_a_phone_is_broken_behind_its_dots(shared: chromium.Browser, tmp_path: Path) -> None:
    labels = (
        "[...document.querySelectorAll('#celltable td')].map(n => n.dataset.label).filter(t => t.includes('servos'))"
    )
    shared.open(long_key(tmp_path))
    shared.wait("document.querySelector('#celltable tbody td') !== null")
    assert set(shared.run(labels)) == {LONG.replace(".", ".\u200b")}
    head, body = "<thead><tr><th>load_factor of 0.5</th></tr></thead>", "<tbody><tr><td>1</td></tr></tbody>"
    assert 'data-label="load_\u200bfactor of 0.5"' in with_column_names(f'<table class="plain">{head}{body}</table>')


def test_a_long_name_in_a_sentence_is_broken_on_a_phone(shared: chromium.Browser, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    said = f"<main><p>The missing effort at {'front_shoulder_' * 5}joint depends on the speed.</p></main>"
    page.write_text(f"<!doctype html>{VIEW}<style>{style()}</style>{said}", encoding="utf-8")
    shared.resize(390, 900)
    shared.open(page)
    assert shared.run("document.documentElement.scrollWidth") <= 390
    shared.resize(1280, 900)


def test_what_is_folded_is_printed(browser: chromium.Browser) -> None:
    folded = "[...document.querySelectorAll('details:not([open])')]"
    seen = f"{folded}.map(d => d.lastElementChild.checkVisibility())"
    assert browser.run(f"{folded}.length") > 0
    assert not any(browser.run(seen))
    with browser.printing():
        assert all(browser.run(seen))
        heights = browser.run(f"{folded}.map(d => d.lastElementChild.getBoundingClientRect().height)")
        assert min(heights) > 10
    assert not any(browser.run(seen))


@pytest.mark.usefixtures("shared")
def test_dark_and_light_differ_and_both_contrast(page: Path) -> None:
    grounds = []
    for dark in (False, True):
        with chromium.Browser(dark=dark) as browser:
            browser.open(page)
            script = "(s => [s.backgroundColor, s.color])(getComputedStyle(document.body))"
            ground, ink = ([int(v) for v in c[4:-1].split(",")] for c in browser.run(script))
            grounds.append(sum(ground))
            assert abs(sum(ground) - sum(ink)) > 400
            assert browser.complaints == []
    assert grounds[0] > 600 > 200 > grounds[1]


@pytest.mark.parametrize("width", [1024, 1280, 1400])
def test_all_that_is_told_of_a_cell_is_in_the_window(shared: chromium.Browser, tmp_path: Path, width: int) -> None:
    """Axes with long names, both floors below every gap, a speed and links: no column is cut off at the edge."""
    cells = [
        synthetic.cell(
            step_rate=rate, recording=recording, overrides=json.dumps({"servos.drive.friction.coulomb": own})
        )
        for rate in (100.0, 1000.0)
        for recording in ("chirp_1", "sines_1 ×2")
        for own in (0.2756, 0.65)
    ]
    synthetic.write_folder(tmp_path, joints=JOINTS, cells=cells, error=lambda _: 0.0101)
    shared.complaints.clear()
    shared.resize(width, 900)
    shared.open(write_page(tmp_path))
    shared.wait("document.querySelector('#celltable tbody td') !== null")
    assert shared.texts("#celltable thead th")[-2].startswith("× real time")
    outside = (
        "[...document.querySelectorAll('#celltable td, #celltable td *')].filter(n => n.getBoundingClientRect().right"
    )
    edge = "document.querySelector('#celltable .scroll').getBoundingClientRect().right"
    assert shared.run(f"{outside} > {edge} + 0.5).length") == 0
    broken = "[...document.querySelectorAll('#celltable td small span')].filter(n => n.getClientRects().length > 1)"
    assert shared.run(f"{broken}.length") == 0, "a number is parted from its name"
    assert shared.complaints == []
    shared.resize(1280, 900)


def test_one_joint_one_engine(shared: chromium.Browser, tmp_path: Path) -> None:
    synthetic.write_folder(tmp_path, joints=["pendulum"], cells=[synthetic.cell()], error=lambda _: 0.01)
    shared.complaints.clear()
    shared.open(write_page(tmp_path))
    shared.wait("document.querySelector('#detail svg.plot') !== null")
    assert shared.complaints == []
    assert shared.texts(".segments span") == ["position", "velocity", "effort"]


def test_traces_without_any_measurement_are_shown(shared: chromium.Browser, tmp_path: Path) -> None:
    joints = ["pendulum"]
    for engine in ("mujoco", "dart"):
        cell, trace = synthetic.cell(engine, recording=""), synthetic.trace(joints, 0.01, 1)
        synthetic.write_cell(tmp_path, cell, trace, None)
    synthetic.write_planted(tmp_path, synthetic.planted({}))
    shared.complaints.clear()
    shared.open(write_page(tmp_path))
    shared.wait("document.querySelector('#detail svg.plot') !== null")
    assert "Nothing was measured" in shared.run("document.body.textContent")
    assert shared.complaints == []


def test_curves_beside_the_page_are_loaded_from_disk(
    shared: chromium.Browser, page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = shutil.copytree(page.parent, tmp_path / "beside")
    monkeypatch.setattr("realitygap.report.page.MAILABLE", 0)
    assert write_page(folder).stat().st_size < page.stat().st_size
    shared.complaints.clear()
    shared.open(folder / "report.html")
    shared.wait("document.querySelector('#detail svg.plot') !== null")
    assert shared.complaints == []


def test_a_thousand_cells_stay_usable(shared: chromium.Browser, tmp_path: Path) -> None:
    cells = synthetic.grid(
        engine=["mujoco", "dart", "drake", "pybullet"],
        recording=[f"toss {i}" for i in range(50)],
        step_rate=[250.0, 500.0, 1000.0, 2000.0, 4000.0],
    )
    gaps = {
        (c.engine, (("recording", c.recording), ("step_rate", c.step_rate)), s, "moving"): 0.5 + 0.001 * i
        for i, c in enumerate(cells)
        for s in ("position", "velocity")
    }
    synthetic.write_planted(tmp_path, synthetic.planted(gaps))
    page = write_page(tmp_path)
    assert page.stat().st_size < 5e6
    shared.complaints.clear()
    shared.open(page)
    shared.wait("document.querySelectorAll('.heat td[data-r]').length > 0")
    assert shared.texts("#celltable .more") == ["Show 50 more of 1000"]
    spent = shared.run(
        "(() => { const t = performance.now(); for (const n of [0, 1, 2]) "
        "document.querySelectorAll('input[name=switch-step_rate]')[n].click(); return (performance.now() - t) / 3 })()"
    )
    assert spent < 1000  # ms per switch, on a slow machine too
    assert shared.complaints == []


def test_a_cell_over_several_columns_is_called_by_the_first_of_them(shared: chromium.Browser, tmp_path: Path) -> None:
    head = "<thead><tr><th>effect</th><th>shows\n  from</th><th>taken for</th><th>searched</th></tr></thead>"
    row = '<tr><th scope="row">backlash</th><td colspan="2">does not show</td><td class="num none">–</td></tr>'
    table = f'<table class="plain wide">{head}<tbody>{row}</tbody></table>'
    page = tmp_path / "page.html"
    page.write_text(with_column_names(f"<!doctype html><style>{style()}</style>{table}{table}"), encoding="utf-8")
    names = "[...document.querySelectorAll('tbody tr > *')].map(n => getComputedStyle(n, '::before').content)"
    for width, shown in ((599, ['"effect"', '"shows from"', '"searched"']), (601, ["none"] * 3)):
        shared.resize(width, 900)
        shared.open(page)
        assert shared.run(names) == shown * 2
        seen = shared.run("[...document.querySelectorAll('td.none')].map(n => n.offsetHeight > 0)")
        assert seen == [width > 600] * 2, "what an engine does not have takes no line"
    shared.resize(1280, 900)
