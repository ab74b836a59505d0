"""The servo tables of the thesis, and points whose regression they are."""

from pathlib import Path

import numpy as np
import pandas as pd

BENCH = Path(__file__).parents[1] / "scenarios" / "bench_servo_mx" / "bench.yaml"

# tables 4.4 and 4.5: maximum torque, stall torque [N·m], maximum speed, no-load speed [rad/s]
TABLES = {
    ("MX 64", 12.8): (4.85, 3.78, 8.64, 7.42),
    ("MX 64", 14.8): (5.43, 4.00, 10.33, 8.49),
    ("MX 64", 16.0): (5.762, 4.111, 10.86, 8.74),
    ("MX 106", 12.8): (7.06, 6.15, 7.15, 6.16),
    ("MX 106", 14.8): (7.57, 6.80, 8.22, 6.82),
    ("MX 106", 16.0): (7.88, 7.06, 8.82, 7.47),
}
# section 4.3: two used motors of each type, one new MX 64, two new MX 106 that gave almost 2 N·m less
MOTORS = {
    "MX 64": [("mx64_1", "used", 0.05), ("mx64_2", "used", -0.08), ("mx64_3", "new", 0.03)],
    "MX 106": [
        ("mx106_1", "used", 0.95),
        ("mx106_2", "used", 0.85),
        ("mx106_3", "new", -0.85),
        ("mx106_4", "new", -0.95),
    ],
}
LOADS = {"MX 64": np.arange(0, 2.01, 0.25), "MX 106": np.arange(0, 3.01, 0.25)}


def planted_sweep() -> pd.DataFrame:
    """Points whose regression lines and maxima are those of the tables; the thesis did not publish its points."""
    tables = []
    for (kind, supply), (max_torque, stall, max_speed, no_load) in TABLES.items():
        rows = []
        for number, (motor, condition, excess) in enumerate(MOTORS[kind]):
            loads = LOADS[kind][: -2 if kind == "MX 106" and condition == "new" else None]  # they could not lift 2.5 kg
            share = loads / LOADS[kind][-1]
            speed = (max_speed - 0.04 * number) * (1 - 0.97 * share)
            rows += [(kind, motor, condition, supply, w, v, excess) for w, v in zip(loads, speed, strict=True)]
        table = pd.DataFrame(rows, columns=["type", "motor", "condition", "supply", "load", "speed", "excess"])
        speed = table["speed"].to_numpy()
        basis = np.column_stack([np.ones_like(speed), speed])

        def off_the_line(x: np.ndarray, basis: np.ndarray = basis) -> np.ndarray:
            return np.asarray(x - basis @ np.linalg.lstsq(basis, x, rcond=None)[0])

        residual = off_the_line(table["excess"].to_numpy() * (1 - speed / max_speed))
        line = stall * (1 - speed / no_load)
        top = int(np.argmax(line + residual))
        bend = off_the_line(np.exp(-8 * speed / max_speed) * (1 + 0.2 * (np.arange(len(speed)) == top)))
        residual += bend * (max_torque - line[top] - residual[top]) / bend[top]
        table["torque"] = line + residual
        tables.append(table.drop(columns="excess"))
    return pd.concat(tables, ignore_index=True).round(8)[
        ["type", "motor", "condition", "supply", "load", "torque", "speed"]
    ]
