"""Confirming findings in other engines: what helps in one engine only is that engine's artefact."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from realitygap_engines import Diverged, Unsupported

from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.data.problem import WORST, Change, Problem, Suspect
from realitygap.diagnose.fit.fit import assess, fit
from realitygap.diagnose.search.found import Found, name

HELPS = 0.97
"""A finding helps in an engine where it brings the held-out gap below this part of what it was."""
ALIKE = 0.75
"""... and where it lowers the mean square by at least this share of what it does in the searching engine: what helps
half as much elsewhere mends that engine's own error."""


@dataclass
class Confirmed:
    """The held-out gap before and after one finding, in the searching engine and in others."""

    before: float
    after: float
    engines: dict[str, tuple[float, float]] = field(default_factory=dict)


def confirm(
    pool: Pool, found: Found, others: Sequence[str], say: Callable[[str], None]
) -> tuple[dict[Suspect, Confirmed], list[str]]:
    """The gap after each finding, engine by engine; findings that help nowhere else are dropped, with a sentence."""
    problem = pool.problem
    judge = problem.of("held_out")
    notes: list[str] = []
    while True:
        changes = found.fit.changes
        out = _prefixes(pool, changes, [problem.engine, *others], judge)
        alone = [
            s
            for s, c in out.items()
            if c.engines and _helps(c.before, c.after) and not any(agrees(c, pair) for pair in c.engines.values())
        ]
        if not alone:
            return out, notes
        drop = alone[-1]
        sentence = (
            f"{name(drop)} helps in {problem.engine} far more than in any other engine, which makes it an artefact of "
            f"{problem.engine}: not named"
        )
        say(sentence)
        notes.append(sentence)
        found.forget(drop)
        rest = [c for c in changes if c.suspect != drop]
        found.fit = fit(problem, rest, problem.of("train"), judge)
        if rest:
            found.fit = assess(problem, found.fit, problem.of("train"), judge)


def agrees(finding: Confirmed, there: tuple[float, float]) -> bool:
    """Whether another engine has the gap before and after that says the same of a finding."""
    before, after = there
    lowered = finding.before**2 - finding.after**2
    return _helps(before, after) and before**2 - after**2 >= ALIKE * lowered


def _helps(before: float, after: float) -> bool:
    return after < HELPS * before


def _prefixes(
    pool: Pool, changes: Sequence[Change], names: Sequence[str], judge: Sequence[int]
) -> dict[Suspect, Confirmed]:
    """The held-out gap with the first, the first two, ... findings, in every engine."""
    counts = range(len(changes) + 1)
    questions = [(tuple(changes[:k]), e, c) for e in names for k in counts for c in judge]
    costs = dict(zip(questions, pool.map(_cost, questions), strict=True)) if changes else {}
    out: dict[Suspect, Confirmed] = {}
    for k, change in enumerate(changes):
        pairs = {}
        for e in names:
            gaps = [np.sqrt(np.mean([costs[tuple(changes[:m]), e, c] for c in judge])) for m in (k, k + 1)]
            if max(gaps) < np.sqrt(WORST):
                pairs[e] = (float(gaps[0]), float(gaps[1]))
        searched = pairs.pop(names[0], (float("nan"), float("nan")))
        out[change.suspect] = Confirmed(*searched, pairs)
    return out


def _cost(problem: Problem, changes: tuple[Change, ...], engine: str, case: int) -> float:
    try:
        simulated = problem.simulated(changes, case, engine=engine)
    except (Diverged, Unsupported):
        return WORST
    return float(np.mean(problem.residual(case, simulated) ** 2))
