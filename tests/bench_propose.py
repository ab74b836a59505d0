"""The closed loop: recordings that leave several explanations, one more motion, and the diagnosis again.

    python tests/bench_propose.py --safe 1000
    python tests/bench_propose.py [--work DIR] [--begin 0] [--end 16] [--seconds 20] [--arm proposed --arm repeated]

Compared on the same seconds: the proposed motion, the old motion repeated, multisines, the motion that sharpens the
values of one model most (D-optimal), and the sentence of the diagnosis' table carried out literally. Recordings come
from the foreign plant of `tests/planted`; diagnoses search in MuJoCo. What is done is kept in DIR and not done again.
`--safe` draws random scenarios instead, and tries whether any motion leaves a limit under any rival in any engine.
"""

import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import realitygap_engines as engines

sys.path.insert(0, str(Path(__file__).parent / "planted"))

from ambiguous import GAIN, LOAD, Ambiguous, generate
from motions import Command
from open_cases import CASES
from random_proposals import left
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.candidates.told import velocity_filters
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem, build_problem
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
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.search import search
from realitygap.diagnose.search.yardstick import Yardstick
from realitygap.scenario.file import load_scenario
from realitygap.scenario.propose import ProposeSpec

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


def judged(case: Ambiguous, more: Runs, name: str, twins: set[str]) -> tuple[dict[str, Any], Problem]:
    """The diagnosis with further recordings: what it names, and whether that is the truth alone, or what no motion can
    tell from it.
    """
    problem = build_problem(load_scenario(case.scenario(more, name)), "mujoco")
    everyone = suspects(problem)
    with Simulations(problem, 1) as simulations:
        found = search(simulations, everyone, velocity_filters(problem, everyone), quiet)
    named = [_label(c.suspect) for c in found.best.fit.changes]
    rivals = sorted({_label(r.suspect) for listed in found.rivals.values() for r in listed if r.open})
    right = {truth(case), *twins}
    return {
        "named": named,
        "rivals": rivals,
        "settled": len(named) == 1 and {*named, *rivals} <= right,
        "right": bool({*named} & right),
    }, problem


def sides(question: Question) -> list[str]:
    """What both sides name; empty for what has no name."""
    first, *last = [_label(t) for t in question.targets]
    return [first, *(last or [""])]


def _label(suspect: Suspect) -> str:
    return f"{suspect.effect} at {suspect.target}" if isinstance(suspect.target, str) else suspect.effect


def truth(case: Ambiguous) -> str:
    """What was planted, as a suspect of it is told."""
    told = json.loads((case.folder / "truth.json").read_text(encoding="utf-8"))
    at = told["target"]
    return f"{told['effect']} at {at}" if isinstance(at, str) else str(told["effect"])


def odds(simulations: Simulations, base: Fit, fits: Sequence[Fit]) -> float | None:
    """The logarithm of the odds for the first of two explanations, each refitted to all recordings, where laws may be
    off, and facts count, as at the one with fewer findings, where a diagnosis asks whether anything more is named; of
    two with as many, as at the better one.
    """
    problem = simulations.problem
    yardstick = Yardstick(simulations, base.changes)
    first = residual(simulations, base.changes, yardstick.train)
    if first is None:
        return None
    yardstick.take_facts(first)
    near = [_refitted(yardstick, f.changes) for f in fits]
    good = [n for n in near if n is not None]
    if len(good) < len(near):
        return None
    yardstick.stand_at(min(good, key=lambda n: (len(n.fit.changes), -n.evidence)).fit, suspects(problem))
    one, other = (_refitted(yardstick, n.fit.changes) for n in good)
    return None if one is None or other is None else one.evidence - other.evidence


def _refitted(yardstick: Yardstick, changes: Sequence[Change]) -> Scored | None:
    if changes:
        return yardstick.fit(changes)
    still = residual(yardstick.simulations, (), yardstick.train)
    return None if still is None else yardstick.score(Fit((), still))


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
    robot, effect, motion, seed, swing, effort = CASES[number]
    began = time.process_time()
    case = generate(robot, effect, motion, seed, work, effort=effort, swing=swing)
    right = truth(case)
    out: dict[str, Any] = {"case": case.folder.name, "truth": right, "arms": {}}
    problem = build_problem(load_scenario(case.folder / "scenario.yaml"), "mujoco")
    with Simulations(problem, 1) as simulations:
        open_, floors = opened(simulations, None, quiet)
    true = [q for q in open_.questions if right in sides(q)]
    out["open"] = [[str(q), round(q.now, 2)] for q in open_.questions]
    out["named"] = [str(c.suspect) for c in open_.explanations[0].fit.changes]
    out["diagnose_seconds"] = round(time.process_time() - began, 1)
    if not true:
        return out | {"skipped": "the truth is not in question"}
    began = time.process_time()
    result = propose(problem, open_, floors, ["mujoco"], seconds, 1, quiet, 1)
    out["propose_seconds"] = round(time.process_time() - began, 1)
    if not result.proposed:
        return out | {"skipped": "no motion within the limits moves the question"}
    best = result.proposed[0]
    answers = dict(zip(open_.questions, best.answers, strict=True))
    stay = [q for q in true if q in result.hopeless or not answers[q].moves(q)]  # as the page says
    twins = {e for q in stay for e in sides(q)} - {right, ""}
    true = [q for q in true if q not in stay]
    if not true:
        return out | {"skipped": "the motion does not move the question"}
    out["motion"] = [best.motion.condition.label, *(s.label for s in best.motion.segments)]
    out["twins"] = sorted(twins)
    question = min(true, key=lambda q: answers[q].least)
    for arm in arms:
        more = (
            perform(case, arm, [best.motion])
            if arm == "proposed"
            else others(case, arm, open_, floors, question, seconds)
        )
        out["arms"][arm], again = judged(case, more, arm, twins)
        if arm != "proposed":
            continue
        out["odds"] = []
        for q in true:
            with Simulations(again, 1) as simulations:
                fits = [open_.explanations[k].fit for k in (q.one, q.other)]
                realised = odds(simulations, open_.explanations[0].fit, fits)
            first = sides(q)[0] == right
            told = answers[q].one if first else -answers[q].other
            out["odds"].append({"question": str(q), "predicted": told, "realised": realised, "truth_first": first})
    return out


def report(results: Sequence[dict[str, Any]]) -> list[str]:
    """Shares of cases that are settled by each arm, and predicted against realised odds."""
    done = [r for r in results if r["arms"]]
    lines = [f"{len(results)} cases, {len(done)} ambiguous with the truth in question and within reach"]
    for arm in ARMS:
        here = [r["arms"][arm] for r in done if arm in r["arms"]]
        if here:
            settled, right = (sum(h[k] for h in here) for k in ("settled", "right"))
            lines.append(f"{arm}: settled {settled} of {len(here)}, the truth named in {right}")
    told = [(o["predicted"], o["realised"]) for r in done for o in r.get("odds", []) if o["realised"] is not None]
    if told:
        same = sum(p * q > 0 for p, q in told)
        most = MOST * np.log(10)  # as they are told: beyond, a model's own faults decide
        near = sum(abs(np.clip(p, -most, most) - np.clip(q, -most, most)) < np.log(10) for p, q in told)
        lines.append(
            f"predicted and realised odds, up to 10^{MOST}: the same sign in {same} of {len(told)}, "
            f"within a factor of ten in {near}"
        )
    return lines


def safe(first: int, number: int) -> str:
    """Motions for random scenarios, each in MuJoCo and two engines that are drawn."""
    every, motions, bad = sorted({*engines.available()} - {"mujoco"}), 0, 0
    for seed in range(first, first + number):
        drawn = np.random.default_rng(seed).choice(every, min(2, len(every)), replace=False).tolist()
        with TemporaryDirectory() as folder:
            count, outside = left(seed, Path(folder), ["mujoco", *drawn])
        motions, bad = motions + count, bad + bool(outside)
        for one in outside:
            print(one, flush=True)
    return f"{number} random scenarios, {motions} motions: in {bad} scenarios one leaves a limit"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", type=Path, default=Path("results/runs/propose"))
    parser.add_argument("--begin", type=int, default=0, help="number of the first case")
    parser.add_argument("--end", type=int, default=len(CASES), help="number behind the last one")
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--arm", choices=ARMS, action="append")
    parser.add_argument("--safe", type=int, default=0, help="so many random scenarios: does a motion leave a limit?")
    args = parser.parse_args()
    if args.safe:
        print(safe(args.begin, args.safe))
        return
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
