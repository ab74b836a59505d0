"""What a missing effort depends on is found where it was planted, whatever its shape, and never gets a law's name."""

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from realitygap.missing.shape import Shape, Term, shape_of
from realitygap.missing.words import sentence
from realitygap.robot.effects import EFFECTS
from realitygap.robot.effects.place import place
from swings import MOTIONS, arm, mapped, recovered, swing

REACH = {"angle": 1.4, "speed": 6.0, "error": 0.6, "load": 1.6, "reversal": 1.2}
"""About the largest value of each variable in the motions [rad, rad/s, rad, N·m, s]."""
KINDS = (
    ("angle",),
    ("speed",),
    ("error",),
    ("load",),
    ("reversal",),
    ("angle", "speed"),
    ("load", "speed"),
)


def bumps(rng: np.random.Generator, variable: str) -> tuple[list[float], np.ndarray[Any, Any]]:
    """Knots and a random smooth function of unit size: no law's."""
    low = 0.0 if variable == "reversal" else -REACH[variable]
    values = np.zeros(9)
    while np.ptp(values) < 0.8:
        values = np.convolve(rng.normal(size=9), [0.25, 0.5, 0.25], "same")
    return list(np.linspace(low, REACH[variable], 9)), (values - values.mean()) / values.std()


def cases() -> Iterator[tuple[tuple[str, ...], list[dict[str, Any]]]]:
    """Variables and the maps that are planted: of one, sums of two, and products of two."""
    rng = np.random.default_rng(11)
    for k in range(21):
        variables, size = KINDS[k % len(KINDS)], rng.uniform(0.15, 0.3)
        parts = [bumps(rng, v) for v in variables]
        if len(parts) == 2 and k % 2:
            (rows, a), (columns, b) = parts
            yield (
                variables,
                [{"variables": [*variables], "knots": [rows, columns], "values": (size * a[:, None] * b).tolist()}],
            )
        else:
            yield variables, [{"variables": [v], "knots": [n], "values": list(size * f)}
                              for v, (n, f) in zip(variables, parts, strict=True)]  # fmt: skip


def found(maps: list[dict[str, Any]]) -> Shape:
    """The shape over four motions, two of them with twice the mass, so that load and angle differ."""
    runs = []
    for motion, load in zip(MOTIONS, (1.0, 1.0, 2.0, 2.0), strict=True):
        plant = arm(load)
        commands, trace = swing(mapped(plant, maps), motion)
        runs.append(recovered(plant, commands, trace))
    return shape_of(runs, "joint0")


def test_the_right_variables_are_found_in_nine_of_ten_shapes_outside_the_list() -> None:
    right, said = [], []
    for variables, maps in cases():
        shape = found(maps)
        right.append({v for term in shape.terms for v in term.variables} == set(variables))
        said.append(sentence(shape))
    assert np.mean(right) >= 0.9, said
    assert not [name for name in EFFECTS for s in said if name in s or name.replace("_", " ") in s]


def test_a_ripple_is_told_with_its_periods() -> None:
    knots = np.linspace(-1.5, 1.5, 240)
    triangles = 0.2 * np.arcsin(np.sin(14 * knots)) * 2 / np.pi
    shape = found([{"variables": ["angle"], "knots": [list(knots)], "values": list(triangles)}])
    (term,) = shape.terms
    assert term.variables == ("angle",)
    assert term.periods == pytest.approx(14.0, abs=0.3)
    assert "depends on the angle, 14" in sentence(shape)
    assert re.search(r"periods a turn \(\d+ % of its variance\)$", sentence(shape))


def test_where_nothing_is_missing_nothing_is_told() -> None:
    shape = found([])
    assert not shape.terms
    assert not shape.effects
    assert "no more than its band" in sentence(shape)


def test_of_a_motion_within_one_block_it_is_said_that_it_is_too_short() -> None:
    spring = [{"variables": ["angle"], "knots": [[-1.5, 1.5]], "values": [0.6, -0.6]}]
    commands, trace = swing(mapped(arm(), spring), MOTIONS[3], lasts=0.5)
    shape = shape_of([recovered(arm(), commands, trace)], "joint0")
    assert not shape.terms
    assert "is of too short a motion to tell what it depends on" in sentence(shape)


def test_as_effects_it_closes_the_gap_on_a_motion_that_was_not_fitted() -> None:
    maps = [{"variables": ["angle"], "knots": [[-1.5, -0.5, 0.0, 0.7, 1.5]], "values": [0.2, -0.3, 0.1, 0.3, -0.2]}]
    runs = []
    for motion in MOTIONS[1:]:
        commands, trace = swing(mapped(arm(), maps), motion)
        runs.append(recovered(arm(), commands, trace))
    effects = shape_of(runs, "joint0").effects
    assert [e.effect for e in effects] == ["effort_map"]
    _, true = swing(mapped(arm(), maps), MOTIONS[0])
    gaps = []
    for plant in (arm(), place(arm(), effects)):
        position = swing(plant, MOTIONS[0])[1].position
        assert position is not None
        assert true.position is not None
        gaps.append(float(np.mean(np.abs(position - true.position))))
    assert gaps[1] < 0.15 * gaps[0]


def test_two_terms_are_two_effects_on_one_joint() -> None:
    terms = (Term(("angle",), ((0.0, 1.0),), (0.1, 0.2), 0.5), Term(("speed",), ((0.0, 1.0),), (0.3, 0.1), 0.3))
    shape = Shape("joint0", "N·m", 0.2, 0.1, terms, 0.8, 0.1, 0.0, ())
    assert len(place(arm(), shape.effects).maps) == 2
