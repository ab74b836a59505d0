"""Which motions are judged over windows, and how long those are: what repetitions themselves reproduce says it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from realitygap.compare.comparison import RepeatedMotion, on_first_clock
from realitygap.diagnose.data.alike import alike_for, reproduced
from realitygap.diagnose.data.case import TINY, Case
from realitygap.diagnose.data.diverging import forgotten, let_go, told_efforts
from realitygap.diagnose.data.windows import FEWEST, cut
from realitygap.robot.drive import Array
from realitygap.simulate.experiment import Experiment
from realitygap.trace.trace import Trace

BEGUN = "simulated from the state that was measured where each begins"
NAMED = 3
"""Motions that are named in a sentence; of more of them, how many there are."""


def windowed(cases: Sequence[Case], motions: Sequence[RepeatedMotion], engine: str) -> tuple[list[Case], list[str]]:
    """The cases, with windows where a motion does not repeat sample by sample, and sentences on that.

    Repetitions that do not reproduce their motion are a case each: their mean is no motion. Where a motion was recorded
    once and something moves in it that nothing holds, the model says how soon it forgets its start; where it says so of
    most of them, another model may say it of the others, and all are cut. Where motors were told efforts, it is enough
    that it says so of one: efforts add up twice, and what a model lacks leads every motion away from where they were
    told. A pendulum that swings freely for ten seconds told neither its friction nor its rotor; in pieces both.

    Args:
        cases: split into those that are fitted and those that are judged on.
        motions: of each of them; the one motion where it was split in two.
        engine: where motions are simulated.
    """
    every = motions if len(motions) == len(cases) else [*motions] * len(cases)
    out: list[list[Case]] = []
    notes: list[str] = []
    alone: dict[int, float | None] = {}
    for k, (case, motion) in enumerate(zip(cases, every, strict=True)):
        out.append([case])
        if case.experiment.followed is not None:
            continue
        whole = len(motion.experiments) == 1
        if not whole:
            out[-1], said = _repeated(case, motion)
            notes += said
            whole = told_efforts(case.experiment) and out[-1] == [case]  # who told them made it repeat, not the model
        if whole and let_go(case.experiment) and not _stands(case.experiment):
            alone[k] = forgotten(case, engine)
    untils = [until for until in alone.values() if until is not None]
    if untils:
        driven = any(told_efforts(cases[k].experiment) for k in alone)
        length, most = float(np.median(untils)), driven or 2 * len(untils) > len(alone)
        chosen = [k for k, until in alone.items() if most or until is not None]
        for k in chosen:
            out[k] = [cut(cases[k], length)]
        notes.append(_once([cases[k].name for k in chosen], len(untils), length, [c for k in chosen for c in out[k]]))
    return [c for parts in out for c in parts], notes


def _stands(experiment: Experiment) -> bool:
    """Whether it is a robot on its feet: what its joints and contacts carry at a moment no reading tells."""
    return experiment.scenario.robot.base == "floating"


def _repeated(case: Case, motion: RepeatedMotion) -> tuple[list[Case], list[str]]:
    traces = [
        t.between(float(case.measured.time[0]), float(case.measured.time[-1]))
        for t in on_first_clock(motion.experiments, motion.shifts)
    ]
    signals = [s for s in ("position", "base_position", "base_quaternion") if s in case.white]
    if not signals:
        return [case], []
    noise = np.concatenate([np.maximum(case.white[s], TINY[s]) for s in signals])
    values = np.array([np.hstack([_continuous(t, traces[0], s) for s in signals]) for t in traces])
    if reproduced(case.measured.time, values, noise):
        return [case], []
    no = f"the repetitions of {case.name} do not reproduce one another"
    if _stands(case.experiment):
        return [case], [f"{no}; a robot on its feet is judged over the whole motion all the same, by their mean"]
    length = alike_for(case.measured.time, values, noise)
    parts = [] if length is None else [_own(case, e, s) for e, s in zip(motion.experiments, motion.shifts, strict=True)]
    found = [cut(c, length) for c in parts if length is not None]
    if length is None or not all(c.windows for c in found):
        alike = (
            "are never alike" if length is None else f"are alike for {length:.2g} s at most, less than {FEWEST} samples"
        )
        return [case], [f"{no} and {alike}: it is judged over the whole motion, by their mean"]
    return found, [
        f"{no}: where two of them are alike, they are so for {length:.2g} s; each is judged over windows of that "
        f"length, {BEGUN}"
    ]


def _own(case: Case, experiment: Experiment, shift: float) -> Case:
    """One repetition as a case of its own, with the sensors' noise alone."""
    assert experiment.recording is not None
    first, last = case.measured.time[[0, -1]] + shift
    measured = experiment.recording.trace.between(float(first) - 1e-9, float(last) + 1e-9)
    noise = {s: np.maximum(v, TINY[s]) for s, v in case.white.items()}
    return replace(
        case,
        name=experiment.name,
        experiment=experiment,
        measured=measured,
        noise=noise,
        repetitions=1,
        white=noise,
        spread={},
        recorded=case.repetitions,
    )


def _continuous(trace: Trace, first: Trace, signal: str) -> Array:
    """A signal of a repetition; of orientations the quaternion that is near the first one's."""
    value = np.asarray(getattr(trace, signal))
    if signal != "base_quaternion":
        return value
    sign = np.sign(np.sum(value * getattr(first, signal), axis=1, keepdims=True))
    return np.where(sign < 0, -value, value)


def _once(names: Sequence[str], count: int, length: float, cases: Sequence[Case]) -> str:
    if len(names) <= NAMED and count == len(names):
        shown = ", ".join(names)
    else:
        shown = f"{count} of {len(names)} motions that nothing holds"
    forgets = "forget within {:.2g} s how they began" if count > 1 else "forgets within {:.2g} s how it began"
    told = f"in the model, {shown} {forgets.format(length)}, as far as the readings tell that"
    if all(c.windows for c in cases):
        return f"{told}: {'all are ' if count < len(names) else ''}judged over windows of that length, {BEGUN}"
    return f"{told}, which is less than {FEWEST} samples: judged over the whole motion"
