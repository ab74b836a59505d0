"""Setting aside what is explained by something that is not on the list of effects."""

from __future__ import annotations

from collections.abc import Callable

from realitygap.diagnose.data.decoys import DECOYS
from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.fit.fit import Fit, assess, costs
from realitygap.diagnose.search.found import Found, name
from realitygap.diagnose.search.worth import refusal, rms


def set_aside(pool: Pool, found: Found, say: Callable[[str], None]) -> list[str]:
    """Take decoys out of what was found; returns a sentence for each.

    What stays is judged without them: where it mends nothing then, it only mended them, and is not named either.
    """
    problem = pool.problem
    train, judge = problem.of("train"), problem.of("held_out")
    decoys = [c for c in found.fit.changes if c.suspect.effect in DECOYS]
    if not decoys:
        return []
    notes = []
    for change in decoys:
        step = next((s for s in found.steps if s.suspect == change.suspect), None)
        values = ", ".join(f"{n} {v:.3g} {DECOYS[change.suspect.effect].parameter(n).unit}" for n, v in change.values)
        gain = f": held-out gap {rms(step.before):.2f} -> {rms(step.after):.2f} with it" if step else ""
        notes.append(
            f"outside the list of effects: what is seen at {change.suspect.target} looks like a "
            f"{change.suspect.effect.replace('_', ' ')} ({values}){gain}; it is not named as a finding"
        )
    named = [c for c in found.fit.changes if c.suspect.effect not in DECOYS]
    kept = Fit(named, costs(problem, named, [*train, *judge])) if named else found.base
    reason = refusal(found.base, kept, train, judge)
    if reason is None:
        found.fit = assess(problem, kept, train, judge)
        found.steps = [s for s in found.steps if s.suspect.effect not in DECOYS]
    else:
        found.refused += [f"{name(c.suspect)}: {reason}, without what is not on the list" for c in named]
        found.fit, found.steps = found.base, []
    for note in notes:
        say(note)
    return notes
