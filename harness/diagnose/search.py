"""The search: what explains most is added, judged on held-out motions, and dropped again where it became needless."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from harness.diagnose.decoys import DECOYS, KNOWN
from harness.diagnose.fit import Fit, assess, fit, start
from harness.diagnose.floors import set_floors
from harness.diagnose.pool import Pool
from harness.diagnose.problem import Change, Problem, Suspect
from harness.diagnose.screen import Screened, screen
from harness.diagnose.sensors import velocity_filters
from harness.diagnose.suspects import LATER, suspects
from harness.diagnose.worth import (
    CLEAR,
    FAR,
    GAIN,
    LEAST,
    doubt,
    explains,
    gain,
    large,
    rank,
    refusal,
    rms,
    sized,
    stands,
    worst,
)

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
TRIED = 7
"""Suspects that are fitted per round."""
SURELY = 2
"""Suspects that are fitted at least ..."""
NEAR = 0.3
"""... and the share of the best one's explanation that the others must reach."""
EQUAL = 0.03
"""Gains within this share of the best are equal: then fewer parameters win, then the order of the table."""


@dataclass
class Step:
    """One accepted finding, what the held-out motions cost before and after, all suspects as screened then, and the
    fits with those that were tried.
    """

    suspect: Suspect
    before: float
    after: float
    ranked: list[Screened] = field(default_factory=list)
    tried: list[Fit] = field(default_factory=list)


@dataclass
class Search:
    """What a search found.

    Attributes:
        base: the cost of the scenario's own model.
        fit: the accepted changes, jointly fitted.
        steps: in the order of acceptance.
        told: by the recordings themselves, which show it and its size.
        refused: sentences on suspects that were close and why they were not named.
        let_go: what was found and not named after all, because most of the gap has another cause.
        fits: those that were made under the present floors, by their first guesses.
    """

    base: Fit
    fit: Fit
    steps: list[Step] = field(default_factory=list)
    told: list[Suspect] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)
    let_go: list[Change] = field(default_factory=list)
    fits: dict[tuple[Change, ...], Fit] = field(default_factory=dict)

    def forget(self, suspect: Suspect) -> None:
        """Take out the step of a finding that does not stay."""
        self.steps = [s for s in self.steps if s.suspect != suspect]


def search(pool: Pool, say: Callable[[str], None] = lambda _: None) -> Search:
    """Find the effects that explain the gap, by forward selection with removal.

    Where that ends in nothing, because what helped first led astray, it is tried once more without that effect, and
    believed if it explains everything.
    """
    problem = pool.problem
    everyone = suspects(problem)
    found = _chain(pool, everyone, say)
    if not found.let_go or len(everyone) > MANY:
        return found
    first = found.let_go[0].suspect
    say(f"looking again without {first.effect}")
    again = _chain(pool, [s for s in everyone if s.effect != first.effect], say)
    if again.fit.changes and worst(problem, again.fit) <= CLEAR:
        return again
    set_floors(pool, [])
    found.base = found.fit = fit(problem, [], problem.of("train"), problem.of("held_out"))
    return found


def _chain(pool: Pool, everyone: Sequence[Suspect], say: Callable[[str], None]) -> Search:
    """One forward selection among the suspects."""
    problem = pool.problem
    train, judge = problem.of("train"), problem.of("held_out")
    set_floors(pool, [])
    base = fit(problem, [], train, judge)
    found = Search(base, base)
    for change in velocity_filters(problem, everyone):  # the recordings show them and tell their size
        was, seen = found.fit, fit(problem, [*found.fit.changes, change], train, judge)
        if min(was.mean_cost(cases) - seen.mean_cost(cases) for cases in (train, judge)) > LEAST:
            say(f"added {name(change.suspect)}: the recorded velocity itself shows it")
            found.steps.append(Step(change.suspect, was.mean_cost(judge), seen.mean_cost(judge)))
            found.told.append(change.suspect)
            found.fit = seen
    while len(found.fit.changes) < MOST:
        now, kept = rms(found.fit.mean_cost(train)), rms(found.fit.mean_cost(judge))
        say(f"gap {now:.2f} on training runs, {kept:.2f} held out")
        left = [found.fit.mean_cost(part) - enough(base.mean_cost(part)) for part in (train, judge)]
        if max(left) <= 0.0 or (found.fit.changes and found.fit.mean_cost(train) <= FITTED):
            break
        possible = [s for s in everyone if not _clashes(s.effect, s.indices, found.fit.changes)]
        say(f"screening {len(possible)} suspects")
        ranked = screen(pool, possible, found.fit.changes, train)
        if len(everyone) > MANY:  # of a whole body, later rounds look at what the first one saw anything in
            everyone = [s.change.suspect for s in ranked[:MANY]]
        tried = _tried(pool, found, ranked, train, judge, say)
        best = _best(pool, found, tried, train, judge)
        if best is None:
            break
        step = Step(best.changes[-1].suspect, found.fit.mean_cost(judge), best.mean_cost(judge), ranked, tried)
        if found.fit.changes and step.after > CLEAR and not large(base.mean_cost(judge), found.fit, best, judge):
            found.refused.append(_stays(step.suspect, step.before, step.after))
            break
        say(f"added {name(best.changes[-1].suspect)}: held out {rms(step.before):.2f} -> {rms(step.after):.2f}")
        found.steps.append(step)
        found.fit = best
        _set_floors(pool, found, best.changes)
        found.fit = _shaped(pool, found.fit, train, judge)
        pruned = _pruned(pool, found, train, judge, say)
        if len(pruned.changes) < len(found.fit.changes):  # the floors are those of what stays
            _set_floors(pool, found, pruned.changes)
            pruned = fit(problem, pruned.changes, train, judge)
        found.fit = pruned
    _last_look(pool, found, base.mean_cost(judge), train, judge)
    found.base = fit(problem, [], train, judge)
    _abstain_from_fragments(problem, found, judge)
    return found


def _set_floors(pool: Pool, found: Search, changes: Sequence[Change]) -> None:
    """New floors: what was fitted under others no longer counts."""
    set_floors(pool, changes)
    found.fits.clear()


def enough(base: float) -> float:
    """The mean squared residual at which nothing is left to explain, of a gap that was `base`."""
    share, most = CLOSE
    return AT_FLOOR + min(share * max(base - 1.0, 0.0), most)


def _sized(problem: Problem, found: Search, train: Sequence[int], judge: Sequence[int]) -> Fit:
    """The fit with everything free and assessed, without changes whose size cannot be told from none after all."""
    current = found.fit
    while True:
        current = _settled(problem, _all_free(problem, current, train, judge), train, judge)
        current = assess(problem, current, train, judge)
        each = [c.suspect for c in current.changes]
        unsure = [s for i, s in enumerate(each) if s not in found.told and not sized(problem, current, i)]
        if not unsure or len(each) == 1:
            return current
        gone = unsure[-1]
        found.refused.append(f"{name(gone)}: its size cannot be told from none beside the other findings")
        found.forget(gone)
        current = fit(problem, [c for c in current.changes if c.suspect != gone], train, judge)


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


def _last_look(pool: Pool, found: Search, base: float, train: Sequence[int], judge: Sequence[int]) -> None:
    """Let go what does not stand beside the other findings, until all do, under the floors of what stays."""
    problem = pool.problem
    while found.fit.changes:
        stood = len(found.fit.changes)
        found.fit = _without_fragments(pool, found, base, train, judge)
        found.fit = _sized(problem, found, train, judge)
        if len(found.fit.changes) == stood:
            return
        _set_floors(pool, found, found.fit.changes)
        found.fit = fit(problem, found.fit.changes, train, judge)


def _without_fragments(pool: Pool, found: Search, base: float, train: Sequence[int], judge: Sequence[int]) -> Fit:
    """The fit without findings that mend a little of what the others leave: beside an effect there is always one."""
    problem, current = pool.problem, found.fit
    while len(current.changes) > 1:
        least = _least_missed(pool, found, current, current.changes, train, judge)
        if least is None:
            return current
        dropped, rest = least
        if stands(base, rest, current, judge, left=worst(problem, current), repeated=problem.repeated):
            return current
        found.refused.append(_stays(dropped, rest.mean_cost(judge), current.mean_cost(judge)))
        found.forget(dropped)
        current = rest
    return current


def _least_missed(
    pool: Pool, found: Search, current: Fit, among: Sequence[Change], train: Sequence[int], judge: Sequence[int]
) -> tuple[Suspect, Fit] | None:
    """The change that held-out motions miss least, and the fit without it; what the recordings told stays."""
    dropped = [c for c in among if c.suspect not in found.told]
    without = [tuple(c for c in current.changes if c is not drop) for drop in dropped]
    new = [rest for rest in without if rest not in found.fits]
    found.fits |= zip(new, pool.map(fit, [(rest, train, judge) for rest in new]), strict=True)
    ways = [(drop.suspect, found.fits[rest]) for drop, rest in zip(dropped, without, strict=True)]
    return min(ways, key=lambda way: way[1].mean_cost(judge), default=None)


def _stays(suspect: Suspect, was: float, left: float) -> str:
    return f"{name(suspect)}: held-out gap {rms(was):.2f} -> {rms(left):.2f}, and the rest stays"


def _abstain_from_fragments(problem: Problem, found: Search, judge: Sequence[int]) -> None:
    """Name nothing where all that was found leaves most of the gap: what mends a little of it is not its cause."""
    explained = explains(found.base, found.fit, judge, left=worst(problem, found.fit), repeated=problem.repeated)
    if explained or not found.fit.changes:
        return
    was, left = found.base.mean_cost(judge), found.fit.mean_cost(judge)
    for change in found.fit.changes:
        found.refused.append(
            f"{name(change.suspect)}: held-out gap {rms(was):.2f} -> {rms(left):.2f} with all findings: most of it "
            "has another cause"
        )
    found.let_go = [c for c in found.fit.changes if c.suspect not in found.told]
    found.fit, found.steps = found.base, []


def name(suspect: Suspect) -> str:
    """An effect and its target, for people."""
    target = suspect.target if isinstance(suspect.target, str) else ", ".join(suspect.target)
    return f"{suspect.effect} at {target}{' (outside the list)' * (suspect.effect in DECOYS)}"


def _clashes(effect: str, indices: Sequence[int], accepted: Sequence[Change]) -> bool:
    """Whether an effect is already there, or excluded by one that is, at one of the targets."""
    for change in accepted:
        other = change.suspect
        if set(indices) & set(other.indices) and (
            effect == other.effect or effect in KNOWN[other.effect].excludes or other.effect in KNOWN[effect].excludes
        ):
            return True
    return False


def _tried(
    pool: Pool,
    found: Search,
    ranked: Sequence[Screened],
    train: Sequence[int],
    judge: Sequence[int],
    say: Callable[[str], None],
) -> list[Fit]:
    """The fits with one more suspect, for those that promise most."""
    chosen = _varied(ranked)
    say("fitting " + ", ".join(name(s.change.suspect) for s in chosen))
    return pool.map(fit, [([*found.fit.changes, s.change], train, judge) for s in chosen])


def _best(pool: Pool, found: Search, fits: Sequence[Fit], train: Sequence[int], judge: Sequence[int]) -> Fit | None:
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


def _shaped(pool: Pool, current: Fit, train: Sequence[int], judge: Sequence[int]) -> Fit:
    """The fit with the shape of the last finding freed, where that helps on held-out motions."""
    last = current.changes[-1]
    more = LATER.get(last.suspect.effect)
    if more is None:
        return fit(pool.problem, current.changes, train, judge)
    freed = [*current.changes[:-1], replace(last, free=more)]
    plain, rich = pool.map(fit, [(current.changes, train, judge), (freed, train, judge)])
    return rich if rich.mean_cost(judge) < 0.97 * plain.mean_cost(judge) else plain


def _pruned(pool: Pool, found: Search, train: Sequence[int], judge: Sequence[int], say: Callable[[str], None]) -> Fit:
    """The fit without findings that later ones made needless."""
    current = found.fit
    while len(current.changes) > 1:
        least = _least_missed(pool, found, current, current.changes[:-1], train, judge)
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
