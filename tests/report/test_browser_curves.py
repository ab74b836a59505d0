"""The curves of the page in a real browser: pointer, fingers, buttons and keys look closer and read values out."""

from typing import Any

import chromium
import pytest
from invented_page import CELL


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


def test_hover_reads_the_values_out(browser: chromium.Browser) -> None:
    browser.run("document.querySelector('#detail svg.plot').scrollIntoView({block: 'center'})")
    box = browser.run(
        "(r => [r.x, r.y, r.width, r.height])(document.querySelector('#detail svg.plot').getBoundingClientRect())"
    )
    browser.move(box[0] + box[2] / 2, box[1] + box[3] / 2)
    shown = [t for t in browser.texts("#detail .toggles output") if t]
    assert len(shown) == 5  # measured, three engines, time
    assert sum(t.endswith("°") for t in shown) == 4


def test_keys_move_the_cursor_of_a_plot(browser: chromium.Browser) -> None:
    browser.run("document.querySelector('#detail figure').focus()")
    browser.press("ArrowRight")
    assert any(t.startswith("at 0.0") for t in browser.texts("#detail .toggles output"))


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


def test_nothing_is_drawn_over_the_name_of_an_axis(browser: chromium.Browser) -> None:
    touching = """[...document.querySelectorAll('#detail svg.plot')].flatMap(svg => {
      const named = svg.querySelector('text.name');
      if (!named || !svg.querySelector('path.line')) return [];
      const a = named.getBoundingClientRect();
      return [...svg.querySelectorAll('path.line, text:not(.name)')].map(n => n.getBoundingClientRect()).map(
        b => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom); })"""
    found = browser.run(touching)
    assert len(found) > 10
    assert not any(found)
