"""What a diagnosis says: the file that is promised, made from what the search and the judges found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from realitygap.diagnose.candidates.suspects import bounds
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.units import table_units, unit_there
from realitygap.diagnose.judge.advice import experiment
from realitygap.diagnose.judge.closest import Closest
from realitygap.diagnose.judge.gaps import CLEAR, Shown, rms
from realitygap.diagnose.judge.held_out import Verdict
from realitygap.diagnose.judge.locate import Place
from realitygap.diagnose.judge.worsened import InUnits, Worsened
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.result.odds import odds
from realitygap.diagnose.search.found import Found
from realitygap.diagnose.search.rivals import ODDS, Rival
from realitygap.robot.drive import Array

SCHEMA = 1
"""The form of `diagnosis.json`."""
Z95 = 1.96
"""Standard deviations of a 95 % interval."""
LAW = 0.1
"""What findings leave of a gap is that of laws that are only nearly right up to this share: they are known to 5 to 10 %
(Coulomb friction scatters by 4 to 10 % over angle and direction; Armstrong-Hélouvry et al. 1994)."""
MOST = 3
"""Rivals of a finding that are listed at most."""


@dataclass(frozen=True)
class Diagnosis:
    """All that a diagnosis found, for the file, the page and the revised model.

    Attributes:
        problem: the motions.
        engines: the searching one first.
        found: by the search.
        changes: the findings, what explains most first.
        adjusted: what the laws of the named model are off by, which is no finding; the mended model has it too.
        floors: under which gaps are said.
        costs: mean squared gap in floors of every case, of the scenario's model and of the mended one.
        shown: the held-out gap before and after each finding, by engine.
        predicted: how much better what was kept back is predicted.
        before, after: simulated signals by case.
        deviations: standard errors of what the recordings show by themselves, by suspect and parameter.
        blamed: joints where a mistake is likely, so that nothing was looked for there.
    """

    problem: Problem
    engines: list[str]
    found: Found
    changes: tuple[Change, ...]
    floors: Floors
    costs: tuple[dict[int, float], dict[int, float]]
    shown: dict[Suspect, Shown]
    predicted: Verdict
    where: list[Place]
    left: list[Place]
    worsened: list[Worsened]
    units: list[InUnits]
    faults: list[str]
    closest: list[Closest]
    before: dict[int, dict[str, Array]]
    after: dict[int, dict[str, Array]]
    notes: list[str] = field(default_factory=list)
    deviations: dict[Suspect, dict[str, float]] = field(default_factory=dict)
    blamed: tuple[str, ...] = ()
    adjusted: tuple[Change, ...] = ()

    @property
    def mended(self) -> tuple[Change, ...]:
        """The changes of the mended model: the findings, and what its laws are off by."""
        return (*self.changes, *self.adjusted)

    def gap(self, use: str) -> tuple[float, float]:
        """The gap before and after on `train` or `held_out` motions, in floors."""
        part = self.problem.of(use)
        return rms(self.costs[0], part), rms(self.costs[1], part)

    @property
    def verdict(self) -> str:
        """explained, partly explained, no gap or unexplained."""
        if not self.changes:
            return "no gap" if max(self.gap(use)[0] for use in ("train", "held_out")) <= CLEAR else "unexplained"
        return "explained" if self.closed else "partly explained"

    @property
    def closed(self) -> bool:
        """Whether the mended model leaves no more of the gaps than floors and laws that are only nearly right do."""
        gaps = [self.gap(use) for use in ("train", "held_out")]
        return all(after <= max(CLEAR, LAW * before) for before, after in gaps)

    @property
    def rivals(self) -> dict[Suspect, list[Rival]]:
        """What cannot be told from each finding, the closest first, pairs last: at most `MOST` suspects."""
        return {c.suspect: _listed(self.found.rivals.get(c.suspect, [])) for c in self.changes}

    def experiment(self) -> str:
        """What to record next."""
        listed = {s: [r.suspects for r in of] for s, of in self.rivals.items()}
        return experiment(listed, self.problem.followed)

    def interval(self, change: Change, parameter: str) -> tuple[float, float]:
        """The 95 % interval of a parameter that was fitted or seen; its value twice where it was not."""
        value, fitted = change.parameters[parameter], self.found.best.fit
        off = self.deviations.get(change.suspect, {}).get(parameter, 0.0)
        for (i, name), deviation in zip(fitted.names, self.found.cautious.deviation, strict=True):
            if fitted.changes[i].suspect == change.suspect and name == parameter:
                off = float(deviation)
        low, high = bounds(self.problem.plant, change.suspect)[parameter]
        return min(value, max(value - Z95 * off, low)), max(value, min(value + Z95 * off, high))

    def to_json(self) -> dict[str, Any]:
        """The content of `diagnosis.json`."""
        return {
            "schema": SCHEMA,
            "scenario": self.problem.file.scenario.name,
            "scenario_file": str(self.problem.file.path.absolute()),
            "engines": self.engines,
            "verdict": self.verdict,
            "where": [_place(p) for p in self.where],
            "findings": [self._finding(c) for c in self.changes],
            "adjusted": [self._told(c) for c in self.adjusted],
            "gap": {
                use: dict(zip(("before", "after"), map(_round, self.gap(use)), strict=True))
                for use in ("train", "held_out")
            }
            | {"unit": "floor-weighted rms, 1 is the floor"},
            "in_units": [
                {"signal": u.signal, "unit": u.unit, "before": _round(u.before), "after": _round(u.after)}
                for u in self.units
            ],
            "predicted": {"gain": _round(self.predicted.gain), "error": _round(self.predicted.error)},
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
            "closest": [
                _name(c.change.suspect)
                | {
                    "parameters": {n: _round(v, 5) for n, v in c.change.values},
                    "train": {"before": _round(c.before), "after": _round(c.after)},
                    "why": c.why,
                }
                for c in self.closest
            ],
            "laws_imperfect_by": {law or "other": scale for law, scale in self.found.best.discrepancy_scale.items()},
            "experiment": self.experiment(),
            "sensor_faults": self.faults,
            "split": self.problem.split,
            "notes": self.notes,
        }

    def _table(self, change: Change) -> dict[str, Any]:
        """The parameters of an unnamed effort: values, and the interval of each, in the order of its knots."""
        suspect, told = change.suspect, change.spec
        table = suspect.table
        assert table is not None
        ends = [self.interval(change, name) for name in table.names]
        low, high = (table.parameters([_round(e[k], 5) or 0.0 for e in ends])["values"] for k in (0, 1))
        values = table.parameters([_round(v, 5) or 0.0 for _, v in change.values])["values"]
        unit, units = table_units(self.problem, suspect)
        knots = {"value": told["knots"], "low": told["knots"], "high": told["knots"]}
        return {
            "variables": dict.fromkeys(("value", "low", "high"), told["variables"]) | {"unit": ""},
            "knots": knots | {"unit": ", ".join(units)},
            "values": {"value": values, "low": low, "high": high, "unit": unit},
        }

    def _finding(self, change: Change) -> dict[str, Any]:
        suspect = change.suspect
        rivals = self.found.rivals.get(suspect, [])
        best = _name(rivals[0].suspect) | {"behind": _round(rivals[0].behind)} if rivals else None
        if best is not None and rivals[0].beside is not None:
            best |= {"beside": _name(rivals[0].beside)}
        return self._told(change) | {
            "cannot_tell_from": [_name(s) | {"why": why(r, s)} for s, r in self._alternatives(suspect).items()],
            "evidence": _round(self.found.gains.get(suspect, float("nan"))),
            "next_best": best,
        }

    def _alternatives(self, suspect: Suspect) -> dict[Suspect, Rival]:
        """What cannot be told from a finding, each with the closest rival that it is or is part of."""
        out = dict[Suspect, Rival]()
        for rival in self.rivals[suspect]:
            out |= {s: rival for s in rival.suspects if s not in out}
        return out

    def _told(self, change: Change) -> dict[str, Any]:
        """What a change is, its values, and the held-out gap before and after its step."""
        shown = self.shown[change.suspect]
        return _name(change.suspect) | {
            "parameters": self._parameters(change),
            "held_out": {"before": _round(shown.before), "after": _round(shown.after)},
            "engines": {e: {"before": _round(a), "after": _round(b)} for e, (a, b) in shown.engines.items()},
        }

    def _parameters(self, change: Change) -> dict[str, Any]:
        """The parameters of a change, each with its 95 % interval and unit."""
        suspect = change.suspect
        if suspect.table is not None:
            return self._table(change)
        parameters: dict[str, Any] = {}
        for p in suspect.kind.parameters:
            value = change.parameters[p.name]
            shapeless = p.shape and p.name not in change.free and value == p.absent
            if shapeless or not np.isfinite(value):  # a shape, or a limit, that is not there
                continue
            low, high = self.interval(change, p.name)
            unit = unit_there(self.problem, suspect, p)
            parameters[p.name] = {
                "value": _round(value, 5),
                "low": _round(low, 5),
                "high": _round(high, 5),
                "unit": unit,
            }
        return parameters


def _listed(rivals: Sequence[Rival]) -> list[Rival]:
    """Of all rivals those that cannot be told from the finding, as many as name no more than `MOST` suspects."""
    out, named = list[Rival](), set[Suspect]()
    for rival in sorted((r for r in rivals if r.open), key=lambda r: r.beside is not None):
        if len(named.union(rival.suspects)) <= MOST:
            out.append(rival)
            named.update(rival.suspects)
    return out


def why(rival: Rival, of: Suspect | None = None) -> str:
    """Why a rival cannot be told from a finding; of a pair why one of the two cannot, or why both together cannot."""
    others = [str(s) for s in rival.suspects if s != of] if of is not None else []
    where = f"fitted in its place beside {others[0]}" if others else "fitted in its place"
    they = "they explain" if of is None and rival.beside is not None else "it explains"
    if rival.behind < -ODDS:
        return f"{where}, {they} the recordings better, by no more than laws of its kind are ordinarily off by"
    if rival.behind <= 0:
        return f"{where}, {they} the recordings as well"
    little = "too little to decide" if rival.behind <= ODDS else "no more than stretches of them scatter by"
    if rival.same:
        return f"{where}, {they.replace('explain', 'make')} the same traces, and is only less likely beforehand"
    return (
        f"{where}, {they.replace('explain', 'make')} the recordings {odds(rival.behind)} times less probable, which is "
        f"{little} (in logarithms {rival.behind:.1f} ± {rival.error:.1f})"
    )


def _name(suspect: Suspect) -> dict[str, Any]:
    target = suspect.target if isinstance(suspect.target, str) else list(suspect.target)
    return {"effect": suspect.effect, "target": target}


def _round(value: float, digits: int = 4) -> float | None:
    """A few digits; None, which JSON knows, for what is not a number."""
    return float(f"{value:.{digits}g}") if np.isfinite(value) else None


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


def names(changes: Sequence[Change]) -> str:
    """Changes in words."""
    return ", ".join(str(c.suspect) for c in changes)
