"""The choice: what is screened, which suspects are fitted, and which of the fits is added."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from realitygap.diagnose.data.decoys import KNOWN
from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.data.problem import Change, Suspect
from realitygap.diagnose.fit.fit import Fit, assess, fit
from realitygap.diagnose.search.found import Found, Step, name
from realitygap.diagnose.search.screen import Screened, screen
from realitygap.diagnose.search.worth import doubt, gain, rank, refusal

TRIED = 7
"""Suspects that are fitted per round."""
SURELY = 2
"""Suspects that are fitted at least ..."""
NEAR = 0.3
"""... and the share of the best one's explanation that the others must reach."""
EQUAL = 0.03
"""Gains within this share of the best are equal: then fewer parameters win, then the order of the table."""


def choose(
    pool: Pool,
    found: Found,
    everyone: Sequence[Suspect],
    train: Sequence[int],
    judge: Sequence[int],
    say: Callable[[str], None],
    *also: Fit,
) -> tuple[Fit, Step] | None:
    """The best fit with one more suspect, and the step to it; None where none is worth it.

    Args:
        pool: of the problem, with its floors set.
        found: so far.
        everyone: suspects; those that clash with what was found are left out.
        train: cases to fit to.
        judge: cases to judge on.
        say: told what is being done.
        also: further fits with one more suspect that compete.
    """
    possible = [s for s in everyone if not clashes(s, found.fit.changes)]
    say(f"screening {len(possible)} suspects")
    ranked = screen(pool, possible, found.fit.changes, train)
    chosen = _varied(ranked)
    say("fitting " + ", ".join(name(s.change.suspect) for s in chosen))
    tried = [*also, *pool.map(fit, [([*found.fit.changes, s.change], train, judge) for s in chosen])]
    best = _best(pool, found, tried, train, judge)
    if best is None:
        return None
    return best, Step(best.changes[-1].suspect, found.fit.mean_cost(judge), best.mean_cost(judge), ranked, tried)


def clashes(suspect: Suspect, accepted: Sequence[Change]) -> bool:
    """Whether an effect is already there, or excluded by one that is, at one of its targets."""
    effect = suspect.effect
    for other in (change.suspect for change in accepted):
        if set(suspect.indices) & set(other.indices) and (
            effect == other.effect or effect in KNOWN[other.effect].excludes or other.effect in KNOWN[effect].excludes
        ):
            return True
    return False


def _best(pool: Pool, found: Found, fits: Sequence[Fit], train: Sequence[int], judge: Sequence[int]) -> Fit | None:
    """The best of the fits with one more suspect; None where none is worth it."""
    problem = pool.problem
    now = found.fit
    helping = [f for f in fits if refusal(now, f, train, judge) is None]
    assessed = pool.map(assess, [(f, train, judge) for f in helping])
    worthy = [f for f in assessed if doubt(problem, f, judge) is None]
    for candidate in [*(f for f in fits if f not in helping), *assessed]:
        reason = refusal(now, candidate, train, judge) or doubt(problem, candidate, judge)
        if reason and candidate.mean_cost(judge) < 0.8 * now.mean_cost(judge):
            found.refused.append(f"{name(candidate.changes[-1].suspect)}: {reason}")
    if not worthy:
        return None
    gains = [gain(now, f, train, judge) for f in worthy]
    top = max(gains)
    equal = [f for f, g in zip(worthy, gains, strict=True) if g >= top - EQUAL * abs(top)]

    def simplicity(candidate: Fit) -> tuple[int, float]:
        last = candidate.changes[-1]
        return len(last.free), rank(problem, last.suspect)

    return min(equal, key=simplicity)


def _varied(ranked: Sequence[Screened]) -> list[Screened]:
    """The best suspects, at most two starts of one and three targets of one effect, while they are near the best."""
    out: list[Screened] = []
    for s in ranked:
        if len(out) >= SURELY and s.explained < NEAR * ranked[0].explained:
            break
        same = [o for o in out if o.change.suspect == s.change.suspect]
        kin = [o for o in out if o.change.suspect.effect == s.change.suspect.effect]
        if len(same) < 2 and len(kin) < 3 and s.explained > 0.01:
            out.append(s)
        if len(out) == TRIED:
            break
    return out
