"""Static friction per motor: its mean and its spread."""

from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np

from realitygap.bench.estimate import Estimate, mean
from realitygap.bench.load_sweep import check_names
from realitygap.bench.servo_file import FrictionTable
from realitygap.bench.table import read_table
from realitygap.scenario.file import resolve_path


@dataclass(frozen=True)
class StaticFriction:
    """Static friction [N·m] of one motor type: a mean for every motor, their mean and their standard deviation."""

    motors: dict[str, float]
    overall: Estimate
    spread: float


def read_friction(path: Path, source: FrictionTable) -> dict[str, StaticFriction]:
    """Static friction by motor type; the rows of one motor (one per supply voltage, say) are averaged first."""
    file = resolve_path(path, source.table, "static_friction.table")
    table = read_table(file, ("type", "motor"), {"friction": source.unit})
    check_names(file, table, ("type",))
    out = {}
    for kind, rows in table.groupby("type"):
        motors = {str(m): float(r["friction"].mean()) for m, r in rows.groupby("motor", sort=False)}
        values = np.array(list(motors.values()))
        spread = float(np.std(values, ddof=1)) if len(values) > 1 else float("nan")
        out[str(kind)] = StaticFriction(motors, mean(values), spread)
    return out


def check_stated(kind: str, friction: StaticFriction, stated: float) -> str | None:
    """A sentence where a stated mean is not the mean of the motors, as rounded to two digits; None where it is."""
    found = friction.overall.value
    if abs(found - stated) <= 0.005 + 1e-9:
        return None
    text = f"{kind}: the stated mean of {stated:.2f} N·m is not the mean of its motors, which is {found:.3f} N·m"
    n = len(friction.motors)
    for left_out in (frozenset(c) for k in range(1, n) for c in combinations(friction.motors, k)):
        rest = [v for m, v in friction.motors.items() if m not in left_out]
        if len(rest) > 1 and abs(np.mean(rest) - stated) <= 0.005:
            return f"{text}; it would be without {', '.join(sorted(left_out))} ({np.mean(rest):.3f} N·m)."
    return text + "."
