"""Words of a scenario, which stand between backticks in our sentences, are code on a page."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.result.diagnosis import Diagnosis
from realitygap.page.coded import with_code
from told_story import page_of


def test_the_keys_of_a_servo_are_code(told: Callable[[str], Diagnosis], tmp_path: Path) -> None:
    result = told("partly explained")
    gain = Suspect("controller_gain", "elbow", (1,))
    changes = (*result.changes, Change(gain, (("gain", 5.2),), ("gain",)))
    shown = {**result.shown, gain: next(iter(result.shown.values()))}
    text, page, _ = page_of(replace(result, changes=changes, shown=shown), tmp_path)
    assert not page.open, "an element is left open"
    assert "<code>gain</code> in duty/rad of a dc servo, <code>kp</code> in N·m/rad" in text
    assert "`" not in text


@pytest.mark.parametrize(
    ("page", "coded"),
    [
        ("<p>say `held: false` or `as: effort`</p>", "<p>say <code>held: false</code> or <code>as: effort</code></p>"),
        ('<a href="`a`">b</a>', '<a href="`a`">b</a>'),
        ("<p>one ` alone</p><p>and ` one</p>", "<p>one ` alone</p><p>and ` one</p>"),
        ("<script>f(`${a < b}`)</script>`c`", "<script>f(`${a < b}`)</script><code>c</code>"),
        ("<title>`a`</title><h1>a</h1>", "<title>`a`</title><h1>a</h1>"),
        ("<svg><text>`a`</text></svg>", "<svg><text>`a`</text></svg>"),
    ],
)
def test_only_text_between_backticks_is(page: str, coded: str) -> None:
    assert with_code(page) == coded
