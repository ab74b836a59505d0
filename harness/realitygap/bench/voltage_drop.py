"""The voltage drop along a chain of motors, as resistances: of every joint's cable, and as one for the whole robot."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy import stats

from realitygap.bench.estimate import Array, Estimate


def cable_loads(table: pd.DataFrame, motors: Sequence[str]) -> tuple[Array, Array]:
    """Current [A] through and drop [V] over the cable before every motor of a chain but the first.

    The cable before a motor carries its current and that of all motors behind it. Only load conditions in which the
    whole chain was measured count. Both Shape (conditions, motors - 1).

    Args:
        table: columns motor, condition, measured [V], current [A], one row each.
        motors: the chain, from the supply outwards.
    """
    chain = list(motors)
    volts = table.pivot(index="condition", columns="motor", values="measured").reindex(columns=chain).dropna()
    current = table.pivot(index="condition", columns="motor", values="current").loc[volts.index, chain].to_numpy(float)
    behind = current[:, ::-1].cumsum(axis=1)[:, ::-1]
    return behind[:, 1:], -np.diff(volts.to_numpy(float), axis=1)


def chain_resistances(table: pd.DataFrame, motors: Sequence[str]) -> dict[str, Estimate]:
    """The resistance [Ω] of the cable before every motor of a chain but the first: drop on current, least squares."""
    through, drop = cable_loads(table, motors)
    return {m: _through_origin(through[:, k], drop[:, k]) for k, m in enumerate(motors[1:])}


def common_resistance(table: pd.DataFrame, chains: Sequence[Sequence[str]]) -> Estimate:
    """One resistance [Ω] for the cable of every joint of all chains, where the cables are alike."""
    pairs = [cable_loads(table, motors) for motors in chains]
    through, drop = (np.concatenate([p[k].ravel() for p in pairs]) for k in (0, 1))
    return _through_origin(through, drop)


def sag_resistance(table: pd.DataFrame) -> tuple[Estimate, Estimate] | None:
    """Open supply [V] and the one resistance [Ω] of the effect `voltage_sag`: V = supply − resistance·Σ I.

    The sum is over all motors of a load condition; where the voltage at the supply was not measured, both are fitted.
    None for fewer than two conditions with a current for every motor.
    """
    motors = table["motor"].nunique()
    whole = [rows for _, rows in table.groupby("condition") if rows["motor"].nunique() == motors]
    if len(whole) < 2:
        return None
    total = np.concatenate([np.full(len(rows), rows["current"].sum()) for rows in whole])
    volts = np.concatenate([rows["measured"].to_numpy(float) for rows in whole])
    if np.ptp(total) == 0:
        return None
    fit = stats.linregress(total, volts)
    quantile = float(stats.t.ppf(0.975, len(volts) - 2))
    open_supply = Estimate(
        float(fit.intercept),
        float(fit.intercept - quantile * fit.intercept_stderr),
        float(fit.intercept + quantile * fit.intercept_stderr),
    )
    slope = Estimate(
        -float(fit.slope), -float(fit.slope + quantile * fit.stderr), -float(fit.slope - quantile * fit.stderr)
    )
    return open_supply, slope


def _through_origin(x: Array, y: Array) -> Estimate:
    """The slope of a line through the origin with its 95 % interval."""
    if len(x) == 0 or not np.any(x):
        return Estimate(np.nan, np.nan, np.nan)
    slope = float(x @ y / (x @ x))
    if len(x) < 2:
        return Estimate(slope, np.nan, np.nan)
    error = float(np.sqrt(np.sum((y - slope * x) ** 2) / (len(x) - 1) / (x @ x)))
    half = float(stats.t.ppf(0.975, len(x) - 1)) * error
    return Estimate(slope, slope - half, slope + half)
