"""First tries: how every suspect is tried before anything is fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from realitygap.diagnose.candidates.suspects import fitted, neutral, sizes, whole
from realitygap.diagnose.data.decoys import KNOWN
from realitygap.diagnose.data.problem import Change, Problem, Suspect
from realitygap.diagnose.fit.fit import start
from realitygap.robot.drive import Array
from realitygap.robot.effects import Effect

WHOLE_FIRST = (1.8, 1.3, 0.9, 0.65, 0.45, 0.3, 0.2)
WHOLE_SECOND = (1.0, 2.5)
"""What the first sizes are multiplied by for effects whose parameters only mean something together."""
SOFTER = (1.0, 0.3, 0.1)
"""What the first size of a stiffness is multiplied by: a soft spring swings as no straight line tells."""
SLIPPERIER = (0.6, 0.3, 0.15)
"""What the friction of the ground is multiplied by: what does not slip yet shows nothing, as no straight line tells."""
TO_BOTH_SIDES = (1.0, -1.0, 3.0, -3.0)
"""What the first size is multiplied by where it may have either sign: play and friction that holds answer unevenly."""
MANY_JOINTS = 6
"""With more joints than this, an effect is tried on all joints at once and each joint's answer is its own."""
SHAPES = ("periods", "phase", "velocity", "exponent")
"""Parameters that only shape what others do: they are not tried on their own."""


def probes(problem: Problem, suspect: Suspect, residual: Sequence[Array] | None = None) -> list[list[Change]]:
    """First tries of a suspect: per start a list of changes, each of one parameter."""
    effect = KNOWN[suspect.effect]
    zero = neutral(problem.plant, suspect)
    size = sizes(problem.plant, suspect)
    first = start(problem, suspect)
    if whole(effect):
        one, two = first.free[:2]
        return [
            [with_values(first, {one: first.parameters[one] * a, two: first.parameters[two] * b})]
            for a in (WHOLE_FIRST[::2] if effect.sits_at == "joint" and crowded(problem) else WHOLE_FIRST)
            for b in WHOLE_SECOND
        ]
    if effect.name.endswith("_joint_stop"):
        upper = effect.name.startswith("upper")
        seen = [problem.cases[c].value("position")[:, suspect.indices[0]] for c in problem.of("train")]
        angle = max(float(np.nanmax(s)) for s in seen) if upper else min(float(np.nanmin(s)) for s in seen)
        return [[with_values(first, {"angle": angle})]]
    if effect.name == "torque_ripple":
        return [
            [
                with_values(first, {"amplitude": size["amplitude"], "periods": p, "phase": phase})
                for phase in (0.0, np.pi / 2)
            ]
            for p in _periods(problem, suspect, residual)
        ]
    if not np.isfinite([zero[n] for n in first.free]).all():
        return [
            [with_values(first, {n: first.parameters[n] * k for n in first.free if not np.isfinite(zero[n])})]
            for k in SOFTER
        ]
    if effect.name == "ground_friction" and zero["coefficient"] > 0:
        return [[with_values(first, {"coefficient": zero["coefficient"] * k})] for k in SLIPPERIER]
    named = [n for n in first.free if n not in SHAPES]
    still = {n: zero[n] for n in named}
    out = []
    for factor in TO_BOTH_SIDES if signed(effect) else (1.0,):
        group = []
        for n in named:
            p, step = effect.parameter(n), factor * size[n]
            inside = p.low <= zero[n] + step <= p.high
            group.append(with_values(first, still | {n: zero[n] + (step if inside else -step)}))
        out.append(group)
    return out


def signed(effect: Effect) -> bool:
    """Whether an effect is absent at zero and may have either sign."""
    return all(p.absent == 0.0 and p.low < 0.0 for p in fitted(effect))


def single(suspect: Suspect) -> bool:
    """Whether it sits at one joint."""
    return KNOWN[suspect.effect].sits_at == "joint" and len(suspect.indices) == 1


def crowded(problem: Problem) -> bool:
    """Whether there are so many joints that an effect is tried on all of them at once."""
    return int(problem.judged.sum()) > MANY_JOINTS


def combined(
    problem: Problem, shared: Sequence[Suspect], residual: Sequence[Array]
) -> list[tuple[int, dict[Suspect, Change]]]:
    """The same probe of one effect on all joints at once, with the number of the start that it belongs to."""
    by_effect: dict[str, list[Suspect]] = {}
    for s in shared:
        by_effect.setdefault(s.effect, []).append(s)
    out = []
    for members in by_effect.values():
        starts = {s: probes(problem, s, residual) for s in members}
        for number in range(max(len(groups) for groups in starts.values())):
            trying = {s: groups[number] for s, groups in starts.items() if number < len(groups)}
            for k in range(max(len(group) for group in trying.values())):
                out.append((number, {s: group[k] for s, group in trying.items() if k < len(group)}))
    return out


def with_values(change: Change, values: dict[str, float]) -> Change:
    """A change with some of its parameters at other values."""
    return replace(change, values=tuple((change.parameters | values).items()))


def _periods(problem: Problem, suspect: Suspect, residual: Sequence[Array] | None) -> list[float]:
    """The ripple frequencies that the residual of the target shows as a function of the joint angle.

    A ripple moves the joint, and the effort, by nearly the same sine of the angle: sine and cosine are fitted to the
    residual without simulating, and the best few peaks are tried.
    """
    joint = suspect.indices[0]
    train = problem.of("train")
    grid = np.arange(1.0, 61.0, 0.25)
    score = np.zeros(len(grid))
    for c, r in zip(train, residual or [], strict=False):
        angle = problem.cases[c].value("position")[:, joint]
        mask = joint_mask(problem, [c], joint)
        if not mask.any():
            continue
        for part in np.split(r[mask], max(int(mask.sum()) // len(angle), 1)):
            smooth = part - part.mean()
            for k, p in enumerate(grid):
                basis = np.column_stack([np.sin(p * angle), np.cos(p * angle), np.ones(len(angle)), angle])
                rest = smooth - basis @ np.linalg.lstsq(basis, smooth, rcond=None)[0]
                plain = basis[:, 2:]
                left = smooth - plain @ np.linalg.lstsq(plain, smooth, rcond=None)[0]
                score[k] += float(left @ left - rest @ rest)
    if not score.any():
        return [2.0, 5.0, 12.0, 20.0]
    peaks = [k for k in range(1, len(grid) - 1) if score[k] >= score[k - 1] and score[k] >= score[k + 1]]
    best = sorted(peaks, key=lambda k: -score[k])[:4]
    return [float(grid[k]) for k in best] or [5.0]


def joint_mask(problem: Problem, train: Sequence[int], joint: int) -> Array:
    """Which residuals are those of one joint: they are ordered by case, signal, joint, time."""
    column = int(np.sum(problem.judged[:joint]))
    count = int(problem.judged.sum())
    parts = []
    for c in train:
        t = len(problem.cases[c].measured.time)
        for signal in problem.signals(c):
            wide = {"base_position": 3, "base_quaternion": 4}.get(signal)
            mask = np.zeros((wide or count, t), dtype=bool)
            if wide is None and problem.judged[joint]:
                mask[column] = True
            parts.append(mask.ravel())
    return np.concatenate(parts)
