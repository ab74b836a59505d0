"""An unnamed effort on the page of a diagnosis: its values with their intervals, and its picture."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.units import table_units
from realitygap.diagnose.result.diagnosis import Diagnosis
from realitygap.diagnose.result.story_figures import AFTER, INK, STYLE, svg
from realitygap.diagnose.result.story_text import DEGREES, interval, quantity, suspect_label
from realitygap.page.style import number, unit_label
from realitygap.robot.drive import Array

CURVES = 5
"""Of an effort that depends on two variables, one curve is drawn for so many knots of the second."""


def value_rows(result: Diagnosis, change: Change) -> list[tuple[str, str, str, str]]:
    """Where each value stands, the value, its 95 % interval, and what the model has there."""
    table = change.suspect.table
    assert table is not None
    unit, units = table_units(result.problem, change.suspect)
    places = np.stack([m.ravel() for m in np.meshgrid(*table.knots, indexing="ij")], axis=1)
    out = []
    for place, name in zip(places, table.names, strict=True):
        at = ", ".join(
            f"{v} {quantity(float(x), u, short=True)}" for v, x, u in zip(table.variables, place, units, strict=True)
        )
        low, high = result.interval(change, name)
        out.append((f"at {at}", quantity(change.parameters[name], unit), interval(low, high, unit), "none"))
    return out


def draw_table(result: Diagnosis, change: Change) -> str:
    """The effort over what it depends on, with the 95 % band; of two variables, curves for knots of the second. SVG."""
    table = change.suspect.table
    assert table is not None
    unit, units = table_units(result.problem, change.suspect)
    size = [len(row) for row in table.knots]
    columns = size[1] if len(size) > 1 else 1
    values = np.reshape([v for _, v in change.values], (size[0], columns))
    ends = np.reshape([result.interval(change, n) for n in table.names], (size[0], columns, 2))
    x, shown = _for_people(table.knots[0], units[0])
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(5.6, 2.6))
        axes = figure.subplots()
        axes.axhline(0.0, color=INK, linewidth=0.8)
        chosen = np.unique(np.linspace(0, columns - 1, min(columns, CURVES)).round().astype(int))
        for turn, k in enumerate(chosen):
            label = None
            if len(size) > 1:
                at, other = _for_people(table.knots[1], units[1])
                label = f"{table.variables[1]} {number(float(at[k]))} {unit_label(other)}"
            alpha = 1.0 if columns == 1 else 0.35 + 0.65 * turn / max(len(chosen) - 1, 1)
            axes.plot(x, values[:, k], "o-", color=AFTER, markersize=3.5, alpha=alpha, label=label)
            axes.fill_between(
                x, ends[:, k, 0], ends[:, k, 1], color=AFTER, alpha=0.15 / len(chosen) ** 0.5, linewidth=0
            )
        axes.set_xlabel(f"{table.variables[0]} [{unit_label(shown)}]")
        axes.set_ylabel(f"effort [{unit_label(unit)}]")
        if len(size) > 1:
            figure.legend(loc="outside right upper", frameon=False)
        return svg(figure, suspect_label(change.suspect))


def _for_people(knots: tuple[float, ...], unit: str) -> tuple[Array, str]:
    x = np.array(knots)
    return (np.degrees(x), DEGREES[unit]) if unit in DEGREES else (x, unit)
