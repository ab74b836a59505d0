"""Truths outside the list: what no effect explains. Each returns words for the truth file.

`variables` are what an effort that is planted depends on: a diagnosis may show that shape, under no law's name.
"""

from typing import Any

import numpy as np
from draws import Rng, sign
from foreign import Foreign
from robots import Robot


def dropout(p: Foreign, r: Robot, j: int, rng: Rng) -> dict[str, Any]:
    start = rng.uniform(1.0, 2.2)
    p.dropout = (j, start, start + rng.uniform(0.25, 0.5))
    return {"what": "a motor drops out", "joint": r.joints[j], "from": p.dropout[1], "to": p.dropout[2]}


def push(p: Foreign, r: Robot, j: int, rng: Rng) -> dict[str, Any]:
    p.push = np.zeros((len(r.joints), 3))
    period, width = rng.uniform(0.5, 0.9), rng.uniform(0.06, 0.15)
    p.push[j] = (sign(rng) * rng.uniform(0.6, 1.0) * r.torque[j], period, width)
    return {"what": "a periodic push", "joint": r.joints[j], "period": period}


def bump(p: Foreign, r: Robot, j: int, rng: Rng) -> dict[str, Any]:
    d = p.drive
    d["bump"][j], d["bump_at"][j] = (
        sign(rng) * rng.uniform(0.25, 0.45) * r.torque[j],
        rng.uniform(-0.35, 0.35) * r.reach,
    )
    d["bump_width"][j] = rng.uniform(0.15, 0.3) * r.reach
    return {"what": "an effort around one angle", "joint": r.joints[j], "variables": ["position"]}


def peak_drag(p: Foreign, r: Robot, j: int, rng: Rng) -> dict[str, Any]:
    d = p.drive
    d["peak_drag"][j] = rng.uniform(0.25, 0.45) * r.torque[j]
    d["peak_at"][j], d["peak_width"][j] = rng.uniform(0.5, 0.9) * r.speed[j], rng.uniform(0.2, 0.3) * r.speed[j]
    return {"what": "drag around one speed", "joint": r.joints[j], "variables": ["velocity"]}


OUTSIDE = {"dropout": dropout, "push": push, "bump": bump, "peak_drag": peak_drag}
