"""Budgets: the largest mean gap of moving joints that a test or a build accepts."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from realitygap.compare.row import CELL, EXCLUDED, outcome_told
from realitygap.files.errors import InputError
from realitygap.scenario.schema import Budget

SIGNALS = tuple(Budget.model_fields)


def parse_budget(texts: Sequence[str]) -> dict[str, float]:
    """Budgets from `--max-gap position=1.2` options; a bare number is for position.

    Raises:
        InputError: for an unknown signal or a value that is not a positive number.
    """
    out = {}
    for text in texts:
        signal, _, value = text.rpartition("=")
        signal = signal or "position"
        try:
            number = float(value)
        except ValueError:
            number = float("nan")
        if signal not in SIGNALS or not number > 0:
            known = ", ".join(SIGNALS)
            raise InputError(
                f"--max-gap: found {text!r}; expected SIGNAL=VALUE with one of {known} and a number above zero"
            )
        out[signal] = number
    return out


def stated_budget(budget: Budget | None) -> dict[str, float]:
    """The budget that a scenario states."""
    return {} if budget is None else budget.model_dump(exclude_none=True)


def over_budget(gaps: pd.DataFrame, budget: Mapping[str, float]) -> list[str]:
    """A sentence for every cell whose mean gap of moving joints exceeds the budget; the worst joint is named.

    A cell that failed exceeds every budget; one that an engine cannot express is not judged.
    """
    moving = _counted(gaps)
    moving = moving[moving["outcome"] != "unsupported"]
    lines = []
    for signal, limit in budget.items():
        for _, cell in moving[moving["signal"] == signal].groupby(CELL, dropna=False, sort=True):
            for unit, rows in cell.groupby("unit"):
                value = float(rows["mean_abs"].mean())
                if value > limit:
                    lines.append(f"over budget: {_excess(rows, signal, value, limit, str(unit))}")
    return lines


def _counted(gaps: pd.DataFrame) -> pd.DataFrame:
    """The rows that budgets are about: of moving joints that are not left out."""
    return gaps[(gaps["group"] == "moving") & (gaps["note"] != EXCLUDED)]


def _excess(rows: pd.DataFrame, signal: str, value: float, limit: float, unit: str) -> str:
    worst = rows.sort_values("mean_abs", ascending=False, kind="stable").to_dict("records")[0]
    what = f"{worst['engine']}, {worst['recording']}: {signal}"
    if worst["outcome"] != "ok":
        return f"{what}: {outcome_told(worst['outcome'], worst['note'])}; budget {limit:g} {unit}"
    floor = np.nanmax([worst["noise_floor"], worst["numerical_floor"], 0.0])
    return (
        f"{what} {value:.3g} {unit}, budget {limit:g} {unit}; worst joint {worst['joint']} with "
        f"{worst['mean_abs']:.3g} {unit} (floor {floor:.2g})"
    )


def not_judged(gaps: pd.DataFrame, budget: Mapping[str, float]) -> list[str]:
    """A sentence for every budget that nothing was measured for: a budget that cannot be judged is not kept."""
    rows = _counted(gaps)
    judged = set(rows.loc[rows["outcome"] != "unsupported", "signal"])
    unsupported = set(rows["signal"]) - judged
    return [
        f"over budget: {signal} was not judged, as no engine of the run can simulate the scenario; budget {limit:g}"
        if signal in unsupported
        else f"over budget: no {signal} of a moving joint was measured, or all are left out; budget {limit:g}"
        for signal, limit in budget.items()
        if signal not in judged
    ]
