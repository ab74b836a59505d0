"""What recordings say of the explanations that were open before them: odds, refitted, and what a diagnosis names."""

import json
from collections.abc import Sequence
from typing import Any

from ambiguous import Ambiguous
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.candidates.told import told_by_recordings
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.propose.explanations import Open, Question
from realitygap.diagnose.search.apart import ERRORS, compare
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.rivals import ODDS
from realitygap.diagnose.search.search import needed, search
from realitygap.scenario.file import load_scenario


def quiet(_: str) -> None:
    """Says nothing."""


def recorded(case: Ambiguous, more: Sequence[dict[str, Any]], name: str) -> Problem:
    """The problem of a case with further recordings."""
    return build_problem(load_scenario(case.scenario(more, name)), "mujoco")


def diagnosed(problem: Problem, right: set[str]) -> dict[str, Any]:
    """A diagnosis from nothing: what it names, and whether that is the truth alone, or what no motion tells from it."""
    everyone = suspects(problem)
    with Simulations(problem, 1) as simulations:
        found = search(simulations, everyone, told_by_recordings(problem, everyone), quiet)
    named = [label(c.suspect) for c in found.best.fit.changes]
    rivals = sorted({label(r.suspect) for listed in found.rivals.values() for r in listed if r.open})
    return {
        "named": named,
        "rivals": rivals,
        "settled": len(named) == 1 and {*named, *rivals} <= right,
        "right": bool({*named} & right),
    }


def compared(problem: Problem, open_: Open, questions: Sequence[Question], right: str) -> list[dict[str, Any]]:
    """What recordings make of questions, with the explanations refitted to old and new ones together: the logarithm of
    the odds for the truth, where laws may be off and effective samples count as at the explanation with fewer findings,
    where a diagnosis asks whether anything more is named, or at the better one of two with as many; and whether that
    settles the question by the rules of a diagnosis.
    """
    everyone, out = suspects(problem), []
    with Simulations(problem, 1) as simulations:
        base = open_.explanations[0].fit
        criterion = Criterion(simulations, base.changes)
        first = residual(simulations, base.changes, criterion.train)
        assert first is not None
        criterion.set_effective_fraction(first)
        asked = sorted({n for q in questions for n in (q.one, q.other)})
        near = {n: _refitted(criterion, open_.explanations[n].fit.changes) for n in asked}
        discrepancy_metric: dict[int, dict[int, Scored | None]] = {}
        for q in questions:
            pair = {n: s for n in (q.one, q.other) if (s := near[n]) is not None}
            odds = error = None
            if len(pair) == 2:
                at = min(pair, key=lambda n: (len(pair[n].fit.changes), -pair[n].evidence))
                if at not in discrepancy_metric:
                    criterion.set_discrepancy(pair[at].fit, criterion.responses(pair[at].fit, everyone))
                    alike = {n for p in questions for n in (p.one, p.other) if at in (p.one, p.other)}
                    discrepancy_metric[at] = {
                        n: _refitted(criterion, s.fit.changes) for n in alike if (s := near[n]) is not None
                    }
                true, false = (q.one, q.other) if sides(q)[0] == right else (q.other, q.one)
                one, other = discrepancy_metric[at][true], discrepancy_metric[at][false]
                if one is not None and other is not None:
                    odds, error = compare(criterion.channels, one, other)
            nested = len(open_.explanations[q.one].fit.changes) != len(open_.explanations[q.other].fit.changes)
            least = needed(len(everyone)) if nested else max(ODDS, ERRORS * (error or 0.0))
            settled = odds is not None and odds > least
            out.append({"question": str(q), "odds": odds, "error": error, "settled": settled})
    return out


def _refitted(criterion: Criterion, changes: Sequence[Change]) -> Scored | None:
    if changes:
        return criterion.fit(changes, care="compared")
    still = residual(criterion.simulations, (), criterion.train)
    return None if still is None else criterion.score(Fit((), still))


def sides(question: Question) -> list[str]:
    """What both sides name; empty for what has no name."""
    first, *last = [label(t) for t in question.targets]
    return [first, *(last or [""])]


def label(suspect: Suspect) -> str:
    """An effect and where it sits; those that are everywhere by their name alone."""
    return f"{suspect.effect} at {suspect.target}" if isinstance(suspect.target, str) else suspect.effect


def truth(case: Ambiguous) -> str:
    """What was planted, as a suspect of it is told."""
    told = json.loads((case.folder / "truth.json").read_text(encoding="utf-8"))
    at = told["target"]
    return f"{told['effect']} at {at}" if isinstance(at, str) else str(told["effect"])
