"""What the page of a diagnosis says in words: the verdict, and findings as a person would say them."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace

from realitygap.diagnose.candidates.suspects import neutral
from realitygap.diagnose.candidates.told import TELLERS
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.units import table_units, unit_there
from realitygap.diagnose.judge.gaps import CLEAR
from realitygap.diagnose.judge.locate import Place
from realitygap.diagnose.judge.steps import MANY
from realitygap.diagnose.result.diagnosis import LAW, Diagnosis
from realitygap.diagnose.result.odds import odds
from realitygap.diagnose.search.rivals import Rival
from realitygap.page.style import DIGITS, engine_label, number
from realitygap.robot.effects import EFFECTS, Parameter

WITH = {"error": "position error", "reversal": "time since the last reversal"}
"""What an unnamed effort depends on, in words, where its own name is not enough."""
CUT = "The search ended with its time, before all was tried"
"""What is said of what is left where the search was cut off: an effect that was not tried may explain it."""
SHARE = f"{100 * LAW:g} %"
"""What laws that are only nearly right may leave of a gap, in words."""
LEAST = 0.1
"""Engines are told to agree within this [%] where they agree better."""
NAMED = re.compile(rf"\b({'|'.join(EFFECTS)})\b")
"""An effect by its name."""
DEGREES = {"rad": "°", "rad/s": "°/s"}
"""Units that people read in degrees, and what they become."""
BRIEF = 0.01
"""Times below this [s] are read in ms."""


def effect_label(effect: str) -> str:
    """An effect in words: coulomb friction."""
    return effect.replace("_", " ")


def name_label(suspect: Suspect) -> str:
    """An effect in words; an effort that no law explains by what it depends on: unnamed effort of angle and load."""
    if suspect.table is None:
        return effect_label(suspect.effect)
    return f"unnamed effort of {' and '.join(WITH.get(v, v) for v in suspect.table.variables)}"


def target_label(suspect: Suspect) -> str:
    """Where it sits, in words."""
    return "all joints" if suspect.target == "*" else suspect.where


def suspect_label(suspect: Suspect) -> str:
    """An effect and where it sits: coulomb friction at elbow."""
    return f"{name_label(suspect)} at {target_label(suspect)}"


def rival_label(rival: Rival) -> str:
    """What stands in the place of a finding: base tilt at base and link inertia at forearm."""
    return listed([suspect_label(s) for s in rival.suspects])


def listed(items: list[str]) -> str:
    """a, b and c."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"


def quantity(value: float, unit: str, *, short: bool = False, digits: int = DIGITS) -> str:
    """A parameter's value as people read it: 0.250 N·m, 1.80 ms, 0.840° (0.0147 rad), in short 0.840°."""
    if unit in DEGREES and math.isfinite(value) and not short:
        return f"{_people(value, unit)} ({number(value)} {unit})"
    return _people(value, unit, digits)


def interval(low: float, high: float, unit: str, *, word: str = "to", digits: int = DIGITS) -> str:
    """Two values in the same words and one unit: a 95 % interval, or what was and what is."""
    factor, _ = _for_people(unit, max(abs(low), abs(high)))
    return f"{number(low * factor, digits)} {word} {_people(high, unit, digits, max(abs(low), abs(high)))}"


def _people(value: float, unit: str, digits: int = DIGITS, largest: float | None = None) -> str:
    factor, label = _for_people(unit, abs(value) if largest is None else largest)
    return f"{number(value * factor, digits)}{' ' * (label != '°')}{label}".strip()


def _for_people(unit: str, largest: float) -> tuple[float, str]:
    """What values in a unit are multiplied by for people, where the largest is this, and their unit then."""
    if unit in DEGREES:
        return math.degrees(1.0), DEGREES[unit]
    return (1e3, "ms") if unit == "s" and 0.0 < largest < BRIEF else (1.0, unit)


def model_value(problem: Problem, suspect: Suspect, parameter: Parameter) -> str:
    """What the scenario's model has there, in words."""
    if not has(problem, suspect, parameter):
        return "none"
    unit, (low, high) = unit_there(problem, suspect, parameter), own_reach(problem, suspect, parameter)
    return quantity(low, unit) if low == high else interval(low, high, unit)


def has(problem: Problem, suspect: Suspect, parameter: Parameter) -> bool:
    """Whether the scenario's model has a parameter: not where it is absent, or all that it is the shape of."""

    def absent(parameters: list[Parameter]) -> bool:
        reach = [(p.absent, own_reach(problem, suspect, p)) for p in parameters]
        return bool(reach) and all(nothing is not None and own == (nothing, nothing) for nothing, own in reach)

    whose = [p for p in suspect.kind.parameters if not p.shape] if parameter.shape else []
    return not absent([parameter]) and not absent(whose)


def own_reach(problem: Problem, suspect: Suspect, parameter: Parameter) -> tuple[float, float]:
    """The least and the most that the scenario's model has at the joints, or links, of a suspect."""
    each = [neutral(problem.plant, replace(suspect, indices=(i,)))[parameter.name] for i in suspect.indices]
    return min(each), max(each)


def lacks(result: Diagnosis, change: Change) -> str:
    """A finding as part of a sentence: `coulomb friction at elbow is missing (torque 0.250 N·m)`."""
    if change.suspect.table is not None:
        return _unnamed(result, change)
    effect, problem = EFFECTS[change.suspect.effect], result.problem
    zero = neutral(problem.plant, change.suspect)
    label = suspect_label(change.suspect)
    told = (p for p in effect.parameters if not p.shape or p.absent is not None)
    shown = [p for p in told if change.parameters[p.name] != zero[p.name]]
    shown = shown or list(effect.parameters[:1])
    units = {p.name: unit_there(problem, change.suspect, p) for p in shown}
    factors = all(zero[p.name] == 1.0 for p in shown)  # of what every model has
    missing = not factors and all(_none(p, zero[p.name]) for p in shown)
    now, had = [], []
    for p in shown:
        name = f"{p.name.replace('_', ' ')} " if len(shown) > 1 or not units[p.name] else ""
        low, high = own_reach(problem, change.suspect, p)
        own = _people(low, units[p.name]) if low == high else interval(low, high, units[p.name])
        had.append(f"{name}{own}")
        now.append(f"{name}{_people(change.parameters[p.name], units[p.name])}")
    if missing:
        return f"{label} is missing ({listed(now)})"
    return f"{label} is wrong ({listed(had)} in the model, {listed(now)} by the recordings)"


def in_words(text: str) -> str:
    """A sentence in which effects are called by words; joints and links keep their names."""
    return NAMED.sub(lambda found: effect_label(found[0]), text)


def _none(parameter: Parameter, value: float) -> bool:
    """Whether a model with that value has none of an effect; a place at zero is one."""
    return value == parameter.absent or (value == 0.0 and parameter.low >= 0.0) or math.isinf(value)


def _unnamed(result: Diagnosis, change: Change) -> str:
    """An unnamed effort as part of a sentence: `an unnamed effort of speed at elbow is missing (up to 0.250 N·m)`."""
    unit, _ = table_units(result.problem, change.suspect)
    most = max(abs(v) for _, v in change.values)
    return f"an {suspect_label(change.suspect)} is missing (up to {_people(most, unit)})"


def _grouped(changes: Sequence[Change]) -> str:
    """Many findings as part of a sentence: `coulomb friction at 6 joints and link mass at 3 links are ...`."""
    found: dict[str, list[Suspect]] = {}
    for change in changes:
        found.setdefault(name_label(change.suspect), []).append(change.suspect)
    told = []
    for effect, where in found.items():
        alone = len(where) == 1
        told.append(f"{effect} at {target_label(where[0]) if alone else places(where)}")
    return f"{listed(told)} {'are' if len(changes) > 1 else 'is'} missing or wrong"


def _adjusted(changes: Sequence[Change]) -> str:
    """What laws are off by as part of a sentence: `base tilt adjusted`, or `5 other values adjusted`."""
    return f"{_values(changes, 'other ')} adjusted as far as laws are ordinarily off"


def _values(changes: Sequence[Change], other: str = "") -> str:
    """What is adjusted: `base tilt`, or `5 values`."""
    return suspect_label(changes[0].suspect) if len(changes) == 1 else f"{len(changes)} {other}values"


def places(where: Sequence[Suspect]) -> str:
    """How many joints, or links, several findings of one effect are at: two types of servo are many joints."""
    return f"{len({i for suspect in where for i in suspect.indices})} {where[0].kind.sits_at}s"


def verdict(result: Diagnosis) -> str:
    """The verdict in one sentence."""
    before, after = result.gap("held_out")
    changes = result.changes
    if result.verdict == "no gap":
        return (
            "Nothing is missing: simulation and recordings agree within the floors "
            f"(the gap on held-out motions is {number(before)} times the floor)."
        )
    if result.verdict == "unexplained":
        return _unexplained(result)
    what = _grouped(changes) if len(changes) > MANY else listed([lacks(result, c) for c in changes])
    how = _moved(before, after)
    text = f"{what[0].upper()}{what[1:]}: {'' if how.startswith('falls') else 'but '}"
    beside = f", and {_adjusted(result.adjusted)}," if result.adjusted else ""
    text += f"with {'it' if len(changes) == 1 else 'them'}{beside} the gap on held-out motions {how} times the floor"
    if result.verdict == "explained":
        text += f", at most {SHARE} of what it was" if after > CLEAR else ""
        return f"{text}. {CUT}." if result.found.cut else f"{text}, and nothing worth a name is left."
    text += f". Something else is missing{_most(result.left)}"
    return f"{text}. {CUT}." if result.found.cut else f"{text}, which no effect explains."


def rule(result: Diagnosis) -> str:
    """Up to which gap the verdict is a good one, in one sentence."""
    if result.verdict == "no gap":
        return f"Counts as no gap up to {CLEAR:g} floors, on held-out and on training motions."
    return (
        f"Counts as explained where the gap that is left is at most {CLEAR:g} floors, or at most {SHARE} of what it "
        "was, on held-out and on training motions."
    )


def agreement(result: Diagnosis) -> str:
    """How closely engines agree on the gap that the mended model leaves, in one sentence; empty without another one."""
    if not result.mended or not (others := result.shown[result.mended[-1].suspect].engines):
        return ""
    left = {result.engines[0]: result.shown[result.mended[-1].suspect].after, **{e: a for e, (_, a) in others.items()}}
    low, high = min(left, key=lambda e: left[e]), max(left, key=lambda e: left[e])
    apart = 100.0 * (left[high] / left[low] - 1.0)
    ends = f"from {number(left[low])} floors in {engine_label(low)} to {number(left[high])} in {engine_label(high)}"
    if number(left[low]) == number(left[high]):
        ends = f"{number(left[low])} floors in each of them"
    within = number(max(apart, LEAST), 2)
    return f"{len(left)} engines agree on the gap that is left on held-out motions within {within} %: {ends}."


def _unexplained(result: Diagnosis) -> str:
    """The verdict where nothing was named and there is a gap."""
    before, after = result.gap("held_out")
    if result.adjusted and result.closed:
        return (
            "Nothing is missing that is more than laws are ordinarily off by: with "
            f"{_values(result.adjusted)} adjusted the gap on held-out motions {_moved(before, after)} times the floor."
        )
    text = f"the gap on held-out motions is {number(before)} times the floor{_most(result.where)}"
    rest = f" With {_adjusted(result.adjusted)} it {_moved(before, after)}." if result.adjusted else ""
    if result.found.cut:
        return f"Something is missing: {text}. {CUT}, and nothing that it had tried explains it well enough.{rest}"
    if result.where and result.where[0].joint in result.blamed:
        return f"A mistake is likely where the gap is, so that nothing was looked for there: {text}.{rest}"
    return (
        f"Something is missing that no effect explains: {text}, and no effect explains it better than something else "
        f"would.{rest}"
    )


def _moved(before: float, after: float) -> str:
    """What becomes of a gap: `falls from 45 to 11`; a change that its digits do not show is none."""
    a, b = number(before), number(after)
    if a == b:
        return f"stays at {a}"
    return f"{'falls' if after < before else 'rises'} from {a} to {b}"


def better(result: Diagnosis, change: Change) -> str:
    """How much better a finding is than the next best explanation, or how recordings alone show it, in one sentence."""
    if change.suspect in result.deviations:
        return f"Recordings show it by themselves, before anything is simulated: {TELLERS[change.suspect.effect].how}."
    rivals = result.found.rivals.get(change.suspect, [])
    gain = result.found.gains.get(change.suspect)
    said = "" if gain is None else f"Without it the recordings are {odds(gain)} times less probable"
    if not rivals:
        return f"{said}, and nothing on the list comes near it." if said else ""
    other, less = rival_label(rivals[0]), odds(rivals[0].behind)
    if rivals[0].open:
        verb = "explains" if rivals[0].beside is None else "together explain"
        return f"{said}; {other} in its place {verb} them as well."
    return f"{said}; with the next best explanation, {other}, they are {less} times less probable than with it."


def _most(places: list[Place]) -> str:
    if not places:
        return ""
    worst = places[0]
    where = "the base" if worst.joint == "base" else worst.joint
    when = "" if worst.when == ("throughout",) else f" while {listed([WHILE[w] for w in worst.when])}"
    return f", most of all in the {worst.signal.removeprefix('base_')} of {where}{when}"


WHILE = {
    "holding": "holding",
    "moving": "moving",
    "reversal": "reversing",
    "saturation": "saturated",
    "impact": "hitting the ground",
    "loaded": "loaded",
}
"""Phases as part of a sentence."""
