"""Fewer knots draw the same function: what simulations fit again has few values."""

from typing import Any

import numpy as np
import pytest
from realitygap.missing.few import LOST, few_knots
from realitygap.missing.shape import Term, samples_of, shape_of
from realitygap.missing.splines import Spline
from swings import MOTIONS, arm, mapped, recovered, swing

MAPS: dict[str, dict[str, Any]] = {
    "a bump over the angle": {"variables": ["angle"], "knots": [[-0.4, 0.0, 0.3, 0.6]], "values": [0.0, 0.0, 0.4, 0.0]},
    "a jump over the speed": {
        "variables": ["speed"],
        "knots": [[-4.0, -0.02, 0.02, 4.0]],
        "values": [0.3, 0.2, -0.2, -0.3],
    },
    "a fan over both": {
        "variables": ["load", "speed"],
        "knots": [[-1.0, 0.0, 1.0], [-3.0, 3.0]],
        "values": [[0.4, -0.4], [0.05, -0.05], [0.4, -0.4]],
    },
}


def values_of(term: Term, columns: dict[str, Any]) -> np.ndarray[Any, Any]:
    spline = Spline(term.variables, tuple(np.array(row) for row in term.knots))
    return np.asarray(spline.design(columns) @ np.array(term.values))


@pytest.mark.parametrize("name", MAPS)
def test_it_is_the_same_function_with_fewer_values(name: str) -> None:
    runs = []
    for motion in MOTIONS:
        commands, trace = swing(mapped(arm(), [MAPS[name]]), motion)
        runs.append(recovered(arm(), commands, trace))
    terms = shape_of(runs, "joint0").terms
    fewer = few_knots(runs, "joint0", terms)
    columns = samples_of(runs, "joint0")[0].columns
    assert terms
    for one, few in zip(terms, fewer, strict=True):
        assert (few.variables, few.share, few.periods) == (one.variables, one.share, one.periods)
        assert len(few.values) <= 24 < len(one.values)
        full, other = values_of(one, columns), values_of(few, columns)
        assert np.mean((full - other) ** 2) < 3 * LOST * np.var(full)


def test_a_ripple_keeps_its_periods() -> None:
    commands, trace = swing(arm(), MOTIONS[0])
    knots = np.linspace(-1.0, 1.0, 41)
    ripple = Term(("angle",), (tuple(knots),), tuple(0.2 * np.sin(14.0 * knots)), 0.4, 14.0)
    (few,) = few_knots([recovered(arm(), commands, trace)], "joint0", [ripple])
    assert (few.share, few.periods) == (0.4, 14.0)
