"""Budgets: the largest mean gap that a test or a build accepts."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from harness.errors import InputError
from harness.results import means

SIGNALS = ("position", "velocity", "effort")


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
            raise InputError(f"--max-gap: found {text!r}; expected SIGNAL=VALUE with one of {', '.join(SIGNALS)}")
        out[signal] = number
    return out


def over_budget(gaps: pd.DataFrame, budget: Mapping[str, float]) -> list[str]:
    """A sentence for every engine and recording whose mean gap of moving joints exceeds the budget; worst joint named."""
    lines = []
    moving = gaps[(gaps["group"] == "moving") & gaps["signal"].isin(list(budget))]
    for record in means(moving).itertuples():
        limit = budget[str(record.signal)]
        value = float(record.mean_abs)
        if value <= limit:
            continue
        rows = moving[
            (moving["engine"] == record.engine)
            & (moving["recording"] == record.recording)
            & (moving["signal"] == record.signal)
            & (moving["robot_revision"] == record.robot_revision)
        ]
        worst = rows.loc[rows["mean_abs"].idxmax()]
        floor = np.nanmax([worst["noise_floor"], worst["numerical_floor"], 0.0])
        lines.append(
            f"over budget: {record.engine}, {record.recording}: {record.signal} {value:.3g} {record.unit}, budget "
            f"{limit:g} {record.unit}; worst joint {worst['joint']} with {worst['mean_abs']:.3g} {record.unit} "
            f"(floor {floor:.2g})"
        )
    return lines
