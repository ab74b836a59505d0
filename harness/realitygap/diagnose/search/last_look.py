"""The last look at all findings together: what does not stand beside the others is let go."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.data.problem import Change, Problem, Suspect
from realitygap.diagnose.data.worsened import hurt
from realitygap.diagnose.fit.fit import Fit, assess, fit, start
from realitygap.diagnose.likelihood.floors import set_floors
from realitygap.diagnose.search.found import Found, name
from realitygap.diagnose.search.worth import FAR, absurd, explains, rms, sized, stands, worst

UNSURE = "its size cannot be told from none"


def last_look(pool: Pool, found: Found, base: float, train: Sequence[int], judge: Sequence[int]) -> None:
    """Let go what does not stand beside the other findings, until all do, under the floors of what stays."""
    problem = pool.problem
    while found.fit.changes:
        stood = len(found.fit.changes)
        found.fit = _without_fragments(pool, found, base, train, judge)
        found.fit = _sized(problem, found, train, judge)
        if len(found.fit.changes) == stood:
            return
        new_floors(pool, found, found.fit.changes)
        found.fit = fit(problem, found.fit.changes, train, judge)


def _without_fragments(pool: Pool, found: Found, base: float, train: Sequence[int], judge: Sequence[int]) -> Fit:
    """The fit without findings that mend a little of what the others leave: beside an effect there is always one."""
    problem, current = pool.problem, found.fit
    while len(current.changes) > 1:
        least = least_missed(pool, found, current, current.changes, train, judge)
        if least is None:
            return current
        dropped, rest = least
        if stands(base, rest, current, judge, left=worst(problem, current), repeated=problem.repeated):
            return current
        found.refused.append(stays(dropped, rest.mean_cost(judge), current.mean_cost(judge)))
        found.forget(dropped)
        current = rest
    return current


def least_missed(
    pool: Pool, found: Found, current: Fit, among: Sequence[Change], train: Sequence[int], judge: Sequence[int]
) -> tuple[Suspect, Fit] | None:
    """The change that held-out motions miss least, and the fit without it; what the recordings told stays, and so does
    what keeps the others from becoming absurd.
    """
    dropped = [c for c in among if c.suspect not in found.told]
    without = [tuple(c for c in current.changes if c is not drop) for drop in dropped]
    new = [rest for rest in without if rest not in found.fits]
    found.fits |= zip(new, pool.map(fit, [(rest, train, judge) for rest in new]), strict=True)
    ways = [(drop.suspect, found.fits[rest]) for drop, rest in zip(dropped, without, strict=True)]
    ways = [way for way in ways if not any(absurd(c) for c in way[1].changes)]
    return min(ways, key=lambda way: way[1].mean_cost(judge), default=None)


def _sized(problem: Problem, found: Found, train: Sequence[int], judge: Sequence[int]) -> Fit:
    """The fit with everything free and assessed, without changes that became absurd beside the others, or whose size
    cannot be told from none after all.
    """
    current = found.fit
    while current.changes:
        current = _settled(problem, _all_free(problem, current, train, judge), train, judge)
        current = assess(problem, current, train, judge)
        each = [(i, c) for i, c in enumerate(current.changes) if c.suspect not in found.told]
        alone = len(current.changes) == 1
        unsure = {c.suspect: UNSURE for i, c in each if not alone and not sized(problem, current, i)}
        unsure |= {c.suspect: reason for _, c in each if (reason := absurd(c)) is not None}
        if not unsure:
            return current
        gone, reason = unsure.popitem()
        found.refused.append(f"{name(gone)}: {reason} beside the other findings")
        found.forget(gone)
        current = fit(problem, [c for c in current.changes if c.suspect != gone], train, judge)
    return current


def _settled(problem: Problem, current: Fit, train: Sequence[int], judge: Sequence[int]) -> Fit:
    """The fit with what it leaves unexplained counted as noise, where that is far more than the sensors'."""
    left = current.mean_cost(train)
    return current if left <= FAR else fit(problem, current.changes, train, judge, misfit=rms(left))


def _all_free(problem: Problem, current: Fit, train: Sequence[int], judge: Sequence[int]) -> Fit:
    """The fit with what was told by the recordings fitted as well, unless what is missing still would distort it."""
    if current.mean_cost(train) > FAR:
        return current
    free = [replace(c, free=c.free or start(problem, c.suspect).free) for c in current.changes]
    return current if free == current.changes else fit(problem, free, train, judge)


def stays(suspect: Suspect, was: float, left: float) -> str:
    """Why a suspect is not named that helps a little, from the held-out costs without and with it."""
    return f"{name(suspect)}: held-out gap {rms(was):.2f} -> {rms(left):.2f}, and the rest stays"


def abstain(problem: Problem, found: Found, judge: Sequence[int]) -> None:
    """Name nothing where all that was found leaves most of the gap, or makes a signal far worse."""
    if not found.fit.changes:
        return
    was, left = found.base.mean_cost(judge), found.fit.mean_cost(judge)
    before, after = (problem.simulations(f.changes, judge) for f in (found.base, found.fit))
    reasons = [f"{signal} gets far worse with all findings" for signal in hurt(problem, judge, before, after)]
    if not explains(found.base, found.fit, judge, left=worst(problem, found.fit), repeated=problem.repeated):
        reasons.append(
            f"held-out gap {rms(was):.2f} -> {rms(left):.2f} with all findings: most of it has another cause"
        )
    if reasons:
        found.refused += [f"{name(change.suspect)}: {reasons[0]}" for change in found.fit.changes]
        found.let_go = [c for c in found.fit.changes if c.suspect not in found.told]
        found.fit, found.steps = found.base, []


def new_floors(pool: Pool, found: Found, changes: Sequence[Change]) -> None:
    """New floors: what was fitted under others no longer counts."""
    set_floors(pool, changes)
    found.fits.clear()
