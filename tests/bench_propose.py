"""The closed loop: recordings that leave several explanations, one more motion, and the diagnosis again.

    python tests/bench_propose.py --safe 1000 [--standing]
    python tests/bench_propose.py [--work DIR] [--shift N] [--begin 0] [--end 16] [--seconds 20]
        [--arm proposed --arm repeated] [--diagnosed proposed]

Compared on the same seconds: the proposed motion, the old motion repeated, multisines, the motion that sharpens the
values of one model most (D-optimal), and the sentence of the diagnosis' table carried out literally. Recordings come
from the foreign plant of `tests/planted`; diagnoses search in MuJoCo. Every arm is judged among the explanations that
were open: refitted to all recordings, does the truth leave all others behind by what a diagnosis asks? Arms that are to
be `--diagnosed` are also given to a diagnosis that starts from nothing. `--shift` adds to the seeds of all cases: into
what is drawn then, robots too, nobody has looked. What is done is kept in DIR after every arm and not done again.
`--safe` draws random scenarios instead, and tries whether any motion leaves a limit under any rival in any engine; with
`--standing`, of robots on a foot, whether any loses it.
"""

import argparse
import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import realitygap_engines as engines

sys.path.insert(0, str(Path(__file__).parent / "planted"))

from ambiguous import NotShown, generate
from odds_told import compared, diagnosed, quiet, recorded, sides, truth
from open_cases import CASES, Planted
from other_motions import ARMS, others, perform
from random_proposals import left
from realitygap.diagnose.data.problem import build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.propose.design import Answer
from realitygap.diagnose.propose.explanations import Question
from realitygap.diagnose.propose.propose import propose
from realitygap.diagnose.propose.told import opened
from realitygap.diagnose.propose.words import SURE
from realitygap.diagnose.result.odds import MOST
from realitygap.scenario.file import load_scenario

Result = dict[str, Any]


def run(planted: Planted, kept: Path, seconds: float, arms: Sequence[str], whole: Sequence[str]) -> Result:
    """One case through all arms; what is done already stands in `kept`, and so does what is done now."""
    out: Result = json.loads(kept.read_text()) if kept.is_file() else {"arms": {}}
    asked = [a for a in arms if a not in out["arms"] or (a in whole and "diagnosed" not in out["arms"][a])]
    if not asked or "skipped" in out:
        return out

    def keep(**told: Any) -> Result:
        out.update(told)
        kept.write_text(json.dumps(out, default=float))
        return out

    try:
        case = generate(*planted[:4], kept.parent, effort=planted.effort, swing=planted.swing)
    except NotShown as error:
        return keep(skipped=str(error))
    right = truth(case)
    began = time.process_time()
    problem = build_problem(load_scenario(case.folder / "scenario.yaml"), "mujoco")
    with Simulations(problem, 1) as simulations:
        open_, floors = opened(simulations, None, quiet)
    keep(
        case=case.folder.name,
        truth=right,
        open=[[str(q), round(q.now, 2)] for q in open_.questions],
        named=[str(c.suspect) for c in open_.explanations[0].fit.changes],
        diagnose_seconds=round(time.process_time() - began, 1),
    )
    true = [q for q in open_.questions if right in sides(q)]
    if not true:
        return keep(skipped="the truth is not in question")
    began = time.process_time()
    result = propose(problem, open_, floors, ["mujoco"], seconds, 1, quiet, 1)
    keep(propose_seconds=round(time.process_time() - began, 1))
    if not result.proposed:
        return keep(skipped="no motion within the limits moves the question")
    best = result.proposed[0]
    answers = dict(zip(result.open.questions, best.answers, strict=True))  # not of what the recordings settle
    true = [q for q in true if q in answers]
    stay = [q for q in true if q in result.hopeless or not answers[q].moves(q) or right in mimicked(q, answers[q])]
    right_ones = {right, *(e for q in stay for e in sides(q) if e)}
    true = [q for q in true if q not in stay]
    if not true:
        return keep(skipped="the motion does not move the question")
    told = {str(q): answers[q].one if sides(q)[0] == right else answers[q].other for q in true}
    motion = [best.motion.condition.label, *(s.label for s in best.motion.segments)]
    keep(motion=motion, twins=sorted(right_ones - {right}), predicted=told)
    question = min(true, key=lambda q: answers[q].least)
    for arm in asked:
        if arm == "proposed":
            more = perform(case, arm, [best.motion])
        else:
            more = others(case, arm, open_, floors, question, seconds)
        began, after = time.process_time(), recorded(case, more, arm)
        here = out["arms"].setdefault(arm, {})
        if "questions" not in here:
            here["questions"] = compared(after, open_, true, right)
            here["seconds"] = round(time.process_time() - began, 1)
            keep()
        if arm in whole:
            here["diagnosed"] = diagnosed(after, right_ones)
            keep()
    return out


def mimicked(question: Question, answer: Answer) -> list[str]:
    """The sides of a question that the other one does the same as, as the page says."""
    return [side for side, alike in zip(sides(question), answer.alike, strict=True) if alike]


def report(results: Sequence[Result]) -> list[str]:
    """Shares of cases that are settled by each arm, and predicted against realised odds."""
    done = [r for r in results if r["arms"]]
    promised = [r for r in done if min(r["predicted"].values()) > SURE]
    lines = [
        f"{len(results)} cases, {len(done)} ambiguous with the truth in question and moved by the proposed motion; "
        f"in {len(promised)} it is to settle all (20 : 1)"
    ]
    for arm in ARMS:
        here = [r["arms"][arm] for r in done if arm in r["arms"]]
        if here:
            sure = [r["arms"][arm] for r in promised if arm in r["arms"]]
            counts = [sum(all(q["settled"] for q in h["questions"]) for h in part) for part in (here, sure)]
            lines.append(
                f"{arm}: the truth leaves all that was open behind in {counts[0]} of {len(here)}, "
                f"{counts[1]} of the {len(sure)}"
            )
        whole = [h["diagnosed"] for h in here if "diagnosed" in h]
        if whole:
            alone, named = (sum(h[k] for h in whole) for k in ("settled", "right"))
            lines[-1] += f"; a diagnosis from nothing names it alone in {alone} of {len(whole)}, at all in {named}"
    first = [(r["predicted"], r["arms"]["proposed"]["questions"]) for r in done if "proposed" in r["arms"]]
    pairs = [(told[q["question"]], q["odds"]) for told, asked in first for q in asked if q["odds"] is not None]
    if pairs:
        same = sum(p * q > 0 for p, q in pairs)
        most = MOST * np.log(10)  # as they are told: beyond, a model's own faults decide
        near = sum(abs(np.clip(p, -most, most) - np.clip(q, -most, most)) < np.log(10) for p, q in pairs)
        lines.append(
            f"predicted and realised odds, up to 10^{MOST}: the same sign in {same} of {len(pairs)}, "
            f"within a factor of ten in {near}"
        )
    return lines


def safe(first: int, number: int, standing: bool) -> str:
    """Motions for random scenarios, each in MuJoCo and two engines that are drawn."""
    every, motions, bad = sorted({*engines.available()} - {"mujoco"}), 0, 0
    for seed in range(first, first + number):
        drawn = np.random.default_rng(seed).choice(every, min(2, len(every)), replace=False).tolist()
        with TemporaryDirectory() as folder:
            count, outside = left(seed, Path(folder), ["mujoco", *drawn], standing)
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
    parser.add_argument("--shift", type=int, default=0, help="added to the seeds of all cases")
    parser.add_argument("--arm", choices=ARMS, action="append")
    parser.add_argument("--diagnosed", choices=ARMS, action="append", default=[], help="also diagnosed from nothing")
    parser.add_argument("--safe", type=int, default=0, help="so many random scenarios: does a motion leave a limit?")
    parser.add_argument("--standing", action="store_true", help="on a foot each: does it keep that, too?")
    args = parser.parse_args()
    if args.safe:
        print(safe(args.begin, args.safe, args.standing))
        return
    args.work.mkdir(parents=True, exist_ok=True)
    results = []
    for number in range(args.begin, min(args.end, len(CASES))):
        planted = CASES[number]._replace(seed=CASES[number].seed + args.shift)
        kept = args.work / f"{number:03d}_{planted.seed}.json"
        results.append(run(planted, kept, args.seconds, args.arm or ARMS, args.diagnosed))
        print(json.dumps(results[-1], default=float), flush=True)
    print("\n".join(report(results)))


if __name__ == "__main__":
    main()
