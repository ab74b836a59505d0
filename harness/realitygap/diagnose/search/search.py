"""The search: what explains most is added, judged on held-out motions, and dropped again where it became needless."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from realitygap.diagnose.candidates.suspects import richer, suspects
from realitygap.diagnose.data.decoys import DECOYS
from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.data.problem import Problem, Suspect
from realitygap.diagnose.data.split import keep_back
from realitygap.diagnose.fit.fit import Fit, fit
from realitygap.diagnose.likelihood.floors import set_floors
from realitygap.diagnose.search.choice import choose
from realitygap.diagnose.search.exchange import exchange
from realitygap.diagnose.search.found import Found, Step, name
from realitygap.diagnose.search.last_look import abstain, last_look, least_missed, new_floors, stays
from realitygap.diagnose.search.sensors import velocity_filters
from realitygap.diagnose.search.worth import CLEAR, FAR, GAIN, LEAST, large, much_left, rms, worst

AT_FLOOR = 1.25
"""A mean squared residual up to this is what noise alone would give."""
CLOSE = (0.002, 0.4)
"""Nor is what is left of a gap, up to this share of it and this much, to be explained: no model is as exact."""
FITTED = 1.1
"""Training runs with a mean squared residual up to this tell nothing more, whatever the others leave."""
MOST = 6
"""Findings at most."""
MANY = 120
"""Suspects that are looked at again after the first round, at most."""
LESS = 0.25
"""The share of what a search leaves, in mean squares, which another one may leave to be believed instead."""
UNLIKE = 25.0
"""A training run shows a gap of its own where its cost is this many times that of any held-out run (five times the
gap)."""


def search(pool: Pool, say: Callable[[str], None] = lambda _: None) -> Found:
    """Find the effects that explain the gap, by forward selection with removal.

    Where that ends in nothing or leaves much, because what helped first led astray, it is tried once more without that
    effect, and believed if it explains everything, or leaves far less than what was found with it.
    """
    problem = pool.problem
    everyone = suspects(problem)
    base = _unchanged(pool)
    if said := keep_back(problem.cases, alone(problem, base)):
        problem.split = "; ".join(filter(None, [problem.split, said]))
        base = _unchanged(pool)
    found = _chain(pool, everyone, base, say)
    first = misleading(problem, found)
    if first is None or len(everyone) > MANY:
        return found
    say(f"looking again without {first.effect}")
    kept = [replace(c, noise=dict(c.noise)) for c in problem.cases]  # the floors under which it was found
    again = _chain(pool, [s for s in everyone if s.effect != first.effect], _unchanged(pool), say)
    most = CLEAR if found.let_go else max(CLEAR, LESS * worst(problem, found.fit))
    if again.fit.changes and worst(problem, again.fit) <= most:
        return again
    problem.cases = kept
    pool.renew()
    if found.let_go:
        found.base = found.fit = _unchanged(pool)
    return found


def _unchanged(pool: Pool) -> Fit:
    """The model as it is, under its own floors."""
    set_floors(pool, [])
    return fit(pool.problem, [], pool.problem.of("train"), pool.problem.of("held_out"))


def alone(problem: Problem, base: Fit) -> list[int]:
    """The training runs that show a gap as no held-out run does."""
    shown = max(base.cost[c] for c in problem.of("held_out"))
    least = FAR if shown <= CLEAR else UNLIKE * shown
    return [c for c in problem.of("train") if base.cost[c] > least]


def misleading(problem: Problem, found: Found) -> Suspect | None:
    """What was found first, where that may have led astray: all was let go, or much of a gap stays far from the floor.

    What is not on the list of effects does not count: without it the search would only blame another for it.
    """
    if found.let_go:
        return found.let_go[0].suspect
    first = next((s.suspect for s in found.steps if s.suspect not in found.told), None)
    if first is None or first.effect in DECOYS or not much_left(problem, found.base, found.fit):
        return None
    return first


def _chain(pool: Pool, everyone: Sequence[Suspect], base: Fit, say: Callable[[str], None]) -> Found:
    """One forward selection among the suspects, from the model as it is."""
    problem = pool.problem
    train, judge = problem.of("train"), problem.of("held_out")
    found = Found(base, base)
    for change in velocity_filters(problem, everyone):  # the recordings show them and tell their size
        was, seen = found.fit, fit(problem, [*found.fit.changes, change], train, judge)
        if min(was.mean_cost(cases) - seen.mean_cost(cases) for cases in (train, judge)) > LEAST:
            say(f"added {name(change.suspect)}: the recorded velocity itself shows it")
            found.steps.append(Step(change.suspect, was.mean_cost(judge), seen.mean_cost(judge)))
            found.told.append(change.suspect)
            found.fit = seen
    _forward(pool, found, everyone, say)
    for _ in range(MOST):
        if not exchange(pool, found, train, judge, say):
            break
        _forward(pool, found, everyone, say)
    _choose_again(pool, found, everyone, train, judge, say)
    last_look(pool, found, base.mean_cost(judge), train, judge)
    found.base = fit(problem, [], train, judge)
    abstain(problem, found, judge)
    return found


def _forward(pool: Pool, found: Found, everyone: Sequence[Suspect], say: Callable[[str], None]) -> None:
    """Add what helps most, as long as something does and is worth it."""
    problem, base = pool.problem, found.base
    train, judge = problem.of("train"), problem.of("held_out")
    while len(found.fit.changes) < MOST:
        now, kept = rms(found.fit.mean_cost(train)), rms(found.fit.mean_cost(judge))
        say(f"gap {now:.2f} on training runs, {kept:.2f} held out")
        left = [found.fit.mean_cost(part) - enough(base.mean_cost(part)) for part in (train, judge)]
        if max(left) <= 0.0 or (found.fit.changes and found.fit.mean_cost(train) <= FITTED):
            break
        chosen = choose(pool, found, _near(everyone, found), train, judge, say)
        if chosen is None:
            break
        best, step = chosen
        if found.fit.changes and step.after > CLEAR and not large(base.mean_cost(judge), found.fit, best, judge):
            found.refused.append(stays(step.suspect, step.before, step.after))
            break
        say(f"added {name(step.suspect)}: held out {rms(step.before):.2f} -> {rms(step.after):.2f}")
        found.steps.append(step)
        found.fit = best
        new_floors(pool, found, best.changes)
        found.fit = _shaped(pool, found.fit, train, judge)
        pruned = _pruned(pool, found, train, judge, say)
        if len(pruned.changes) < len(found.fit.changes):  # the floors are those of what stays
            new_floors(pool, found, pruned.changes)
            pruned = fit(problem, pruned.changes, train, judge)
        found.fit = pruned


def _near(everyone: Sequence[Suspect], found: Found) -> Sequence[Suspect]:
    """Of a whole body, after the first round, what that one saw anything in."""
    ranked = next((step.ranked for step in found.steps if step.ranked), [])
    return [s.change.suspect for s in ranked[:MANY]] if ranked and len(everyone) > MANY else everyone


def _choose_again(
    pool: Pool,
    found: Found,
    everyone: Sequence[Suspect],
    train: Sequence[int],
    judge: Sequence[int],
    say: Callable[[str], None],
) -> None:
    """What was chosen beside a finding that did not stay is chosen once more, beside those that did."""
    problem = pool.problem
    for number, step in enumerate(found.steps):
        kept = found.fit
        beside = {c.suspect for f in step.tried for c in f.changes[:-1]}
        if beside <= {c.suspect for c in kept.changes}:
            continue
        say(f"looking again in place of {name(step.suspect)}")
        own = [c for c in kept.changes if c.suspect == step.suspect]
        others = [c for c in kept.changes if c not in own]
        found.fit = fit(problem, others, train, judge)
        same = fit(problem, [*found.fit.changes, *own], train, judge)
        chosen = choose(pool, found, _near(everyone, found), train, judge, say, same)
        if chosen is None:
            found.fit = kept
            continue
        found.fit, found.steps[number] = chosen
        newest = found.steps[number].suspect
        if newest != step.suspect:
            say(f"added {name(newest)} in its place")
            new_floors(pool, found, found.fit.changes)
            found.fit = _shaped(pool, found.fit, train, judge)


def enough(base: float) -> float:
    """The mean squared residual at which nothing is left to explain, of a gap that was `base`."""
    share, most = CLOSE
    return AT_FLOOR + min(share * max(base - 1.0, 0.0), most)


def _shaped(pool: Pool, current: Fit, train: Sequence[int], judge: Sequence[int]) -> Fit:
    """The fit with the shape of the last finding freed, where that helps on held-out motions."""
    more = richer(pool.problem.plant, current.changes[-1])
    if more is None:
        return fit(pool.problem, current.changes, train, judge)
    freed = [*current.changes[:-1], more]
    plain, rich = pool.map(fit, [(current.changes, train, judge), (freed, train, judge)])
    return rich if rich.mean_cost(judge) < 0.97 * plain.mean_cost(judge) else plain


def _pruned(pool: Pool, found: Found, train: Sequence[int], judge: Sequence[int], say: Callable[[str], None]) -> Fit:
    """The fit without findings that later ones made needless."""
    current = found.fit
    while len(current.changes) > 1:
        least = least_missed(pool, found, current, current.changes[:-1], train, judge)
        if least is None:
            return current
        needless, rest = least
        lost = rest.mean_cost(judge) - current.mean_cost(judge)
        if lost >= 0.5 * LEAST and lost >= 0.5 * GAIN * max(rest.mean_cost(judge) - 1.0, 0.0):
            return current
        say(f"dropped {name(needless)}: needless now")
        found.forget(needless)
        current = rest
    return current
