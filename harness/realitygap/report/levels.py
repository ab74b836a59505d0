"""Comparing the values of one axis (engines, revisions, step rates, …) over cells that agree in everything else."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd


@dataclass(frozen=True)
class Level:
    """One value of an axis and its gap, the mean over `contexts` cells in which every compared value ran."""

    value: Any
    gap: float
    noise: float
    numerical: float
    contexts: int

    @property
    def floor(self) -> float:
        """The larger of both floors; one that is unknown does not count."""
        return floor(self.noise, self.numerical)

    @property
    def seen(self) -> bool:
        """Whether simulation and recording differ by more than the floors."""
        return self.gap > self.floor


def floor(noise: float, numerical: float) -> float:
    """The larger of noise and numerical floor; 0 where neither is known."""
    return max((f for f in (noise, numerical) if math.isfinite(f)), default=0.0)


def differ(a: Level, b: Level) -> bool:
    """Whether two gaps are further apart than the larger of their floors."""
    return abs(a.gap - b.gap) > max(a.floor, b.floor)


def levels(frame: pd.DataFrame, axis: str, axes: Sequence[str]) -> list[Level]:
    """The values of an axis that ran, in ascending order, each with its mean gap over the same contexts.

    A value that failed in every context is left out. Then only contexts count in which all values ran; where there
    is none, the value that ran least often is left out, until there is one.

    Args:
        frame: means of one group and signal.
        axis: the axis whose values are compared.
        axes: all axes; those besides `axis` are the context.
    """
    if frame.empty:
        return []
    others = [a for a in axes if a != axis]
    frame = frame.assign(**{a: frame[a].astype(object).where(frame[a].notna(), "") for a in axes})
    context = joined(frame, others)
    gaps = _pivot(frame, context, axis, "mean_abs")
    gaps = gaps.where(np.isfinite(gaps)).dropna(axis=1, how="all")
    while gaps.shape[1] and gaps.dropna().empty:
        gaps = gaps.drop(columns=gaps.notna().sum().idxmin())
    gaps = gaps.dropna()
    values = sorted(gaps.columns, key=lambda v: (isinstance(v, str), v))
    noise, numerical = (_pivot(frame, context, axis, c).loc[gaps.index] for c in ("noise_floor", "numerical_floor"))
    return [
        Level(v, float(gaps[v].mean()), float(noise[v].mean()), float(numerical[v].mean()), len(gaps)) for v in values
    ]


def joined(frame: pd.DataFrame, columns: Sequence[str]) -> "pd.Series[str]":
    """Some columns of every row as one text, equal where all of them are."""
    text = [["" if pd.isna(v) else str(v) for v in frame[c]] for c in columns]
    joint = ["\x1f".join(row) for row in zip(*text, strict=True)] if text else ""
    return pd.Series(joint, index=frame.index, dtype=object)


def _pivot(frame: pd.DataFrame, context: "pd.Series[str]", axis: str, column: str) -> pd.DataFrame:
    return frame.assign(context=context).pivot_table(
        index="context", columns=axis, values=column, aggfunc="mean", dropna=False
    )


def pareto(gap: Sequence[float], speed: Sequence[float]) -> list[bool]:
    """Which points no other beats: none is at least as close and as fast, and better in one of them."""
    points = list(zip(gap, speed, strict=True))
    return [
        math.isfinite(g)
        and math.isfinite(s)
        and not any(h <= g and t >= s and (h < g or t > s) for h, t in points if math.isfinite(h))
        for g, s in points
    ]
