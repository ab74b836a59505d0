"""The closed loop: recordings that leave several explanations, one more motion, and the diagnosis again.

    python tests/bench_propose.py [--work DIR] [--begin 0] [--end 16] [--seconds 12] [--arm proposed --arm repeated]

Compared on the same seconds: the proposed motion, the old motion repeated, multisines, the motion that sharpens the
values of one model most (D-optimal), and the sentence of the diagnosis' table carried out literally. Recordings come
from the foreign plant of `tests/planted`; diagnoses search in MuJoCo. What is done is kept in DIR and not done again.
"""

import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parent / "planted"))

from ambiguous import GAIN, LOAD, Ambiguous, generate
from motions import Command
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.candidates.told import velocity_filters
from realitygap.diagnose.data.problem import build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.responses import residual
from realitygap.diagnose.judge.advice import SEPARATES
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.propose.excitation import Excitation, expected_floors, pose_of, with_motions
from realitygap.diagnose.propose.explanations import Open, Question
from realitygap.diagnose.propose.limits import limits_of
from realitygap.diagnose.propose.pool import pool_of
from realitygap.diagnose.propose.predict import predict
from realitygap.diagnose.propose.proposal import Proposal
from realitygap.diagnose.propose.propose import propose
from realitygap.diagnose.propose.safe import safe_cases
from realitygap.diagnose.propose.told import opened
from realitygap.diagnose.propose.words import MOST
from realitygap.diagnose.search.search import search
from realitygap.diagnose.search.yardstick import Yardstick
from realitygap.scenario.file import load_scenario
from realitygap.scenario.propose import ProposeSpec

CASES = [  # robot, effect, motion, seed, whether the effort is recorded
    ("pendulum", "coulomb_friction", "sine", 1, True),
    ("pendulum", "joint_offset", "triangle", 1, False),
    ("geared", "load_dependent_friction", "sine", 1, False),
    ("pendulum", "constant_effort", "sine", 2, False),
    ("pendulum", "stribeck_friction", "sine", 2, False),
    ("geared", "viscous_friction", "sine", 2, False),
    ("pendulum", "link_mass", "sine", 3, False),
    ("geared", "controller_gain", "sine", 3, False),
    ("pendulum", "backlash", "triangle", 3, False),
    ("geared", "coulomb_friction", "triangle", 4, False),
    ("pendulum", "controller_gain", "triangle", 4, False),
    ("geared", "rotor_inertia", "chirp", 4, False),
    ("pendulum", "load_dependent_friction", "sine", 5, True),
    ("geared", "joint_offset", "sine", 5, False),
    ("pendulum", "viscous_friction", "sine", 5, False),
    ("geared", "constant_effort", "triangle", 6, True),
    ("pendulum", "controller_gain", "sine", 7, False),
    ("pendulum", "center_of_mass", "sine", 7, False),
    ("geared", "link_inertia", "chirp", 7, False),
    ("pendulum", "torque_constant", "triangle", 8, False),
    ("pendulum", "command_delay", "chirp", 8, False),
    ("geared", "link_mass", "sine", 8, False),
    ("slide", "coulomb_friction", "sine", 9, False),
    ("slide", "backlash", "triangle", 9, True),
    ("slide", "viscous_friction", "sine", 9, False),
    ("pendulum", "joint_compliance", "sine", 10, False),
    ("geared", "backlash", "sine", 10, False),
    ("pendulum", "supply_voltage", "sine", 10, False),
    ("geared", "direction_friction", "triangle", 11, False),
    ("pendulum", "dead_band", "triangle", 11, False),
    ("geared", "torque_ripple", "triangle", 11, False),
    ("pendulum", "payload", "sine", 12, False),
    ("planar", "coulomb_friction", "sine", 13, False),
    ("planar", "controller_gain", "triangle", 13, False),
    ("skew", "joint_offset", "sine", 14, False),
    ("planar", "load_dependent_friction", "sine", 14, False),
    ("skew", "link_mass", "sine", 15, False),
    ("planar", "torque_constant", "sine", 15, False),
    ("skew", "viscous_friction", "triangle", 16, False),
    ("planar", "backlash", "triangle", 16, False),
]
ARMS = ("proposed", "repeated", "multisine", "d_optimal", "table")
Runs = list[dict[str, Any]]


def quiet(_: str) -> None:
    """Says nothing."""


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


def judged(case: Ambiguous, more: Runs, name: str, question: Question, open_: Open, truth: str) -> dict[str, Any]:
    """The diagnosis with further recordings: what it names, and the realised odds of a question for its first side."""
    problem = build_problem(load_scenario(case.scenario(more, name)), "mujoco")
    everyone = suspects(problem)
    with Simulations(problem, 1) as simulations:
        found = search(simulations, everyone, velocity_filters(problem, everyone), quiet)
        named = [c.suspect.effect for c in found.best.fit.changes]
        rivals = sorted({r.suspect.effect for listed in found.rivals.values() for r in listed if r.open})
        named_before = open_.explanations[0].fit
        fits = [open_.explanations[k].fit for k in (question.one, question.other)]
        realised = odds(simulations, named_before, fits)
    return {
        "named": named,
        "rivals": rivals,
        "settled": named == [truth] and not rivals,
        "right": truth in named,
        "realised": realised,
    }


def odds(simulations: Simulations, base: Fit, fits: Sequence[Fit]) -> float | None:
    """The logarithm of the odds for the first of two explanations, each refitted to all recordings, where laws may be
    off as at the model that was there before.
    """
    problem = simulations.problem
    yardstick = Yardstick(simulations, base.changes)
    first = residual(simulations, base.changes, yardstick.train)
    if first is None:
        return None
    yardstick.take_facts(first)
    near = yardstick.fit(base.changes) if base.changes else yardstick.score(Fit((), first))
    if near is None:
        return None
    yardstick.stand_at(near.fit, suspects(problem))
    one, other = (yardstick.fit(f.changes) if f.changes else yardstick.score(Fit((), first)) for f in fits)
    return None if one is None or other is None else one.evidence - other.evidence


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
        return perform(case, arm, [_filled([m for m in plain if m.segments[0].kind == "multisine"], seconds)])
    if arm == "d_optimal":
        return perform(case, arm, [_d_optimal(result, pool, floors, seconds)])
    pair = frozenset(t.effect for t in question.targets)
    sentence = SEPARATES.get(pair, "another load, another gain and a phase with the servo off")
    wanted = {
        "load": lambda s: again(case, "table_load", s, load=LOAD),
        "gain": lambda s: again(case, "table_gain", s, gain=GAIN),
        "servo off": lambda s: perform(case, "table_off", [_kind(plain, "release", s)]),
        "triangle": lambda s: perform(case, "table_slow", [_kind(plain, "triangle", s)]),
        "angles": lambda s: perform(case, "table_hold", [_kind(plain, "hold", s)]),
    }
    chosen: list[Callable[[float], Runs]] = [do for word, do in wanted.items() if word in sentence]
    return [run for do in chosen or [lambda s: again(case, arm, s)] for run in do(seconds / max(len(chosen), 1))]


def _filled(motions: Sequence[Excitation], seconds: float) -> Excitation:
    """Segments one behind the other, as many as there is time for."""
    taken: list[Any] = []
    for m in motions:
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


def run(number: int, work: Path, seconds: float, arms: Sequence[str]) -> dict[str, Any]:
    """One case through all arms."""
    robot, effect, motion, seed, effort = CASES[number]
    began = time.process_time()
    case = generate(robot, effect, motion, seed, work, effort=effort)
    out: dict[str, Any] = {"case": case.folder.name, "truth": effect, "arms": {}}
    problem = build_problem(load_scenario(case.folder / "scenario.yaml"), "mujoco")
    with Simulations(problem, 1) as simulations:
        open_, floors = opened(simulations, None, quiet)
    true = [q for q in open_.questions if effect in [t.effect for t in q.targets[:1] + q.targets[-1:]]]
    out["open"] = [[str(q), round(q.now, 2)] for q in open_.questions]
    if not true:
        return out | {"skipped": "the truth is not in question"}
    result = propose(problem, open_, floors, ["mujoco"], seconds, 1, quiet, 1)
    true = [q for q in true if q not in result.hopeless]
    if not result.proposed or not true:
        return out | {"skipped": "no motion within the limits moves the question"}
    best = result.proposed[0]
    out["motion"] = [best.motion.condition.label, *(s.label for s in best.motion.segments)]
    out["propose_seconds"] = round(time.process_time() - began, 1)
    answers = dict(zip(open_.questions, best.answers, strict=True))
    question = min(true, key=lambda q: answers[q].least)
    first = question.targets[0].effect == effect
    a = answers[question]
    out["question"], out["predicted"] = str(question), a.one if first else -a.other
    for arm in arms:
        more = (
            perform(case, arm, [best.motion])
            if arm == "proposed"
            else others(case, arm, open_, floors, question, seconds)
        )
        out["arms"][arm] = judged(case, more, arm, question, open_, effect)
    return out | {"cpu_seconds": round(time.process_time() - began, 1)}


def report(results: Sequence[dict[str, Any]]) -> list[str]:
    """Shares of cases that are settled by each arm, and predicted against realised odds."""
    done = [r for r in results if r["arms"]]
    lines = [f"{len(results)} cases, {len(done)} ambiguous with the truth in question and within reach"]
    for arm in ARMS:
        here = [r["arms"][arm] for r in done if arm in r["arms"]]
        if here:
            settled, right = (sum(h[k] for h in here) for k in ("settled", "right"))
            lines.append(f"{arm}: settled {settled} of {len(here)}, the truth named in {right}")
    told = [(r["predicted"], r["arms"]["proposed"]["realised"]) for r in done if "proposed" in r["arms"]]
    told = [(p, q) for p, q in told if q is not None]
    if told:
        same = sum(p * q > 0 for p, q in told)
        most = MOST * np.log(10)  # as they are told: beyond, a model's own faults decide
        near = sum(abs(np.clip(p, -most, most) - np.clip(q, -most, most)) < np.log(10) for p, q in told)
        lines.append(
            f"predicted and realised odds, up to 10^{MOST}: the same sign in {same} of {len(told)}, "
            f"within a factor of ten in {near}"
        )
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", type=Path, default=Path("results/runs/propose"))
    parser.add_argument("--begin", type=int, default=0, help="number of the first case")
    parser.add_argument("--end", type=int, default=len(CASES), help="number behind the last one")
    parser.add_argument("--seconds", type=float, default=12.0)
    parser.add_argument("--arm", choices=ARMS, action="append")
    args = parser.parse_args()
    args.work.mkdir(parents=True, exist_ok=True)
    results = []
    for number in range(args.begin, min(args.end, len(CASES))):
        kept = args.work / f"{number:03d}.json"
        if not kept.is_file():
            kept.write_text(json.dumps(run(number, args.work, args.seconds, args.arm or ARMS), default=float))
        results.append(json.loads(kept.read_text()))
        print(json.dumps(results[-1]), flush=True)
    print("\n".join(report(results)))


if __name__ == "__main__":
    main()
