"""Run the suite: generate the cases, diagnose each with the command, judge, and write the tables.

    python tests/planted/run.py [--only single] [--robot pendulum] [--first 20] [--seed 1 --seed 6] [--generate]

Of even seeds, no case is shown: what they total says whether what odd seeds taught holds for cases nobody looked into.
Cases that are there already, and diagnoses that are done, are kept: an interrupted run goes on where it stopped.
"""

import argparse
import json
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import judge
import summary
from cases import KINDS, Make, makers
from robots import BUILDERS

ROOT = Path(__file__).parents[2]
COMMAND = (sys.executable, "-m", "realitygap.cli.main")
"""The command line of the tree that PYTHONPATH names, or of the one that is installed."""


def say(text: str) -> None:
    """A line on the terminal, at once."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def generate(chosen: list[tuple[str, Make]], work: Path) -> None:
    """Write the cases that are not there."""
    for name, make in chosen:
        if not (work / "truth" / f"{name}.json").is_file():
            make(work)
            say(name)


def diagnose(name: str, make: Make, work: Path, engines: list[str], limit: float, again: bool) -> judge.Score:
    """Generate, diagnose and judge one case, as far as that is not done."""
    truth, out = work / "truth" / f"{name}.json", work / "diagnoses" / name
    if not truth.is_file():
        make(work)
    written = out / "diagnosis.json"
    if again or not written.is_file():
        out.mkdir(parents=True, exist_ok=True)
        written.unlink(missing_ok=True)
        options = [x for engine in engines for x in ("--engine", engine)]
        command = [*COMMAND, "diagnose", str(work / "cases" / name / "scenario.yaml"), "--out", str(out), *options]
        start = time.monotonic()
        with (out / "log.txt").open("w") as log:
            try:
                subprocess.run(command, stdout=log, stderr=subprocess.STDOUT, timeout=limit, check=False)
            except subprocess.TimeoutExpired:
                log.write(f"\nstopped after {limit:g} s\n")
        (out / "seconds.json").write_text(json.dumps({"seconds": round(time.monotonic() - start, 1)}) + "\n")
    return judge.read(truth, written)


def sealed(seed: int) -> bool:
    """Whether nobody looks into the cases of a seed: of even ones only totals are told."""
    return seed % 2 == 0


def report(scores: list[judge.Score], seconds: dict[str, float], reference: Path, name: str, closed: bool) -> None:
    """Write the tables of some seeds under a name, and show their totals; of sealed ones nothing else is written."""
    reference.mkdir(parents=True, exist_ok=True)
    summary.write_kinds(scores, reference / f"{name}_kinds.csv")
    if not closed:
        summary.write_scores(scores, reference / f"{name}.csv")
        summary.write_confusion(scores, reference, name)
    say(f"\n{name}: {len(scores)} cases" + (", sealed" if closed else ""))
    for row in [("", "goal", "reached"), *summary.goals(scores, seconds)]:
        say(f"{row[0]:52s} {row[1]:>8s}   {row[2]}")
    for kind in summary.by_kind(scores):
        say("; ".join(f"{k} {v}" for k, v in kind.items() if v != "-"))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", type=Path, default=ROOT / "results" / "runs" / "blind", help="cases and diagnoses")
    parser.add_argument("--reference", type=Path, help="where the tables go (default: the work folder)")
    parser.add_argument("--only", choices=KINDS, action="append")
    parser.add_argument("--robot", choices=list(BUILDERS), action="append")
    parser.add_argument("--first", type=int, help="this many of each kind")
    parser.add_argument("--jobs", type=int, default=1, help="cases at once")
    parser.add_argument("--engine", action="append", default=[], help="passed on to the command")
    parser.add_argument("--limit", type=float, default=1800.0, help="seconds for one case")
    parser.add_argument("--again", action="store_true", help="diagnose anew what is done")
    parser.add_argument("--done", action="store_true", help="judge what is done, and run nothing")
    parser.add_argument(
        "--generate", action="store_true", help="write the cases and their truths, and diagnose nothing"
    )
    parser.add_argument("--seed", type=int, action="append", help="even ones are sealed: nobody looks into their cases")
    args = parser.parse_args()
    results: dict[bool, tuple[list[judge.Score], dict[str, float]]] = {}
    for seed in args.seed or [1]:
        work = args.work.absolute() / f"seed_{seed}"
        work.mkdir(parents=True, exist_ok=True)
        chosen = [c for kind in args.only or KINDS for c in makers(kind, seed, args.robot)[: args.first]]
        if args.generate:
            generate(chosen, work)
            continue
        if args.done:
            chosen = [c for c in chosen if (work / "diagnoses" / c[0] / "diagnosis.json").is_file()]
        closed = sealed(seed)
        scores, seconds = results.setdefault(closed, ([], {}))
        with ThreadPoolExecutor(args.jobs) as pool:
            todo = [(name, make, work, args.engine, args.limit, args.again) for name, make in chosen]
            for score in pool.map(lambda case: diagnose(*case), todo):
                scores.append(replace(score, case=f"{seed}/{score.case}"))
                if not closed:
                    mark = "ok   " if score.exact else ("FAIL " if score.verdict == "failed" else "WRONG")
                    say(f"{mark} {score.case}: {score.truth} -> {score.named or 'nothing'} ({score.verdict})")
        seconds |= {f"{seed}/{k}": v for k, v in summary.read_seconds(work / "diagnoses").items()}
    for closed, (scores, seconds) in sorted(results.items()):
        name = "blind_sealed" if closed else "blind"
        report(scores, seconds, (args.reference or args.work).absolute(), name, closed)


if __name__ == "__main__":
    main()
