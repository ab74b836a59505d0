"""The page in a real browser: it loads without complaint, and keyboard, pointer, switches and sorting work."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import chromium
import numpy as np
import pytest
import synthetic
from realitygap.compare.table import Cell
from realitygap.report import write_page

pytestmark = pytest.mark.skipif(
    chromium.PROGRAM is None, reason="needs Chromium: install it (Debian: apt install chromium)"
)

JOINTS = ("hip", "knee", "ankle", "toe")
ERRORS = {"mujoco": 0.01, "dart": 0.02, "drake": 0.0101}
CELL = 'document.querySelector(\'td[data-r="{}"][data-c="{}"]\')'
DETAIL = "document.getElementById('detail').textContent"


def error(one: Cell) -> float:
    if one.engine == "dart" and one.step_rate == 500:
        return np.inf
    return ERRORS[one.engine] * (2 if one.robot_revision == "old" else 1) * (1.5 if one.step_rate == 500 else 1)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("synthetic")
    cells = synthetic.grid(
        engine=["mujoco", "dart", "drake"],
        robot_revision=["old", "new"],
        step_rate=[500.0, 1000.0],
        recording=["kick", "squat"],
    )
    synthetic.write_folder(folder, joints=JOINTS, cells=cells, error=error)
    return write_page(folder)


@pytest.fixture(scope="module")
def shared() -> Iterator[chromium.Browser]:
    with chromium.Browser() as browser:
        yield browser


@pytest.fixture
def browser(shared: chromium.Browser, page: Path) -> Iterator[chromium.Browser]:
    """The page, freshly opened; whatever it complains about fails the test."""
    shared.complaints.clear()
    shared.resize(1280, 900)
    shared.open(page)
    shared.wait("document.querySelector('#detail svg.plot') !== null")
    yield shared
    assert shared.complaints == []


def texts(browser: chromium.Browser, selector: str) -> Any:
    return browser.run(f"[...document.querySelectorAll({selector!r})].map(n => n.textContent)")


def test_it_shows_engines_joints_and_curves(browser: chromium.Browser) -> None:
    assert texts(browser, ".heat thead th") == ["DART", "Drake", "MuJoCo"]
    assert set(JOINTS) <= set(texts(browser, ".heat th[scope=row]"))
    assert browser.run("document.querySelectorAll('#detail svg.plot').length") >= 3


def test_cell_value_is_that_of_the_table(browser: chromium.Browser) -> None:
    label = browser.run(f"{CELL.format(2, 2)}.getAttribute('aria-label')")
    assert "MuJoCo" in label
    assert "noise floor 0.050°, numerical floor 0.020°" in label


def test_it_opens_on_the_mean_of_all_recordings(browser: chromium.Browser) -> None:
    """For every engine the mean of its cells; of the other switches, the choice that comes closest."""
    choice = "[...document.querySelectorAll('#switches input:checked')].map(n => n.parentElement.textContent)"
    assert browser.run(choice) == ["position", "all, mean", "new", "1000 Hz"]
    shown = float(browser.run(f"{CELL.format(0, 2)}.textContent"))
    single = []
    for k in (1, 2):
        browser.run(f"document.querySelectorAll('input[name=switch-recording]')[{k}].click()")
        single.append(float(browser.run(f"{CELL.format(0, 2)}.textContent")))
    assert shown == pytest.approx(np.mean(single), rel=2e-3)
    assert "of 2 recordings" not in browser.run(DETAIL)


def spanned(browser: chromium.Browser) -> Any:
    """The span of time [s] that the curves show, from the axis."""
    return browser.run("span ?? [0, 4]")


def plot(browser: chromium.Browser) -> Any:
    """Where the first plot of curves lies in the window: x, y, width, height."""
    browser.run("document.querySelector('#detail svg.plot').scrollIntoView({block: 'center'})")
    return browser.run(
        "(r => [r.x, r.y, r.width, r.height])(document.querySelector('#detail svg.plot').getBoundingClientRect())"
    )


def test_a_drag_looks_closer_and_shows_what_is_there(browser: chromium.Browser) -> None:
    lines = "[...document.querySelectorAll('#detail figure.curves')[0].querySelectorAll('path.line')]"
    whole = browser.run(f"{lines}.map(n => n.getAttribute('d').length)")
    x, y, width, height = plot(browser)
    browser.drag(x + 0.4 * width, x + 0.7 * width, y + height / 2)
    low, high = spanned(browser)
    assert 0.25 * 4 < high - low < 0.4 * 4
    assert 1.0 < low < high < 3.0
    closer = browser.run(f"{lines}.map(n => n.getAttribute('d').length)")
    assert all(0.15 * a < b < 0.5 * a for a, b in zip(whole, closer, strict=True))
    axis = "[...document.querySelectorAll('#detail .zoomable svg')[1].querySelectorAll('text[text-anchor=middle]')]"
    ticks = [float(t) for t in browser.run(f"{axis}.map(n => n.textContent)") if t[0].isdigit()]
    assert len(ticks) >= 2
    assert low <= min(ticks) < max(ticks) <= high
    browser.run("document.querySelector('#detail .zoomable').dispatchEvent(new MouseEvent('dblclick'))")
    assert spanned(browser) == [0, 4]


def test_buttons_and_keys_zoom_and_move(browser: chromium.Browser) -> None:
    button = "document.querySelectorAll('#detail .zoom button')[{}]"
    browser.run(f"{button.format(0)}.click()")
    low, high = spanned(browser)
    assert [high - low, (low + high) / 2] == pytest.approx([2.0, 2.0])
    browser.run(f"{button.format(3)}.click()")
    assert spanned(browser) == pytest.approx([2.0, 4.0])
    browser.run(f"{button.format(3)}.click()")
    assert spanned(browser) == pytest.approx([2.0, 4.0]), "nothing lies behind the end"
    browser.run("document.querySelector('#detail figure').focus()")
    browser.press("+")
    assert spanned(browser) == pytest.approx([2.5, 3.5])
    for _ in range(12):
        browser.press("+")
    low, high = spanned(browser)
    assert high - low == pytest.approx(8 * 4 / 800, rel=0.02), "a few samples stay"
    browser.press("0")
    assert spanned(browser) == [0, 4]


def test_a_span_stays_with_another_joint_and_every_engine(browser: chromium.Browser) -> None:
    browser.run("document.querySelectorAll('#detail .zoom button')[0].click()")
    browser.run(f"{CELL.format(3, 0)}.dispatchEvent(new MouseEvent('click', {{bubbles: true}}))")
    browser.wait("document.querySelector('#detail figcaption b').textContent === 'hip'")
    assert spanned(browser) == pytest.approx([1.0, 3.0])


def test_two_fingers_zoom_and_one_moves(browser: chromium.Browser) -> None:
    browser.run(
        """((place, r) => {
        const at = (type, id, x) => place.dispatchEvent(new PointerEvent(type,
          { pointerId: id, pointerType: "touch", clientX: x, clientY: r.y + 5, bubbles: true }));
        place.setPointerCapture = () => {};
        at("pointerdown", 1, r.x + 200); at("pointerdown", 2, r.x + 300);
        at("pointermove", 1, r.x + 150); at("pointermove", 2, r.x + 350);
        at("pointerup", 1, r.x + 150); at("pointerup", 2, r.x + 350);
        window.before = span;
        at("pointerdown", 3, r.x + 200); at("pointermove", 3, r.x + 250); at("pointerup", 3, r.x + 250);
        })(...(p => [p, p.getBoundingClientRect()])(document.querySelector("#detail .zoomable")))"""
    )
    low, high = browser.run("window.before")
    assert high - low == pytest.approx(2.0, rel=1e-3)
    moved = spanned(browser)
    assert moved[1] - moved[0] == pytest.approx(2.0, rel=1e-3)
    assert moved[0] < low - 0.05


def test_arrows_walk_the_map_and_enter_chooses(browser: chromium.Browser) -> None:
    browser.run(f"{CELL.format(0, 0)}.focus()")
    for key in ("ArrowDown", "ArrowDown", "ArrowRight"):
        browser.press(key)
    assert browser.run("document.activeElement.dataset.r + document.activeElement.dataset.c") == "21"
    browser.press("Enter")
    browser.wait(f"{DETAIL}.startsWith('ankle in Drake')")
    assert browser.run(f"{CELL.format(2, 1)}.getAttribute('aria-selected')") == "true"
    assert browser.run("document.activeElement.dataset.r") == "2"  # the focus stays where the person is


def test_click_shows_curves_of_that_joint(browser: chromium.Browser) -> None:
    browser.run(f"{CELL.format(3, 0)}.dispatchEvent(new MouseEvent('click', {{bubbles: true}}))")
    browser.wait(f"{DETAIL}.includes('hip in DART')")
    browser.wait("document.querySelector('#detail figcaption b').textContent === 'hip'")


def test_hover_reads_the_values_out(browser: chromium.Browser) -> None:
    browser.run("document.querySelector('#detail svg.plot').scrollIntoView({block: 'center'})")
    box = browser.run(
        "(r => [r.x, r.y, r.width, r.height])(document.querySelector('#detail svg.plot').getBoundingClientRect())"
    )
    browser.move(box[0] + box[2] / 2, box[1] + box[3] / 2)
    shown = [t for t in texts(browser, "#detail .toggles output") if t]
    assert len(shown) == 5  # measured, three engines, time
    assert sum(t.endswith("°") for t in shown) == 4


def test_keys_move_the_cursor_of_a_plot(browser: chromium.Browser) -> None:
    browser.run("document.querySelector('#detail figure').focus()")
    browser.press("ArrowRight")
    assert any(t.startswith("at 0.0") for t in texts(browser, "#detail .toggles output"))


@pytest.mark.parametrize("axis", ["signal", "recording", "robot_revision", "step_rate"])
def test_switches_change_the_map(browser: chromium.Browser, axis: str) -> None:
    before = texts(browser, ".heat td")
    name = f"input[name=switch-{axis}]"
    other = browser.run(
        f"(n => (n.click(), n.parentElement.textContent))(document.querySelector('{name}:not(:checked)'))"
    )
    assert texts(browser, ".heat td") != before
    assert browser.run(f"document.querySelector('{name}:checked').parentElement.textContent") == other


def test_a_failed_cell_is_told_in_words(browser: chromium.Browser) -> None:
    browser.run("[...document.querySelectorAll('input[name=switch-step_rate]')][0].click()")
    assert texts(browser, ".heat tbody td")[0] == "diverged"
    browser.run(f"{CELL.format(0, 0)}.click()")
    browser.wait(f"{DETAIL}.includes('diverged at 1.2000 s at knee: not finite')")


def test_gap_below_its_floors_is_marked(browser: chromium.Browser) -> None:
    browser.run("[...document.querySelectorAll('input[name=switch-signal]')][2].click()")  # effort: below its noise
    assert "no difference seen" in browser.run(f"{CELL.format(0, 2)}.getAttribute('aria-label')")
    assert browser.run(f"{CELL.format(0, 2)}.className") == "same"


def test_tables_sort_up_and_down(browser: chromium.Browser) -> None:
    rows = "[...document.querySelectorAll('#celltable tbody tr')]"
    column = f"{rows}.map(r => parseFloat(r.children[5].textContent)).filter(isFinite)"
    button = "document.querySelectorAll('#celltable thead button')[5]"
    browser.run(f"{button}.click()")
    rising = browser.run(column)
    assert rising == sorted(rising)
    assert browser.run(f"{button}.parentElement.getAttribute('aria-sort')") == "ascending"
    browser.run(f"{button}.click()")
    falling = browser.run(column)
    assert falling == sorted(falling, reverse=True)
    assert rising != falling


def test_filter_and_show_of_the_cell_table(browser: chromium.Browser) -> None:
    typed = "(f => {{ f.value = '{}'; f.dispatchEvent(new Event('input')) }})(document.getElementById('filter'))"
    for words, count in (("nothing like it", 0), ("diverged", 4), ("500 squat dart", 2)):
        browser.run(typed.format(words))
        assert len(texts(browser, "#celltable tbody tr")) == count
    browser.run("document.querySelector('#celltable .open').click()")
    browser.wait(f"{DETAIL}.includes('in DART')")


def test_improvement_is_old_minus_new(browser: chromium.Browser) -> None:
    browser.run("(s => { s.value = '1'; s.dispatchEvent(new Event('change')) })(document.getElementById('choose-old'))")
    browser.run("(s => { s.value = '0'; s.dispatchEvent(new Event('change')) })(document.getElementById('choose-new'))")
    first = texts(browser, "#improvement tbody td.better")[0]
    assert first.startswith("▲ +")  # the revision "new" was planted to be better
    browser.run("(s => { s.value = '0'; s.dispatchEvent(new Event('change')) })(document.getElementById('choose-old'))")
    browser.run("(s => { s.value = '1'; s.dispatchEvent(new Event('change')) })(document.getElementById('choose-new'))")
    assert texts(browser, "#improvement tbody td.worse")[0].startswith("▼ −")


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
    assert texts(shared, "#switches legend") == ["signal", "recording"]
    assert texts(shared, "#improvement h3") in ([], ["Improvement from one recording to another"])
    assert "not measured alike" not in shared.run("document.getElementById('improvement').textContent")
    assert shared.complaints == []


@pytest.mark.parametrize(("low", "high"), [(-0.5, 0.5), (-0.03, 0.03), (-9.9, 9.9), (0.0, 1.0), (-0.6, 0.1)])
def test_an_axis_has_ticks_that_tell_its_scale(browser: chromium.Browser, low: float, high: float) -> None:
    found = browser.run(f"ticks({low}, {high}, 2)")
    assert len(found) >= 2
    assert low - 1e-9 <= min(found) < max(found) <= high + 1e-9


def test_revisions_stand_one_above_the_other_on_one_scale(browser: chromium.Browser) -> None:
    labels = "[...document.querySelectorAll('#detail svg.plot')].map(n => n.getAttribute('aria-label'))"
    shown = [label for label in browser.run(labels) if "revision" in label]
    assert [label.rsplit(" ", 1)[1] for label in shown] == ["new", "old"]
    ticks = "(n => [...n.querySelectorAll('text')].map(t => t.textContent).filter(t => /^[0-9.]+$/.test(t)))"
    one, other = (
        browser.run(f"{ticks}(document.querySelector('#detail svg.plot[aria-label=\"{label}\"]'))") for label in shown
    )
    assert one == other != []


def test_tradeoffs_have_a_front(browser: chromium.Browser) -> None:
    assert browser.run("document.querySelectorAll('#plots svg.plot').length") == 2
    assert browser.run("document.querySelector('#plots .front').getAttribute('d').length") > 0


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


def test_one_joint_one_engine(shared: chromium.Browser, tmp_path: Path) -> None:
    synthetic.write_folder(tmp_path, joints=["pendulum"], cells=[synthetic.cell()], error=lambda _: 0.01)
    shared.complaints.clear()
    shared.open(write_page(tmp_path))
    shared.wait("document.querySelector('#detail svg.plot') !== null")
    assert shared.complaints == []
    assert texts(shared, ".segments span") == ["position", "velocity", "effort"]


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
    assert texts(shared, "#celltable .more") == ["Show 50 more of 1000"]
    spent = shared.run(
        "(() => { const t = performance.now(); for (const n of [0, 1, 2]) "
        "document.querySelectorAll('input[name=switch-step_rate]')[n].click(); return (performance.now() - t) / 3 })()"
    )
    assert spent < 1000  # ms per switch, on a slow machine too
    assert shared.complaints == []
