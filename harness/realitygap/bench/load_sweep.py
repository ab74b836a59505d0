"""Load sweeps: torque and speed per motor, supply voltage and load, and what each motor type makes of them."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

from realitygap.bench.bag import read_signals
from realitygap.bench.estimate import Array, Estimate
from realitygap.bench.servo_file import ServoBench, Sweep
from realitygap.bench.table import read_table
from realitygap.bench.torque_speed import Regression, TorqueSpeedLine, fit_line
from realitygap.files.errors import InputError
from realitygap.scenario.file import resolve_path

FEWEST_LOADS = 3


def read_sweep(path: Path, bench: ServoBench) -> pd.DataFrame:
    """The measurements in SI units: columns type, motor, condition, supply, load, torque, speed.

    Raises:
        InputError: for rows that cannot be used, fewer than three loads, or two motors under one name.
    """
    if isinstance(bench.torque_speed, Sweep):
        file, sweep = path, _from_bags(path, bench.torque_speed)
    else:
        assert bench.torque_speed is not None
        assert bench.units is not None
        file = resolve_path(path, bench.torque_speed, "torque_speed")
        units = {name: getattr(bench.units, name) for name in ("supply", "load", "torque", "speed")}
        sweep = read_table(file, ("type", "motor", "condition"), units, optional=("condition",))
    if "condition" not in sweep:
        sweep["condition"] = None
    check_names(file, sweep, ("type", "condition"))
    low = sweep[sweep["supply"] <= 0]
    if len(low):
        motor, supply = low["motor"].iloc[0], low["supply"].iloc[0]
        raise InputError(f"{file}: motor {motor} has a supply of {supply:g} V, expected more than 0")
    for condition in sweep["condition"].dropna().unique():
        if condition not in ("new", "used"):
            raise InputError(f"{file}: condition is {condition!r}, expected new or used")
    for (kind, supply), rows in sweep.groupby(["type", "supply"]):
        loads = rows["load"].nunique()
        if loads < FEWEST_LOADS:
            raise InputError(
                f"{file}: {kind} at {supply:g} V was measured with {loads} load{'s' * (loads != 1)}; a line needs at "
                f"least {FEWEST_LOADS} different ones"
            )
    return sweep


def check_names(file: Path, table: pd.DataFrame, columns: tuple[str, ...]) -> None:
    """One motor has one type and one condition; raises InputError where a name stands for two."""
    for motor, rows in table.groupby("motor"):
        for column in columns:
            found = [str(v) for v in rows[column].dropna().unique()]
            if len(found) > 1:
                raise InputError(
                    f"{file}: two motors under one name: {motor} is {found[0]} in one row and {found[1]} in another; "
                    "give every motor its own name"
                )


def _from_bags(path: Path, sweep: Sweep) -> pd.DataFrame:
    rows = []
    for i, bag in enumerate(sweep.bags):
        file = resolve_path(path, bag.path, f"torque_speed.bags[{i}].path")
        (time, speed), (torque_time, torque) = read_signals(file, [sweep.speed, sweep.torque])
        fastest = int(np.argmax(np.abs(speed)))
        sign = np.sign(speed[fastest]) or 1.0
        rows.append(
            {
                **{k: getattr(bag, k) for k in ("type", "motor", "condition", "supply", "load")},
                "speed": float(abs(speed[fastest]) * sweep.speed.unit),
                "torque": float(sign * np.interp(time[fastest], torque_time, torque) * sweep.torque.unit),
            }
        )
    return pd.DataFrame(rows)


def lines(path: Path, sweep: pd.DataFrame, regression: Regression) -> Iterator[tuple[str, float, TorqueSpeedLine]]:
    """The line of every motor type and supply voltage [V], in order."""
    for (kind, supply), rows in sweep.groupby(["type", "supply"]):
        try:
            line = fit_line(rows["speed"].to_numpy(float), rows["torque"].to_numpy(float), regression)
        except ValueError as error:
            raise InputError(f"{path}: {kind} at {supply:g} V: {error}; expected a motor") from None
        yield str(kind), float(str(supply)), line


def new_against_used(sweep: pd.DataFrame, regression: Regression) -> tuple[Estimate, float, dict[str, float]] | None:
    """Whether new and used motors of one type differ in stall torque.

    The motor is what was drawn at random, not the measurement: every motor gives one number, its stall torque less the
    mean over motors at that voltage, averaged over the voltages; the two groups are compared by Student's t-test.

    Returns:
        New less used [N·m] with its 95 % interval, the p-value (NaN for one motor in each group) and the number of
        each motor; None where only one condition is present.
    """
    stalls: dict[tuple[str, float], float] = {}
    for (motor, supply), rows in sweep.groupby(["motor", "supply"]):
        if rows["load"].nunique() >= FEWEST_LOADS:
            fit = fit_line(rows["speed"].to_numpy(float), rows["torque"].to_numpy(float), regression)
            stalls[str(motor), float(str(supply))] = fit.stall_torque.value
    supplies = {s for _, s in stalls}
    center = {s: np.mean([v for (_, at), v in stalls.items() if at == s]) for s in supplies}
    excess = {m: float(np.mean([v - center[s] for (n, s), v in stalls.items() if n == m])) for m, _ in stalls}
    condition = dict(zip(sweep["motor"], sweep["condition"], strict=True))
    new, used = (np.array([v for m, v in excess.items() if condition[m] == c]) for c in ("new", "used"))
    if not len(new) or not len(used):
        return None
    difference = float(new.mean() - used.mean())
    if len(new) + len(used) < 3:
        return Estimate(difference, np.nan, np.nan), float("nan"), excess
    test = stats.ttest_ind(new, used)
    interval = test.confidence_interval(0.95)
    return Estimate(difference, float(interval.low), float(interval.high)), float(test.pvalue), excess


def drive_constants(speed: Array, torque: Array, supply: Array, coulomb: float) -> tuple[Estimate, Estimate]:
    """Torque constant [N·m/A] and resistance [Ω] of a DC motor at the output shaft, over all supply voltages.

    torque = kt/R·supply − kt²/R·speed − coulomb (thesis, equations 3.3 and 3.4), linear in kt/R and kt²/R; the torque
    is measured behind the friction. All Shape (n,); the intervals follow from the covariance to first order.
    """
    A = np.column_stack([supply, -speed])
    (a, b), *_ = np.linalg.lstsq(A, torque + coulomb, rcond=None)
    rest = torque + coulomb - A @ np.array([a, b])
    degrees = max(len(torque) - 2, 1)
    covariance = float(rest @ rest) / degrees * np.linalg.inv(A.T @ A)
    quantile = float(stats.t.ppf(0.975, degrees))
    out = []
    for value, gradient in ((b / a, np.array([-b / a**2, 1 / a])), (b / a**2, np.array([-2 * b / a**3, 1 / a**2]))):
        half = quantile * float(np.sqrt(gradient @ covariance @ gradient))
        out.append(Estimate(float(value), float(value - half), float(value + half)))
    return out[0], out[1]
