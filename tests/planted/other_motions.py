"""What a proposed motion is compared with, on the same seconds: what else could be recorded of an ambiguous case."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from ambiguous import GAIN, LOAD, Ambiguous
from motions import Command
from realitygap.diagnose.data.problem import build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.advice import SEPARATES
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.propose.excitation import Excitation, expected_floors, pose_of, with_motions
from realitygap.diagnose.propose.explanations import Open, Question
from realitygap.diagnose.propose.limits import limits_of
from realitygap.diagnose.propose.pool import pool_of
from realitygap.diagnose.propose.predict import predict
from realitygap.diagnose.propose.proposal import Proposal
from realitygap.diagnose.propose.safe import safe_cases
from realitygap.scenario.file import load_scenario
from realitygap.scenario.propose import ProposeSpec

ARMS = ("proposed", "repeated", "multisine", "d_optimal", "table")
Runs = list[dict[str, Any]]


def perform(case: Ambiguous, name: str, motions: Sequence[Excitation]) -> Runs:
    """The foreign plant performs motions under their conditions."""
    out = []
    for k, motion in enumerate(motions):
        told = motion.value
        sent = Command(motion.time, motion.path, np.isfinite(told).all(axis=1).astype(float))
        gain = GAIN if any("servos" in key for key in motion.condition.overrides) else 1.0
        load = LOAD if "robot.urdf" in motion.condition.overrides else 1.0
        out.append(case.perform(f"{name}_{k}", sent, gain, load))
    return out


def again(case: Ambiguous, name: str, seconds: float, gain: float = 1.0, load: float = 1.0) -> Runs:
    """The recorded motion, as often as there is time."""
    problem = build_problem(load_scenario(case.folder / "scenario.yaml"), "mujoco")
    commands = problem.cases[problem.of("train")[0]].experiment.commands
    time_ = commands.time - commands.time[0]
    sent = Command(time_, commands.value, np.ones(len(time_)))
    return [case.perform(f"{name}_{k}", sent, gain, load) for k in range(max(int(seconds / time_[-1]), 1))]


def others(case: Ambiguous, arm: str, open_: Open, floors: Floors, question: Question, seconds: float) -> Runs:
    """The recordings of an arm that is not proposed."""
    if arm == "repeated":
        return again(case, arm, seconds)
    problem = build_problem(load_scenario(case.folder / "scenario.yaml"), "mujoco")
    spec = problem.file.scenario.propose or ProposeSpec()
    recorded = np.concatenate([c.value("position") for c in problem.cases])
    limits = limits_of(problem.plant.model, spec, recorded, problem.plant.reached)
    result = Proposal(problem, open_, limits, pose_of(problem, spec.pose))
    pool = pool_of(result, spec)
    plain = [m for m in pool if not m.condition.overrides]
    if arm == "multisine":
        return perform(case, arm, [_kind(plain, "multisine", seconds)])
    if arm == "d_optimal":
        return perform(case, arm, [_d_optimal(result, pool, floors, seconds)])
    pair = frozenset(t.effect for t in question.targets)
    sentence = SEPARATES.get(pair, "another load, another gain and a phase with the servo off")
    wanted = {  # what a sentence asks for and a recording can be; a level or a voltmeter is none
        " load": lambda s: again(case, "table_load", s, load=LOAD),
        " gain": lambda s: again(case, "table_gain", s, gain=GAIN),
        "servo off": lambda s: perform(case, "table_off", [_kind(plain, "release", s)]),
        "triangle": lambda s: perform(case, "table_slow", [_kind(plain, "triangle", s)]),
        "far to both sides": lambda s: perform(case, "table_far", [_kind(plain, "triangle", s)]),
        "angles": lambda s: perform(case, "table_hold", [_kind(plain, "hold", s)]),
        "saturation": lambda s: perform(case, "table_steps", [_kind(plain, "step", s)]),
        "speed limit": lambda s: perform(case, "table_fast", [_kind(plain, "chirp", s)]),
    }
    chosen: list[Callable[[float], Runs]] = [do for word, do in wanted.items() if word in sentence]
    return [run for do in chosen or [lambda s: again(case, arm, s)] for run in do(seconds / max(len(chosen), 1))]


def _filled(motions: Sequence[Excitation], seconds: float) -> Excitation:
    """Segments one behind the other, of every joint in turn, as many as there is time for."""
    taken: list[Any] = []
    joints = [m.segments[0].joints for m in motions]
    for k in sorted(range(len(motions)), key=lambda k: joints[:k].count(joints[k])):
        m = motions[k]
        if sum(len(s.value) for s in taken) * m.period + m.seconds <= seconds:
            taken.append(m.segments[0])
    return replace(motions[0], segments=tuple(taken or [motions[0].segments[0]]))


def _kind(motions: Sequence[Excitation], kind: str, seconds: float) -> Excitation:
    return _filled([m for m in motions if m.segments[0].kind == kind] or motions[:1], seconds)


def _d_optimal(result: Proposal, pool: Sequence[Excitation], floors: Floors, seconds: float) -> Excitation:
    """The segments that sharpen the values of the first explanation with any most, by their precision's determinant."""
    problem, own = result.problem, len(result.problem.cases)
    model = next(e for e in result.open.explanations if e.fit.names)
    wide = with_motions(problem, pool)
    with Simulations(wide, 1) as simulations:
        rough = expected_floors(wide, floors, own)
        good = safe_cases(simulations, [model], range(own, len(wide.cases)), rough, result.limits)
        predictions = predict(simulations, [model], good, rough)
    assert predictions is not None
    belief, best = predictions.beliefs[0], (-np.inf, [0])
    for condition in {id(m.condition): m.condition for m in pool}.values():
        here = [k for k, c in enumerate(good) if pool[c - own].condition is condition]
        taken: list[int] = []
        gram = np.zeros_like(predictions.grams[0])
        while True:
            room = seconds - sum(pool[good[k] - own].seconds for k in taken)
            free = [k for k in here if k not in taken and pool[good[k] - own].seconds <= room]
            if not free:
                break
            taken.append(max(free, key=lambda k: _size(belief.learned(gram + predictions.grams[k]))))
            gram = gram + predictions.grams[taken[-1]]
        best = max(best, (_size(belief.learned(gram)), taken), key=lambda b: b[0])
    parts = [pool[good[k] - own] for k in best[1]]
    return replace(parts[0], segments=tuple(p.segments[0] for p in parts))


def _size(precision: Any) -> float:
    return float(np.linalg.slogdet(precision)[1])
