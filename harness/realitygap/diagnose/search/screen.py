"""Screening: every suspect gets a fair first try, by the change of the traces that a sensible size of it makes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import lsq_linear

from realitygap.diagnose.candidates.suspects import bounds, neutral, sizes, whole
from realitygap.diagnose.data.decoys import KNOWN
from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.data.problem import WORST, Change, Problem, Suspect
from realitygap.diagnose.fit.probes import SHAPES, combined, crowded, joint_mask, probes, signed, single, with_values
from realitygap.robot.drive import Array
from realitygap.robot.effects import Effect

FURTHEST = 12.0
"""How many first sizes a straight line is followed at most."""
UNSEEN = 0.3
"""What a straight line promises is believed by this much."""
KIN = 6
"""Guesses of one effect that are simulated, at most."""
GROUP = 0.3
"""A group of joints promises something with this share of what the best guess does."""
NEARLY = 0.9
"""A guess that explains this share of what the straight line promises is not tried at half its size, but at more."""
ONWARD = 2
"""How often a guess that keeps its promise is doubled, while that explains more: a straight line may end too early."""


@dataclass(frozen=True)
class Screened:
    """A suspect with a first guess and the share of the squared residual that it explains there, simulated."""

    change: Change
    explained: float


def screen(
    pool: Pool, suspects: Sequence[Suspect], accepted: Sequence[Change], train: Sequence[int], deep: int = 20
) -> list[Screened]:
    """The suspects that explain most of what is left, best first.

    A straight line through the change of the traces at a first size gives a guess of the size and of what it would
    explain, beside what a change of the accepted parameters would; the `deep` best are simulated at their guess, and
    the best joint of every effect that was tried on all joints at once.
    """
    problem = pool.problem
    residual = [problem.residuals(accepted, c) for c in train]
    coarse = _signature(problem, tuple(accepted), tuple(train))
    tangent = _tangent(pool, accepted, train, coarse)
    many = crowded(problem)
    alone = [s for s in suspects if not (many and single(s))]
    shared = [s for s in suspects if many and single(s)]
    tries = {s: probes(problem, s, residual) for s in alone}
    base = np.concatenate([r / np.sqrt(len(r)) for r in residual])
    questions = [((*accepted, p), tuple(train)) for s in alone for group in tries[s] for p in group]
    together = combined(problem, shared, residual)
    questions += [((*accepted, *column.values()), tuple(train)) for _, column in together]
    answers = iter(pool.map(_signature, questions))
    robust = 1.0 / np.sqrt(1.0 + (base / (3 * np.sqrt(np.mean(base**2)) + 1e-12)) ** 2)
    found: dict[Suspect, list[list[tuple[Change, Array]]]] = {
        s: [[(p, next(answers) - coarse) for p in group] for group in tries[s]] for s in alone
    }
    masks = {s.indices[0]: joint_mask(problem, train, s.indices[0]) for s in shared}
    for start_number, column in together:
        change = next(answers) - coarse
        for suspect, probe in column.items():
            groups = found.setdefault(suspect, [])
            if start_number == len(groups):
                groups.append([])
            groups[start_number].append((probe, np.where(masks[suspect.indices[0]], change, 0.0)))
    guesses = [_guess(problem, s, group, base, tangent, robust) for s, groups in found.items() for group in groups]
    ordered = sorted((g for g in guesses if g is not None), key=lambda g: -g.explained)
    ranked = _worth_simulating(ordered, set(shared), deep)
    rest = [g for g in ordered if g not in ranked]
    tried = pool.map(_tried, [(tuple(accepted), g, tuple(train), base, coarse, robust) for g in ranked])
    out = [Screened(g.change, UNSEEN * g.explained) for g in rest]
    for guess, truly in zip(ranked, tried, strict=True):
        out.append(replace(truly, explained=max(truly.explained, UNSEEN * guess.explained)))
    return _once(sorted(out, key=lambda s: -s.explained))


def _once(ranked: Sequence[Screened]) -> list[Screened]:
    """Of an effect that was tried to both sides, the better one: the sides are no different things."""
    seen: set[Suspect] = set()
    out = []
    for s in ranked:
        if s.change.suspect not in seen or not signed(KNOWN[s.change.suspect.effect]):
            out.append(s)
        seen.add(s.change.suspect)
    return out


def _signature(problem: Problem, changes: tuple[Change, ...], train: tuple[int, ...]) -> Array:
    """The residual of all training motions, each counting alike, simulated as coarsely as is faithful."""
    parts = [problem.coarse_residuals(changes, c) for c in train]
    return np.concatenate([r / np.sqrt(len(r)) for r in parts])


def _tried(
    problem: Problem,
    accepted: tuple[Change, ...],
    guess: Screened,
    train: tuple[int, ...],
    base: Array,
    coarse: Array,
    robust: Array,
) -> Screened:
    """A guess with what it explains when it is simulated; a straight line may lead too far, or end too early."""
    total = float(np.sum((robust * base) ** 2))
    change = guess.change
    effect, zero = KNOWN[change.suspect.effect], neutral(problem.plant, change.suspect)

    def truly(tried: Change) -> Screened:
        answer = base + _signature(problem, (*accepted, tried), train) - coarse
        return Screened(tried, 1.0 - float(np.sum((robust * answer) ** 2)) / total)

    def times(factor: float) -> Change:
        far = {n: zero[n] + factor * (v - zero[n]) for n, v in change.values if n in change.free and n not in SHAPES}
        low, high = bounds(change.suspect, list(far))
        return with_values(change, dict(zip(far, np.clip(list(far.values()), low, high).tolist(), strict=True)))

    best = truly(change)
    if whole(effect) or not _finite(zero):
        return best
    if best.explained < NEARLY * guess.explained:
        return Screened(change, max(best.explained, truly(times(0.5)).explained))
    for k in range(ONWARD):
        further = truly(times(2.0 ** (k + 1)))
        if further.explained <= best.explained:
            break
        best = further
    return best


def _finite(values: dict[str, float]) -> bool:
    return bool(np.isfinite(list(values.values())).all())


def _worth_simulating(ordered: Sequence[Screened], shared: set[Suspect], deep: int) -> list[Screened]:
    """The best `deep` guesses, few of one effect, and of a whole body the best joint of every effect and the groups of
    joints that promise something: what a try on all joints at once shows of a joint is only what happens at that joint,
    and the servo types are few suspects among the many single joints.
    """
    out: list[Screened] = []
    for guess in ordered:
        suspect = guess.change.suspect
        kin = [o.change.suspect for o in out if o.change.suspect.effect == suspect.effect]
        group = bool(shared) and len(suspect.indices) > 1 and guess.explained >= GROUP * ordered[0].explained
        if (len(out) < deep and len(kin) < KIN) or (suspect in shared and not kin) or group:
            out.append(guess)
    return out


def _tangent(pool: Pool, accepted: Sequence[Change], train: Sequence[int], coarse: Array) -> Array:
    """How the residual changes with each accepted parameter, from what it is without a change. Shape (samples, p)."""
    questions: list[tuple[tuple[Change, ...], tuple[int, ...]]] = []
    steps = []
    for i, change in enumerate(accepted):
        size = sizes(pool.problem.plant, change.suspect)
        for name in change.free:
            step = 0.05 * size[name]
            if change.parameters[name] + step > KNOWN[change.suspect.effect].parameter(name).high:
                step = -step
            moved = with_values(change, {name: change.parameters[name] + step})
            questions.append(((*accepted[:i], moved, *accepted[i + 1 :]), tuple(train)))
            steps.append(step / size[name])
    answers = pool.map(_signature, questions)
    if not steps:
        return np.zeros((len(coarse), 0))
    return np.column_stack([(a - coarse) / s for a, s in zip(answers, steps, strict=True)])


def _guess(
    problem: Problem, suspect: Suspect, found: list[tuple[Change, Array]], base: Array, tangent: Array, robust: Array
) -> Screened | None:
    """The best straight-line combination of a suspect's probes with the accepted parameters' tangents."""
    effect = KNOWN[suspect.effect]
    zero = neutral(problem.plant, suspect)
    good = [(p, s) for p, s in found if np.abs(s).max() < WORST / 1e3 and np.any(s)]
    if not good:
        return None
    target = -robust * base
    left = robust[:, None] * tangent
    alone = _left(left, target)
    if whole(effect) or effect.name.endswith("_joint_stop"):
        probe, signature = good[0]
        rest = _left(left, target - robust * signature)
        return Screened(probe, 1.0 - rest / max(alone, 1e-30))
    matrix = np.column_stack([left, *(robust * s for _, s in good)])
    low, high = np.full(matrix.shape[1], -np.inf), np.full(matrix.shape[1], np.inf)
    for i, (probe, _) in enumerate(good):
        low[left.shape[1] + i], high[left.shape[1] + i] = _reach(effect, probe, zero)
    solution = lsq_linear(matrix, target, bounds=(low, high), method="bvls", max_iter=60)
    amount = solution.x[left.shape[1] :]
    explained = 1.0 - float(np.sum((matrix @ solution.x - target) ** 2)) / max(alone, 1e-30)
    if effect.name == "torque_ripple" and len(amount) == 2:
        size = good[0][0].parameters["amplitude"]
        return Screened(
            with_values(
                good[0][0],
                {
                    "amplitude": max(size * float(np.hypot(*amount)), 0.05 * size),
                    "phase": float(np.arctan2(amount[1], amount[0])),
                },
            ),
            explained,
        )
    values: dict[str, float] = {}
    for (probe, _), x in zip(good, amount, strict=True):
        for name in _moved(probe, zero):
            p = effect.parameter(name)
            if np.isfinite(zero[name]):
                values[name] = float(np.clip(zero[name] + x * (probe.parameters[name] - zero[name]), p.low, p.high))
            else:  # a stiffness: half the stiffness gives twice as much
                values[name] = float(np.clip(probe.parameters[name] / max(x, 1e-3), p.low, p.high))
    return Screened(with_values(good[0][0], values), explained)


def _left(matrix: Array, target: Array) -> float:
    if not matrix.shape[1]:
        return float(target @ target)
    solution = np.linalg.lstsq(matrix, target, rcond=None)[0]
    rest = matrix @ solution - target
    return float(rest @ rest)


def _moved(change: Change, zero: dict[str, float]) -> list[str]:
    """The parameters that a probe moved away from neutral."""
    return [n for n in change.free if n not in SHAPES and change.parameters[n] != zero[n]]


def _reach(effect: Effect, probe: Change, zero: dict[str, float]) -> tuple[float, float]:
    """How far a probe may be followed, in its own size, within the bounds of its parameters."""
    if effect.name == "torque_ripple":
        return -FURTHEST, FURTHEST
    low, high = -FURTHEST, FURTHEST
    for name in _moved(probe, zero):
        p = effect.parameter(name)
        if not np.isfinite(zero[name]):
            low = max(low, 0.0)
            continue
        change = probe.parameters[name] - zero[name]
        a, b = sorted(((p.low - zero[name]) / change, (p.high - zero[name]) / change))
        low, high = max(low, a), min(high, b)
    return min(low, 0.0) - 1e-9, max(high, 0.0) + 1e-9
