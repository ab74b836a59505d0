"""What a diagnosis says: the file that is promised, made from what the search found."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from realitygap.diagnose.data.locate import Place, locate
from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.data.problem import Change, Problem, Suspect
from realitygap.diagnose.data.units import unit_there
from realitygap.diagnose.data.worsened import Worsened, worsened
from realitygap.diagnose.judge.confirm import Confirmed, confirm
from realitygap.diagnose.judge.rivals import Rival, experiment, rivals
from realitygap.diagnose.search.found import Found, name
from realitygap.diagnose.search.outside import set_aside
from realitygap.diagnose.search.search import enough, search
from realitygap.diagnose.search.worth import CLEAR, rms, worst
from realitygap.recording.faults import faults
from realitygap.robot.drive import Array
from realitygap.robot.effects import EFFECTS

NOT_REPEATED = "no motion was repeated: the sensors alone make the floor, and less is named; record one three times"
Z95 = 1.96
"""Standard deviations of a 95 % interval."""


@dataclass
class Diagnosis:
    """All that a diagnosis found, for the file, the page and the revised model.

    `before` and `after` are the simulated signals by case, of the scenario's model and of the mended one.
    """

    problem: Problem
    engines: list[str]
    found: Found
    confirmed: dict[Suspect, Confirmed]
    rivals: dict[Suspect, list[Rival]]
    where: list[Place]
    left: list[Place]
    worsened: list[Worsened]
    faults: list[str]
    before: dict[int, dict[str, Array]]
    after: dict[int, dict[str, Array]]
    notes: list[str] = field(default_factory=list)

    @property
    def verdict(self) -> str:
        """explained, partly explained, no gap or unexplained."""
        base, left = worst(self.problem, self.found.base), worst(self.problem, self.found.fit)
        if not self.found.fit.changes:
            return "no gap" if base <= CLEAR else "unexplained"
        return "explained" if left <= CLEAR else "partly explained"

    def experiment(self) -> str:
        """What to record next."""
        return experiment(self.rivals)

    def to_json(self) -> dict[str, Any]:
        """The content of `diagnosis.json`."""
        train, judge = self.problem.of("train"), self.problem.of("held_out")
        base, fit = self.found.base, self.found.fit
        return {
            "schema": 1,
            "scenario": self.problem.file.scenario.name,
            "engines": self.engines,
            "verdict": self.verdict,
            "where": [_place(p) for p in self.where],
            "findings": [self._finding(c) for c in fit.changes],
            "gap": {
                use: {"before": _round(rms(base.mean_cost(part))), "after": _round(rms(fit.mean_cost(part)))}
                for use, part in (("train", train), ("held_out", judge))
            }
            | {"unit": "floor-weighted rms, 1 is the floor"},
            "worsened": [
                {
                    "joint": w.joint,
                    "signal": w.signal,
                    "unit": w.unit,
                    "before": _round(w.before),
                    "after": _round(w.after),
                }
                for w in self.worsened
            ],
            "left": [_place(p) for p in self.left],
            "experiment": self.experiment(),
            "sensor_faults": self.faults,
            "refused": self.found.refused,
            "split": self.problem.split,
            "notes": self.notes,
        }

    def _finding(self, change: Change) -> dict[str, Any]:
        suspect = change.suspect
        effect = EFFECTS[suspect.effect]
        number = self.found.fit.changes.index(change)
        parameters = {}
        for k, (i, parameter) in enumerate(self.found.fit.names):
            if i == number:
                p = effect.parameter(parameter)
                value, wide = self.found.fit.value[k], Z95 * self.found.fit.deviation[k]
                parameters[parameter] = {
                    "value": _round(value, 5),
                    "low": _round(max(value - wide, p.low), 5),
                    "high": _round(min(value + wide, p.high), 5),
                    "unit": unit_there(self.problem, suspect, p),
                }
        for parameter, value in change.values:
            if parameter not in parameters:
                parameters[parameter] = {
                    "value": value,
                    "low": value,
                    "high": value,
                    "unit": unit_there(self.problem, suspect, effect.parameter(parameter)),
                }
        done = self.confirmed[suspect]
        return {
            "effect": suspect.effect,
            "target": suspect.target if isinstance(suspect.target, str) else list(suspect.target),
            "parameters": parameters,
            "cannot_tell_from": [
                {
                    "effect": r.suspect.effect,
                    "target": r.suspect.target if isinstance(r.suspect.target, str) else list(r.suspect.target),
                    "why": r.why,
                }
                for r in self.rivals.get(suspect, [])
            ],
            "held_out": {"before": _round(done.before), "after": _round(done.after)},
            "engines": {
                e: {"before": _round(before), "after": _round(after)} for e, (before, after) in done.engines.items()
            },
        }


def _round(value: float, digits: int = 4) -> float:
    return float(f"{value:.{digits}g}") if np.isfinite(value) else float(value)


def _place(place: Place) -> dict[str, Any]:
    return {
        "joint": place.joint,
        "signal": place.signal,
        "unit": place.unit,
        "gap": _round(place.gap),
        "noise_floor": _round(place.noise_floor),
        "numerical_floor": _round(place.numerical_floor),
        "when": list(place.when),
    }


def diagnose(pool: Pool, names: Sequence[str], say: Callable[[str], None] = lambda _: None) -> Diagnosis:
    """Find, name, add and prove.

    Args:
        pool: of the problem, which says in which engine to search.
        names: engines in which findings are confirmed; the searching one may be among them.
        say: told what is being done.
    """
    problem = pool.problem
    told = sensor_faults(problem)
    found = search(pool, say)
    outside = set_aside(pool, found, say)
    others = [e for e in names if e != problem.engine]
    confirmed, artefacts = confirm(pool, found, others, say)
    listed = rivals(pool, found) if found.fit.changes else {}
    every = range(len(problem.cases))
    before = problem.simulations([], every)
    after = problem.simulations(found.fit.changes, every) if found.fit.changes else before
    judge = problem.of("held_out")
    where = locate(problem, before)
    parts = (problem.of("train"), judge)
    notes = [*dict.fromkeys(n for c in problem.cases for n in c.experiment.notes), *outside, *artefacts]
    if not problem.repeated:
        notes.append(NOT_REPEATED)
    gap = any(found.fit.mean_cost(part) > enough(found.base.mean_cost(part)) for part in parts)
    left = locate(problem, after) if gap and found.fit.changes else []
    return Diagnosis(
        problem=problem,
        engines=[problem.engine, *others],
        found=found,
        confirmed=confirmed,
        rivals=listed,
        where=where,
        left=left,
        worsened=worsened(problem, judge, before, after) if found.fit.changes else [],
        faults=told,
        before=before,
        after=after,
        notes=notes,
    )


def sensor_faults(problem: Problem) -> list[str]:
    """Sentences on faults of the sensors and the clock, once per kind."""
    out = []
    for case in problem.cases:
        if case.experiment.recording is not None:
            out += [f"{case.name}: {fault.sentence}" for fault in faults(case.experiment.recording)]
    return list(dict.fromkeys(out))


__all__ = ["Diagnosis", "diagnose", "name"]
