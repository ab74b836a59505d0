"""The exchange: a finding that was chosen before others were known makes room for what explains more beside them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.fit.fit import Fit, assess, fit
from realitygap.diagnose.fit.probes import crowded
from realitygap.diagnose.search.choice import clashes
from realitygap.diagnose.search.found import Found, Step, name
from realitygap.diagnose.search.last_look import new_floors
from realitygap.diagnose.search.worth import CLEAR, doubt, gain, lowered, much_left, worst

LOWER = 0.1
"""How much lower both costs are, in log terms, with what takes the place of a finding."""


def exchange(pool: Pool, found: Found, train: Sequence[int], judge: Sequence[int], say: Callable[[str], None]) -> bool:
    """Put another suspect in the place of a finding that others followed, where it explains more beside those.

    Tried are the suspects that were fitted when it was chosen: the same effect elsewhere, and where much is left all
    of them, unless the joints are many. Where nearly everything is explained there is nothing to exchange.

    Returns:
        Whether a finding was replaced.
    """
    if worst(pool.problem, found.fit) <= CLEAR:
        return False
    alike = crowded(pool.problem) or not much_left(pool.problem, found.base, found.fit)
    for number, step in enumerate(found.steps[:-1]):
        best = _in_place_of(pool, found, step, train, judge, alike=alike)
        if best is None:
            continue
        newest = best.changes[-1].suspect
        after = min(f.mean_cost(judge) for f in step.tried if f.changes[-1].suspect == newest)
        say(f"added {name(newest)} in place of {name(step.suspect)}")
        found.steps[number] = replace(step, suspect=newest, after=after)
        new_floors(pool, found, best.changes)
        found.fit = fit(pool.problem, best.changes, train, judge)
        return True
    return False


def _in_place_of(
    pool: Pool, found: Found, step: Step, train: Sequence[int], judge: Sequence[int], *, alike: bool
) -> Fit | None:
    """The best fit with another suspect instead of a finding; None where none is clearly better."""
    others = [c for c in found.fit.changes if c.suspect != step.suspect]
    instead = [
        f.changes[-1]
        for f in step.tried
        if (s := f.changes[-1].suspect) != step.suspect
        and not (alike and s.effect != step.suspect.effect)
        and not clashes(s, others)
    ]
    fits = pool.map(fit, [([*others, change], train, judge) for change in instead])
    better = [f for f in fits if min(lowered(found.fit, f, cases) for cases in (train, judge)) > LOWER]
    if not better:
        return None
    best = assess(pool.problem, max(better, key=lambda f: gain(found.fit, f, train, judge)), train, judge)
    return best if doubt(pool.problem, best, judge) is None else None
