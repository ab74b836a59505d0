"""The page in a real browser: it loads without complaint, and map, switches, sorting and keyboard work."""

import chromium
import numpy as np
import pytest
from invented_page import CELL, DETAIL, JOINTS
from realitygap.page.style import number


def test_it_shows_engines_joints_and_curves(browser: chromium.Browser) -> None:
    assert browser.texts(".heat thead th") == ["DART", "Drake", "MuJoCo"]
    assert set(JOINTS) <= set(browser.texts(".heat th[scope=row]"))
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


def test_what_did_not_finish_is_told_once(browser: chromium.Browser) -> None:
    browser.run("document.querySelectorAll('input[name=switch-step_rate]')[0].click()")
    browser.run(f"{CELL.format(0, 0)}.dispatchEvent(new MouseEvent('click', {{bubbles: true}}))")
    browser.wait(f"{DETAIL}.includes('in DART')")
    assert set(browser.texts("#detail .verdict")) == {"diverged at 1.2000 s at knee: not finite"}


@pytest.mark.parametrize("axis", ["signal", "recording", "robot_revision", "step_rate"])
def test_switches_change_the_map(browser: chromium.Browser, axis: str) -> None:
    before = browser.texts(".heat td")
    name = f"input[name=switch-{axis}]"
    other = browser.run(
        f"(n => (n.click(), n.parentElement.textContent))(document.querySelector('{name}:not(:checked)'))"
    )
    assert browser.texts(".heat td") != before
    assert browser.run(f"document.querySelector('{name}:checked').parentElement.textContent") == other


def test_a_failed_cell_is_told_in_words(browser: chromium.Browser) -> None:
    browser.run("[...document.querySelectorAll('input[name=switch-step_rate]')][0].click()")
    assert browser.texts(".heat tbody td")[0] == "diverged"
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
        assert len(browser.texts("#celltable tbody tr")) == count
    browser.run("document.querySelector('#celltable .open').click()")
    browser.wait(f"{DETAIL}.includes('in DART')")


def test_improvement_is_old_minus_new(browser: chromium.Browser) -> None:
    browser.run("(s => { s.value = '1'; s.dispatchEvent(new Event('change')) })(document.getElementById('choose-old'))")
    browser.run("(s => { s.value = '0'; s.dispatchEvent(new Event('change')) })(document.getElementById('choose-new'))")
    first = browser.texts("#improvement tbody td.better")[0]
    assert first.startswith("▲ +")  # the revision "new" was planted to be better
    browser.run("(s => { s.value = '0'; s.dispatchEvent(new Event('change')) })(document.getElementById('choose-old'))")
    browser.run("(s => { s.value = '1'; s.dispatchEvent(new Event('change')) })(document.getElementById('choose-new'))")
    assert browser.texts("#improvement tbody td.worse")[0].startswith("▼ −")


def test_tradeoffs_have_a_front(browser: chromium.Browser) -> None:
    assert browser.run("document.querySelectorAll('#plots svg.plot').length") == 2
    assert browser.run("document.querySelector('#plots .front').getAttribute('d').length") > 0


@pytest.mark.parametrize(
    ("value", "said"),
    [(8.44e-5, "8.44·10⁻⁵"), (-3.7e-12, "−3.70·10⁻¹²"), (-2.5e7, "−2.50·10⁷"), (1e6, "1.00·10⁶"), (1e-4, "0.000100")],
)
def test_very_large_and_small_numbers_are_written_as_people_do(
    browser: chromium.Browser, value: float, said: str
) -> None:
    assert number(value) == said
    assert browser.run(f"number({value!r})") == said


def test_a_tick_of_an_axis_is_written_as_people_do(browser: chromium.Browser) -> None:
    assert browser.run("[0, 2e5, -4e5].map((v, _, all) => tickText(v, all))") == ["0", "2·10⁵", "−4·10⁵"]
