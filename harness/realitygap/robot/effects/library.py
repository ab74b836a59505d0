"""The effects as functions: `effects.coulomb_friction("elbow", torque=0.6)` is what a scenario says in its file."""

import inspect
import textwrap
from collections.abc import Callable, Sequence
from typing import Any

from realitygap.files.errors import meant_first, standing
from realitygap.files.validation import validate
from realitygap.robot.effects import WRITABLE, Effect, Parameter
from realitygap.robot.effects.place import values
from realitygap.scenario.plain import plain
from realitygap.scenario.schema import EffectSpec

Make = Callable[..., EffectSpec]


class Effects:
    """One function per effect, made from the table of effects.

    Each takes a target (a joint, a link, `ground` or `base`, or joint patterns; `*`: all of them) and the effect's
    parameters by name, as totals that replace the model's own. `help(effects.backlash)` tells the physics.
    """

    def __getattr__(self, name: str) -> Make:
        if name not in WRITABLE:
            raise AttributeError(f"there is no effect {name}{meant_first(name, WRITABLE, 'known')}")
        return _function(WRITABLE[name])

    def __dir__(self) -> list[str]:
        return list(WRITABLE)

    def __repr__(self) -> str:
        return f"<effects: {', '.join(WRITABLE)}>"


def _function(effect: Effect) -> Make:
    def make(target: str | Sequence[str] = "*", **parameters: Any) -> EffectSpec:
        spec = validate(
            f"effect {effect.name}", EffectSpec, plain({"effect": effect.name, "target": target, **parameters})
        )
        with standing(f"effect {effect.name}: "):
            values(effect, spec)
        return spec

    make.__name__ = make.__qualname__ = effect.name
    make.__doc__ = _told(effect)
    make.__signature__ = _signature(effect)  # type: ignore[attr-defined]  # what help() and editors show
    return make


def _signature(effect: Effect) -> inspect.Signature:
    first = inspect.Parameter("target", inspect.Parameter.POSITIONAL_OR_KEYWORD, default="*")
    rest = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, annotation=list) for name in effect.example]
    rest += [
        inspect.Parameter(
            p.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=inspect.Parameter.empty if p.default is None else p.default,
            annotation=float,
        )
        for p in effect.parameters
    ]
    return inspect.Signature([first, *rest], return_annotation=EffectSpec)


def _told(effect: Effect) -> str:
    lines = [textwrap.fill(effect.page.physics, 88), "", f"    {effect.page.equation}", "", "Args:"]
    lines.append(f"    target: the {effect.sits_at}" + (", or patterns" if effect.sits_at in ("joint", "link") else ""))
    lines += [f"    {name}: such as {value}" for name, value in effect.example.items()]
    lines += [f"    {_line(p)}" for p in effect.parameters]
    return "\n".join([*lines, "", "Raises:", "    InputError: for a parameter that it does not have, or a value."])


def _line(p: Parameter) -> str:
    neutral = "the model's own" if p.absent is None else f"{p.absent:g}"
    return f"{p.name}: {f'[{p.unit}] ' if p.unit else ''}{p.low:g} to {p.high:g}; neutral: {neutral}"


effects = Effects()
