"""Screening: a first set of motions for a robot with no recordings, and from which size on each effect would show.

The sizes are those of a rehearsal, as if nothing disturbed the robot but the quantum of its encoders.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from realitygap.diagnose.candidates.suspects import acting
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.likelihood.floors import measure
from realitygap.diagnose.propose.condition import conditions
from realitygap.diagnose.propose.excitation import Excitation, case_of, experiment_of
from realitygap.diagnose.propose.explanations import Open
from realitygap.diagnose.propose.limits import limits_of
from realitygap.diagnose.propose.pool import labels
from realitygap.diagnose.propose.proposal import Proposal, Proposed
from realitygap.diagnose.propose.safe import left_limits
from realitygap.diagnose.propose.segments import Builder, Segment
from realitygap.diagnose.rehearse.rehearse import Rehearsal
from realitygap.diagnose.rehearse.visible import visible
from realitygap.diagnose.search.round import Say
from realitygap.diagnose.search.search import needed
from realitygap.robot.effects.place import place
from realitygap.robot.plant import build_plant
from realitygap.scenario.file import ScenarioFile
from realitygap.scenario.propose import ProposeSpec, SegmentKind

SETS: dict[str, tuple[SegmentKind, ...]] = {
    "slow": ("triangle", "hold"),
    "fast": ("step", "chirp", "multisine"),
    "fine": ("reversal", "release"),
}
"""Motions of a first set, by what they are made of: statics, dynamics, and what small or free motions show."""
RATE = 100.0
"""How often an ordinary servo bus is read [Hz]."""
QUANTUM = {False: 2 * np.pi / 4096, True: 2e-5}
"""Of an ordinary encoder: twelve bits a turn [rad], or a linear scale [m]."""


def screen(
    file: ScenarioFile, engines: Sequence[str], engine: str, seconds: float, motions: int, say: Say, workers: int | None
) -> Proposal:
    """A first set of motions, and what they would show.

    Args:
        file: a scenario without recordings.
        engines: in which motions have to stay within the limits.
        engine: that searches.
        seconds: that each may take.
        motions: how many at most.
        say: told what is being done.
        workers: processes; None for one per core.

    Raises:
        InputError: where nothing says how far joints may go.
    """
    spec = file.scenario.propose or ProposeSpec()
    plant = place(build_plant(file), file.scenario.effects)
    names = plant.model.joint_names
    empty = Problem(file, plant, (), engine, np.ones(len(names), dtype=bool), "")
    limits = limits_of(plant.model, spec, None, None)
    home = np.array([spec.pose.get(n, 0.0) for n in names])
    result = Proposal(empty, Open((), ()), limits, np.clip(home, limits.lower, limits.upper))
    (condition, *_) = conditions(empty, spec)
    chosen = []
    for name, kinds in list(SETS.items())[:motions]:
        allowed = [k for k in kinds if k not in spec.forbid and (k != "release" or spec.release)]
        here = [
            Builder(along, result.home, limits, 1.0 / RATE, n).every(allowed)
            for along, n in zip(np.eye(len(names)), labels(empty), strict=True)
        ]
        kept = Excitation(name, tuple(_turns(here, seconds, 1.0 / RATE)), condition, 1.0 / RATE)
        held: tuple[str, ...] = ()
        while kept.segments:
            out, held = left_limits(experiment_of(kept), kept, [plant], engines, limits)
            if not out:
                break
            kept = replace(kept, segments=tuple(s for k, s in enumerate(kept.segments) if k not in out))
        if kept.segments:
            chosen.append((kept, held))
    if not chosen:
        feet = ", on its feet" if plant.model.floating else ""
        result.notes.append(f"no motion stays within these limits{feet}")
        return result
    noise = {"position": np.array([QUANTUM[j.prismatic] / np.sqrt(12) for j in plant.model.joints])}
    cases = [case_of(m, replace(experiment_of(m), use="train"), noise, RATE) for m, _ in chosen]
    result.problem = problem = replace(empty, cases=tuple(cases))
    everyone = acting(problem)
    with Simulations(problem, workers) as simulations:
        floors = measure(simulations, [])
        found = visible(simulations, floors, everyone, needed(len(everyone)), say)
    result.shown = Rehearsal(problem, engine, (float("nan"),) * 2, floors, found)
    result.proposed = [Proposed(m, k, (), held) for k, (m, held) in enumerate(chosen)]
    result.notes.append(
        "nothing is recorded: a first set of motions, with sizes as if nothing disturbed the robot but its encoders' "
        "quantum; record one of them three times"
    )
    return result


def _turns(of_joints: Sequence[Sequence[Segment]], seconds: float, period: float) -> list[Segment]:
    """One segment of every joint after the other, as many as there is time for."""
    taken: list[Segment] = []
    longest = max((len(s) for s in of_joints), default=0)
    for number in range(longest):
        for segments in of_joints:
            if number < len(segments) and _length([*taken, segments[number]], period) <= seconds:
                taken.append(segments[number])
    return taken


def _length(segments: Sequence[Segment], period: float) -> float:
    return period * sum(len(s.value) for s in segments)
