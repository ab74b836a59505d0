"""Plain sentences that a person can act on, each computed from the table.

Two gaps closer than their floors are no difference; a change that helps one signal and harms another is said in one
breath.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import pandas as pd

from realitygap.compare.row import outcome_told
from realitygap.files.found import part_of
from realitygap.page.style import AXES, SIGNALS, axis_value, engine_label, number, quantity
from realitygap.report.folder import Results
from realitygap.report.groups import groups, joints_of, kinds
from realitygap.report.levels import Level, differ, joined, levels

SAME = "no difference seen"
NO_RESULT = "No simulation came to its end: there is no trace and no gap."


@dataclass(frozen=True)
class Sentence:
    """A sentence and what it is about: virtual, mistake, failed, closest, gap, change, enough, speed or joint."""

    about: str
    text: str


def sentences(results: Results) -> list[Sentence]:
    """All sentences, those on moving joints and the base before those on unmoving joints."""
    out = [*virtual(results), *mistakes(results), *failures(results.cells)]
    if (results.cells["outcome"] != "ok").all():
        return [*out, Sentence("failed", NO_RESULT)]
    if results.gaps.empty:
        return [*out, Sentence("virtual", "Nothing was measured: there are traces and no gaps.")]
    rest: list[Sentence] = []
    changing = [a for a in results.varying if a not in ("engine", "recording", "scenario", "step_rate")]
    changing = [a for a in changing if a != "solver_iterations"]
    for group in groups(results.means):
        part = results.means[results.means["group"] == group]
        found = [s for s in (closest(p, results) for p in _by_signal(part)) if s]
        found += [s for axis in changing for s in changes(part, axis, results)]
        still = group.startswith("unmoving")
        if not still:
            found += [s for axis in ("step_rate", "solver_iterations") for s in enough(part, axis, results)]
            found += [] if any(s.about == "speed" for s in out) else speed(part, results)
        (rest if still else out).extend(found)
    return [*out, *worst_joint(results), *rest]


def virtual(results: Results) -> list[Sentence]:
    """That virtual recordings say nothing of reality."""
    text = "The recordings are virtual: they come from a simulation, and nothing is concluded about reality from them."
    return [Sentence("virtual", text)] if results.virtual else []


def mistakes(results: Results) -> list[Sentence]:
    """What is likely a mistake in the scenario, which no physics explains."""
    found = (results.manifest.get("notes") or {}).get("likely mistakes") or []
    return [Sentence("mistake", _stop(f"Likely a mistake: {text}")) for text in found]


def failures(cells: pd.DataFrame) -> list[Sentence]:
    """What did not finish, and the first reason given, per engine and outcome."""
    bad = cells[cells["outcome"] != "ok"]
    out = []
    for (engine, outcome), part in bad.groupby(["engine", "outcome"], sort=True):
        first = part.iloc[0]
        count = part_of(len(part), int((cells["engine"] == engine).sum()), "cell")
        what = {"timeout": "took too long"}.get(str(outcome), f"{outcome}")
        why = _stop(outcome_told(what, first["note"]))
        out.append(Sentence("failed", f"{engine_label(str(engine))}: {count} {why}"))
    return out


def closest(part: pd.DataFrame, results: Results, axis: str = "engine") -> Sentence | None:
    """Which value of an axis comes closest in one signal, and which are as close within the floors."""
    found = levels(part, axis, list(results.axes))
    if not found:
        return None
    unit, where = str(part["unit"].iloc[0]), _what(part)
    best, *others = sorted(found, key=lambda level: level.gap)
    name = axis_value(axis, best.value)
    over = "" if best.contexts == 1 else f", mean of {best.contexts} comparisons"
    text = f"{quantity(best.gap, unit)} ({floors(best, unit)}{over})"
    alike = [o for o in others if not differ(best, o)]
    apart = [o for o in others if differ(best, o)]
    hit = "" if best.seen else f"; {SAME} from the recording"
    if not others:
        return Sentence("gap", f"{name} is this far from the recording in {where}: {text}{hit}.")
    if not apart:
        rest = _list(f"{axis_value(axis, o.value)} {quantity(o.gap, unit)}" for o in others)
        return Sentence("closest", f"In {where}, {SAME} between {name}, {text}, and {rest}{hit}.")
    more = (
        [f"{SAME} to {_list(f'{axis_value(axis, o.value)} ({quantity(o.gap, unit)})' for o in alike)}"] if alike else []
    )
    more += [
        f"{axis_value(axis, o.value)} is {_further(o.gap, best.gap, unit)} ({quantity(o.gap, unit)})" for o in apart
    ]
    return Sentence("closest", f"{name} comes closest in {where}: {text}; {'; '.join(more)}{hit}.")


def changes(part: pd.DataFrame, axis: str, results: Results) -> list[Sentence]:
    """The value of an axis that is best in the first signal, against every other one, in all signals."""
    found = {(_signal(p), str(p["unit"].iloc[0])): levels(p, axis, list(results.axes)) for p in _by_signal(part)}
    first = next(iter(found.values()), [])
    if len(first) < 2:
        return []
    best = min(first, key=lambda level: level.gap)
    group = joints_of(str(part["group"].iloc[0]))
    out = []
    for other in first:
        if other.value == best.value:
            continue
        words: dict[str, list[str]] = {"improves": [], "worsens": [], SAME: []}
        for (signal, unit), values in found.items():
            pair = {level.value: level for level in values}
            if best.value not in pair or other.value not in pair:
                continue
            new, old = pair[best.value], pair[other.value]
            verdict = SAME if not differ(new, old) else "improves" if new.gap < old.gap else "worsens"
            step = (
                f"{signal} by {quantity(abs(old.gap - new.gap), unit)} ({number(old.gap)} → {quantity(new.gap, unit)}"
            )
            words[verdict].append(signal if verdict == SAME else f"{step}; {floors(new, unit)})")
        name = f"{AXES.get(axis, axis)} {axis_value(axis, best.value)} instead of {axis_value(axis, other.value)}"
        out.append(Sentence("change", f"On {group}, {name} {_verdicts(words)}."))
    return out


def _verdicts(words: dict[str, list[str]]) -> str:
    better, worse, same = words["improves"], words["worsens"], words[SAME]
    parts = []
    if better:
        parts.append(f"improves {_list(better)}")
    if worse:
        parts.append(f"{'but ' if better else ''}worsens {_list(worse)}")
    if same:
        parts.append(f"{SAME} in {_list(same)}")
    return "; ".join(parts) if not (better and worse) else f"{parts[0]} {'; '.join(parts[1:])}"


def enough(part: pd.DataFrame, axis: str, results: Results) -> list[Sentence]:
    """Per engine, the lowest step rate or iteration count from which on none differs from the highest, in the first
    signal, and how much the one below it does.

    Engines in which none of those tried makes a difference share a sentence.
    """
    out = []
    alike: dict[tuple[str, str], dict[str, Level]] = {}
    signal = next(iter(_by_signal(part)), None)
    if signal is None or axis not in results.varying:
        return []
    unit, what = str(signal["unit"].iloc[0]), _what(signal)
    for engine, rows in signal.groupby("engine", sort=True):
        found = [v for v in levels(rows, axis, list(results.axes)) if v.value != ""]
        if len(found) < 2:
            continue
        k = len(found) - 1
        while k > 0 and not differ(found[k - 1], found[-1]):
            k -= 1
        name, here, top = engine_label(str(engine)), found[k], found[-1]
        at = f"{axis_value(axis, here.value)} ({quantity(here.gap, unit)}; {floors(here, unit)})"
        if k == 0:
            alike.setdefault((axis_value(axis, here.value), axis_value(axis, top.value)), {})[name] = here
            continue
        low, most = found[k - 1], axis_value(axis, top.value)
        how = (
            f"at {axis_value(axis, low.value)} the gap ({quantity(low.gap, unit)}) is {_larger(low.gap, top.gap, unit)}"
        )
        if here is top:
            text = f"{how} at {at}, the highest tried, which may not be enough"
        else:
            text = f"{how} at {most} ({quantity(top.gap, unit)}); from {at} on, {SAME} to {most}"
        out.append(Sentence("enough", f"{name}, {what}: {text}."))
    for (least, most), where in alike.items():
        gaps = [level.gap for level in where.values()]
        worst = max(where.values(), key=lambda level: level.floor)
        span = quantity(gaps[0], unit) if len(gaps) == 1 else f"{number(min(gaps))} to {quantity(max(gaps), unit)}"
        text = f"{_list(where)}: {SAME} in {what} from {least} ({span}; {floors(worst, unit)}) up to {most}."
        out.append(Sentence("enough", text))
    return out


def speed(part: pd.DataFrame, results: Results) -> list[Sentence]:
    """The fastest choice of engine, step rate and iterations that is as close as the closest."""
    signal = next(iter(_by_signal(part)), None)
    if signal is None or "real_time_factor" not in results.cells:
        return []
    tuning = ["engine", "step_rate", "solver_iterations"]
    cells = results.cells.assign(choice=joined(results.cells, tuning))
    cells["simulated"] = cells["real_time_factor"] * cells["wall_seconds"]
    total = cells.groupby("choice")[["simulated", "wall_seconds"]].sum()
    factor = total["simulated"] / total["wall_seconds"]
    others = [a for a in results.axes if a not in tuning]
    choices = levels(signal.assign(choice=joined(signal, tuning)), "choice", ["choice", *others])
    found = [v for v in choices if factor[v.value] > 0]
    if len(found) < 2:
        return []
    unit, what = str(signal["unit"].iloc[0]), _what(signal)
    best = min(found, key=lambda v: v.gap)
    fastest = max((v for v in found if not differ(v, best)), key=lambda v: float(factor[v.value]))

    def name(level: Level) -> str:
        engine, rate, iterations = level.value.split("\x1f")
        extra = f", {iterations} iterations" if iterations else ""
        return f"{engine_label(engine)} at {float(rate):g} Hz{extra} ({number(float(factor[level.value]))} × real time)"

    if fastest is best:
        text = f"{name(best)} is the closest in {what}, and nothing as close is faster: {quantity(best.gap, unit)}"
    else:
        text = f"{name(fastest)} is the fastest with {SAME} in {what} to the closest, {name(best)}: "
        text += f"{quantity(fastest.gap, unit)} against {quantity(best.gap, unit)}"
    return [Sentence("speed", f"{text} ({floors(best, unit)}).")]


def worst_joint(results: Results) -> list[Sentence]:
    """By every signal, the joint with the largest gap that is above its floors, and whether the engines agree on it."""
    ran = results.gaps[results.gaps["outcome"] == "ok"]
    parts = [(kind, part) for kind, rows in kinds(ran) for part in _by_signal(rows)]
    found = (_worst(part, kind, results) for kind, part in parts if part["joint"].nunique() > 1)
    return [s for s in found if s]


def _worst(rows: pd.DataFrame, kind: str, results: Results) -> Sentence | None:
    mean = rows.groupby("joint")[["mean_abs", "noise_floor", "numerical_floor"]].mean()
    seen = mean["mean_abs"][mean["mean_abs"] > mean[["noise_floor", "numerical_floor"]].max(axis=1).fillna(0.0)]
    if seen.empty:
        return None
    joint, signal = seen.idxmax(), _signal(rows)
    rows = rows[rows["joint"] == joint]
    unit = str(rows["unit"].iloc[0])
    found = sorted(levels(rows, "engine", list(results.axes)), key=lambda level: level.gap)
    if not found:
        return None
    low, high = found[0], found[-1]
    above = "" if joint == mean["mean_abs"].idxmax() else " above its floors"
    text = f"{joint} has the largest gap in {signal}{kind}{above}"
    if len(found) == 1:
        text += f": {quantity(low.gap, unit)} in {engine_label(low.value)} ({floors(low, unit)})."
    elif differ(low, high) and high.gap - low.gap > low.gap:
        text += f": from {quantity(low.gap, unit)} in {engine_label(low.value)} to {quantity(high.gap, unit)} in "
        text += f"{engine_label(high.value)} ({floors(high, unit)}): the engine matters there."
    else:
        text += (
            f", {quantity(low.gap, unit)} at least in every engine ({floors(low, unit)}); the engines' gaps lie within "
        )
        text += f"{quantity(high.gap - low.gap, unit)}, so another engine does not close it."
    return Sentence("joint", text)


def floors(level: Level, unit: str) -> str:
    """Both floors in words."""
    return f"noise floor {_floor(level.noise, unit)}, numerical floor {_floor(level.numerical, unit)}"


def _floor(value: float, unit: str) -> str:
    return quantity(value, unit, 2) if value == value else "unknown"


def _by_signal(part: pd.DataFrame) -> list[pd.DataFrame]:
    """The rows of every signal, in the order people read them."""
    return [rows for signal in SIGNALS if not (rows := part[part["signal"] == signal]).empty]


def _signal(part: pd.DataFrame) -> str:
    return SIGNALS[str(part["signal"].iloc[0])]


def _what(part: pd.DataFrame) -> str:
    """The signal and whose it is: velocity of moving joints, base orientation."""
    group = str(part["group"].iloc[0])
    return _signal(part) if group == "base" else f"{_signal(part)} of {joints_of(group)}"


def _further(a: float, b: float, unit: str) -> str:
    """How much further a is than b: as a factor, or where that is near one as a difference."""
    return f"{_times(a, b)} as far" if a > 1.2 * b else f"{quantity(a - b, unit, 2)} further"


def _larger(a: float, b: float, unit: str) -> str:
    """How much larger, or smaller, a is than b: as a factor, or where that is near one as a difference."""
    if a > 1.2 * b:
        return f"{_times(a, b)} as large as"
    return f"{quantity(abs(a - b), unit, 2)} {'larger' if a > b else 'smaller'} than"


def _times(a: float, b: float) -> str:
    return f"{a / b:.2g} times" if b > 0 else "infinitely"


def _list(items: Iterable[str]) -> str:
    words: Sequence[str] = list(items)
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _stop(text: str) -> str:
    return text if text.endswith(".") else f"{text}."
