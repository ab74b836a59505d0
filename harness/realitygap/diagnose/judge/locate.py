"""Where and when simulation and measurement disagree: per joint, signal and phase of the motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from realitygap.compare.gap import BASE, unit_of
from realitygap.diagnose.data.case import Case
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.robot.drive import DC, DUTY, POSITION, Array

Mask = NDArray[np.bool_]
SLOW = 0.05
"""A joint slower than this part of its fastest holds."""
NEAR = 0.08
"""How close to a change of direction is a reversal [s]."""
LOADED = 0.6
"""A joint is loaded above this part of its largest effort."""
FULL = 0.999
"""A servo gives all it can from this part of its largest effort on: what is clipped is equal to it but for rounding."""
STANDS_OUT = 1.3
"""A phase is named where its residual is this much larger than that of the whole."""
ABOVE = 1.5
"""A gap is above its floor where its root mean square residual exceeds this."""


@dataclass(frozen=True)
class Place:
    """A joint, or the base, and signal with a gap, and the phases where it is large.

    The gap is a mean absolute value in `unit`, as of a run; the floors are not those of a run. Every sample has its
    own, and a few that are far less sure than the others, as those at which a held command jumps, would rule their
    mean: told are the floors that the gap was weighed against, so that
    gap² = floors²·(noise_floor² + numerical_floor²).

    Attributes:
        noise_floor: what of them is noise of the sensors.
        numerical_floor: what of them lasts: numerics, jumps of held commands, disturbances.
        floors: how many floors the gap is: the root mean square of every sample over its own.
    """

    joint: str
    signal: str
    unit: str
    gap: float
    noise_floor: float
    numerical_floor: float
    when: tuple[str, ...]
    floors: float


def locate(problem: Problem, floors: Floors, simulated: Mapping[int, dict[str, Array]]) -> list[Place]:
    """Every joint and signal, and the base's pose, whose gap stands above its floors, the largest first.

    Args:
        problem: the motions.
        floors: of the model.
        simulated: signals by case.
    """
    names = problem.plant.model.joint_names
    out = []
    for j, joint in enumerate(names):
        if not problem.judged[j]:
            continue
        for signal in ("position", "velocity", "effort"):
            cases = [i for i in simulated if signal in problem.signals(i)]
            if problem.measured(cases, signal, j):
                place = _place(problem, floors, joint, j, signal, {i: simulated[i] for i in cases})
                if place.floors > ABOVE:
                    out.append(place)
    for signal in BASE:
        cases = [i for i in simulated if signal in problem.signals(i)]
        if cases:
            place = _of_base(problem, floors, signal, {i: simulated[i] for i in cases})
            if place.floors > ABOVE:
                out.append(place)
    return sorted(out, key=lambda p: -p.floors)


def _of_base(problem: Problem, floors: Floors, signal: str, simulated: Mapping[int, dict[str, Array]]) -> Place:
    name, unit, scale = BASE[signal]
    deltas = [problem.delta(i, signal, sim) for i, sim in simulated.items()]
    noises = [problem.deviation(signal, floors.noise[i][signal][None, :]) for i in simulated]
    sigma = [problem.deviation(signal, floors.sigma(i, signal)) for i in simulated]
    residual = np.concatenate([d / s for d, s in zip(deltas, sigma, strict=True)])
    noisy = np.concatenate([n / s for n, s in zip(noises, sigma, strict=True)])
    far = np.concatenate([np.linalg.norm(d, axis=1) for d in deltas])
    return _told("base", name, unit, float(np.nanmean(far) * scale), residual, noisy, ("throughout",))


def _place(
    problem: Problem, floors: Floors, joint: str, j: int, signal: str, simulated: Mapping[int, dict[str, Array]]
) -> Place:
    unit, scale = unit_of(signal, problem.plant.model.joints[j].prismatic)
    gaps, scaled, noises = [], [], []
    masks: list[dict[str, Mask]] = []
    for i, sim in simulated.items():
        case, sigma = problem.cases[i], floors.sigma(i, signal)[:, j]
        delta = sim[signal][:, j] - case.value(signal)[:, j]
        gaps.append(np.abs(delta))
        scaled.append(delta / sigma)
        noises.append(floors.noise[i][signal][j] / sigma)
        masks.append(phases(case, j, sim))
    residual = np.concatenate(scaled)
    known, whole = np.isfinite(residual), float(np.sqrt(np.nanmean(residual**2)))
    when = []
    for phase in dict.fromkeys(phase for of in masks for phase in of):
        never = [np.zeros(len(part), dtype=bool) for part in scaled]  # a motion without effort is never loaded
        mask = known & np.concatenate([of.get(phase, none) for of, none in zip(masks, never, strict=True)])
        if mask.sum() >= 5 and np.sqrt(np.mean(residual[mask] ** 2)) > STANDS_OUT * whole:
            when.append(phase)
    gap = float(np.nanmean(np.concatenate(gaps)) * scale)
    return _told(joint, signal, unit, gap, np.concatenate(scaled), np.concatenate(noises), tuple(when))


def _told(
    joint: str, signal: str, unit: str, gap: float, residual: Array, noisy: Array, when: tuple[str, ...]
) -> Place:
    """A place from its gap in `unit`, every sample's difference in its own floors, and what of that floor is noise."""
    squares = residual**2
    count = float(np.sqrt(np.nanmean(squares)))
    floor = gap / count if count > 0 else 0.0
    noise = float(np.nansum(squares * noisy**2) / np.nansum(squares)) if count > 0 else 1.0
    lasting = floor * float(np.sqrt(max(1.0 - noise, 0.0)))
    return Place(joint, signal, unit, gap, floor * float(np.sqrt(noise)), lasting, when or ("throughout",), count)


def phases(case: Case, j: int, simulated: Mapping[str, Array]) -> dict[str, Mask]:
    """Which samples of a motion belong to which phase of joint j. Shape (t,) each.

    Phases: holding, moving, reversal, saturation (the servo gives all it can), loaded, impact (of a moving base).
    """
    time = case.measured.time
    position = simulated.get("position", case.value("position"))[:, j]
    speed = np.gradient(position, time) if len(time) > 2 else np.zeros(len(time))
    fast = np.abs(speed).max(initial=0.0)
    holding = np.abs(speed) < SLOW * fast if fast > 0 else np.ones(len(time), dtype=bool)
    out = {"holding": holding, "moving": ~holding}
    sign = np.sign(np.where(holding, 0.0, speed))
    moving = np.flatnonzero(sign)
    turns = moving[1:][np.diff(sign[moving]) != 0] if len(moving) > 1 else np.zeros(0, dtype=int)
    rate = (len(time) - 1) / max(time[-1] - time[0], 1e-9)
    reach = max(int(NEAR * rate), 1)
    out["reversal"] = _around(turns, reach, len(time))
    effort = simulated.get("effort")
    saturated = _saturated(case, j, position, effort)
    if saturated is not None:
        out["saturation"] = saturated
    if effort is not None and np.abs(effort[:, j]).max(initial=0.0) > 0:
        out["loaded"] = np.abs(effort[:, j]) > LOADED * np.abs(effort[:, j]).max()
    if case.measured.imu_angular is not None:
        jerk = np.abs(np.gradient(np.linalg.norm(case.measured.imu_angular, axis=1), time))
        out["impact"] = _around(np.flatnonzero(jerk > 6 * np.median(jerk) + 1e-9), reach, len(time))
    return out


def _saturated(case: Case, j: int, position: Array, effort: Array | None) -> Mask | None:
    """Where a servo gives all it can, by its duty or by its effort; None where neither is known. Shape (t,)."""
    drive, command = case.experiment.plant.drive[j], case.measured.command
    if drive["kind"] == DC and drive["meaning"] in (POSITION, DUTY):
        if command is None:
            return None
        duty = drive["gain"] * (command[:, j] - position) if drive["meaning"] == POSITION else command[:, j]
        return np.asarray(np.nan_to_num(np.abs(duty)) >= drive["duty_limit"])
    limit = min(drive["effort_limit"], drive["real_limit"])
    return None if effort is None else np.asarray(np.abs(effort[:, j]) >= FULL * limit)


def _around(centers: NDArray[np.int64], reach: int, count: int) -> Mask:
    out = np.zeros(count, dtype=bool)
    for c in centers:
        out[max(c - reach, 0) : c + reach + 1] = True
    return out
