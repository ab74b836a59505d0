"""What a diagnosis says in a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.result.diagnosis import Diagnosis
from realitygap.diagnose.result.story_text import interval, lacks, quantity
from realitygap.page.style import number
from realitygap.page.style import quantity as in_unit


def summary(result: Diagnosis) -> list[str]:
    """Lines for the terminal: verdict, findings with their intervals, what cannot be told apart, what to record."""
    content = result.to_json()
    gap = _moved(content["gap"]["held_out"])
    lines = [f"{content['verdict']}: held-out gap {gap} (floor-weighted rms, 1 is the floor)"]
    lines += [f"  {u.signal}: {number(u.before)} -> {in_unit(u.after, u.unit)}" for u in result.units if result.mended]
    for finding, change in zip(content["findings"], result.changes, strict=True):
        lines.append(f"  {_values(change, finding)}; held out {_moved(finding['held_out'])}")
        lines += [f"    {engine}: {_moved(gap)}" for engine, gap in finding["engines"].items()]
        for rival in finding["cannot_tell_from"]:
            lines.append(f"    cannot be told from {rival['effect']} at {rival['target']}: {rival['why']}")
    lines += _adjusted(result, content["adjusted"])
    if not result.changes:
        lines += [
            f"  closest: {lacks(result, c.change)}: training gap {number(c.before)} -> {number(c.after)}; {c.why}"
            for c in result.closest
        ]
    lines += [
        f"  worse: {w.signal} of {w.joint}: {number(w.before)} -> {in_unit(w.after, w.unit)}" for w in result.worsened
    ]
    lines += [f"  sensor: {sentence}" for sentence in content["sensor_faults"]]
    lines += [f"  {note}" for note in content["notes"]]
    if content["split"]:
        lines.append(f"  {content['split']}")
    if content["experiment"]:
        lines.append(f"  to record next: {content['experiment']}")
    return lines


def _parameter(name: str, told: dict[str, Any]) -> str:
    """A parameter with its unit and its 95 % interval, where it was fitted."""
    low, high = told["low"], told["high"]
    return f"{name} {quantity(told['value'], told['unit'])}" + (
        f" [{interval(low, high, told['unit'])}]" if low < high else ""
    )


def _values(change: Change, told: dict[str, Any]) -> str:
    """A change with its values."""
    if change.suspect.table is None:
        values = ", ".join(_parameter(n, p) for n, p in told["parameters"].items())
    else:
        every = told["parameters"]["values"]
        largest = quantity(float(np.max(np.abs(every["value"]))), every["unit"])
        values = f"{len(change.values)} values up to {largest}"
    return f"{change.suspect}: {values}"


def _moved(told: dict[str, float]) -> str:
    """A gap before and after."""
    return f"{number(told['before'])} -> {number(told['after'])}"


def _adjusted(result: Diagnosis, content: Sequence[dict[str, Any]]) -> list[str]:
    """What laws are off by, and the gap before and after all of it, in every engine."""
    if not content:
        return []
    lines = [f"  adjusted, as far as laws are ordinarily off; held out {_moved(content[0]['held_out'])}"]
    lines += [f"    {_values(change, told)}" for change, told in zip(result.adjusted, content, strict=True)]
    return lines + [f"    {engine}: {_moved(gap)}" for engine, gap in content[0]["engines"].items()]
