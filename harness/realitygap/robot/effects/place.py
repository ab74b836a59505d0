"""Putting the effects that a scenario names into a plant, with one sentence for what cannot be."""

import fnmatch
import math
from collections.abc import Sequence

from realitygap.files.errors import InputError, did_you_mean, meant_first, standing
from realitygap.files.found import shown
from realitygap.robot.effects import WRITABLE, Effect
from realitygap.robot.plant import Plant
from realitygap.scenario.schema import EffectSpec


def targets(plant: Plant, effect: Effect, target: str | Sequence[str]) -> list[int]:
    """The joints or links that a target names; [0] for ground and base.

    Raises:
        InputError: for a target that names nothing, with what exists.
    """
    wanted = [target] if isinstance(target, str) else list(target)
    if not wanted:
        raise InputError(f"target: is empty; expected a {effect.sits_at}")
    if effect.sits_at in ("ground", "base"):
        if wanted not in ([effect.sits_at], ["*"]):
            there = f"expected {effect.sits_at}, where {effect.name} sits"
            raise InputError(f"target: found {', '.join(wanted)}; {there}")
        return [0]
    if effect.sits_at == "joint":
        names = plant.model.joint_names
    else:
        names = [link.name for link in plant.model.links]  # the links fixed to one of them are named, too
        merged = {m: link.name for link in plant.model.links for m in link.merged}
        wanted = [merged.get(w, w) for w in wanted]
    for pattern in wanted:
        if not any(fnmatch.fnmatchcase(name, pattern) for name in names):
            raise InputError(f"target: no {effect.sits_at} {pattern}; the robot has {', '.join(names)}")
    return [i for i, name in enumerate(names) if any(fnmatch.fnmatchcase(name, p) for p in wanted)]


def values(effect: Effect, spec: EffectSpec) -> dict[str, float]:
    """The checked parameter values of one effect of a scenario; what is wrong begins with the parameter's name.

    Raises:
        InputError: for an unknown or missing parameter, or a value that is no number or out of bounds.
    """
    if effect.read:
        return effect.read(spec.parameters)
    known = {p.name: p for p in effect.parameters}
    out: dict[str, float] = {}
    for name, value in spec.parameters.items():
        if name not in known:
            raise InputError(f"{name}: unknown parameter; {_listed(effect)}{did_you_mean(name, known)}")
        if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
            in_unit = f" in {known[name].unit}" if known[name].unit else ""
            raise InputError(f"{name}: found {shown(value)}; expected a number{in_unit}")
        low, high = known[name].low, known[name].high
        neutral = known[name].absent
        if not low <= value <= high and value != neutral:
            found = f"{value:g} {known[name].unit}".rstrip()
            raise InputError(f"{name}: found {found}; expected {low:g} to {high:g}")
        out[name] = float(value)
    for parameter in effect.parameters:
        if parameter.name not in out:
            if parameter.default is None:
                raise InputError(f"{parameter.name}: is missing; {_listed(effect)}")
            out[parameter.name] = parameter.default
    if effect.contradiction and (reason := effect.contradiction(out)):
        raise InputError(reason)
    return out


def _listed(effect: Effect) -> str:
    """What an effect needs and what it may have, each with its unit."""
    needed = ", ".join(p.with_unit for p in effect.parameters if p.default is None)
    further = ", ".join(p.with_unit for p in effect.parameters if p.default is not None)
    parts = [f"{verb} {names}" for verb, names in (("needs", needed), ("may have", further)) if names]
    return f"{effect.name} {' and '.join(parts)}"


def known(name: str, key: str = "effects") -> Effect:
    """The effect of that name, which stands at a key. Raises InputError with those there are."""
    if name not in WRITABLE:
        raise InputError(f"{key}: unknown effect {name}{meant_first(name, WRITABLE, 'known')}")
    return WRITABLE[name]


def place(plant: Plant, specs: Sequence[EffectSpec]) -> Plant:
    """A plant with the effects of a scenario, in whatever order it names them.

    Raises:
        InputError: for an unknown effect, target or parameter, the same effect twice on a target, two effects that
            exclude each other there, or an effect that cannot act there.
    """
    plant = plant.copy()
    seen: set[tuple[str, int]] = set()
    waiting: list[tuple[str, Effect, list[int], dict[str, float]]] = []
    for number, spec in enumerate(specs):
        effect = known(spec.effect, f"effects[{number}]")
        with standing(f"effects[{number}]."):
            indices, checked = targets(plant, effect, spec.target), values(effect, spec)
        for i in indices:
            for other in (effect.name, *effect.excludes):
                if (other, i) in seen and not effect.repeatable:
                    what = "stands twice on" if other == effect.name else f"and {other} exclude each other on"
                    said = f"{effect.name} {what} {_written(spec.target)}; expected one of them"
                    raise InputError(f"effects[{number}]: {said}")
            seen.add((effect.name, i))
        waiting.append((f"effects[{number}]: {effect.name} on {_written(spec.target)}", effect, indices, checked))
    while waiting:  # an effect may need another: a compliance needs a rotor inertia
        possible = [w for w in waiting if not _reason(plant, w[1], w[2])]
        if not possible:
            where, effect, indices, _ = waiting[0]
            raise InputError(f"{where}: {_reason(plant, effect, indices)}")
        for _, effect, indices, checked in possible:
            effect.apply(plant, indices, checked)
        waiting = [w for w in waiting if w not in possible]
    return plant


def _reason(plant: Plant, effect: Effect, indices: list[int]) -> str | None:
    """Why an effect cannot act at one of the indices; None where it can at all of them."""
    return next((reason for i in indices if (reason := effect.possible(plant, i))), None)


def _written(target: str | Sequence[str]) -> str:
    return target if isinstance(target, str) else ", ".join(target)
