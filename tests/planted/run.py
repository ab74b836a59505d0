"""Run the blind suite: generate the cases, diagnose each with the command, judge, and write the tables.

    python tests/planted/run.py [--only single] [--robot pendulum] [--first 20] [--jobs 1] [--engine mujoco]

Cases that are there already, and diagnoses that are done, are kept: an interrupted run goes on where it stopped.
"""

import argparse
import json
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
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
        command = [*COMMAND, "diagnose", work / "cases" / name / "scenario.yaml", "--out", out, *options]
        start = time.monotonic()
        with (out / "log.txt").open("w") as log:
            try:
                subprocess.run(command, stdout=log, stderr=subprocess.STDOUT, timeout=limit, check=False)
            except subprocess.TimeoutExpired:
                log.write(f"\nstopped after {limit:g} s\n")
        (out / "seconds.json").write_text(json.dumps({"seconds": round(time.monotonic() - start, 1)}) + "\n")
    return judge.read(truth, written)


def report(scores: list[judge.Score], work: Path, reference: Path) -> None:
    """Write `blind.csv`, the confusion matrix and the table of goals, and show the latter."""
    reference.mkdir(parents=True, exist_ok=True)
    summary.write_scores(scores, reference / "blind.csv")
    summary.write_confusion(scores, reference)
    rows = summary.goals(scores, summary.read_seconds(work / "diagnoses"))
    say("")
    for row in [("", "goal", "reached"), *rows]:
        say(f"{row[0]:50s} {row[1]:>8s}   {row[2]}")


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
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    work = args.work.absolute()
    chosen = [c for kind in args.only or KINDS for c in makers(kind, args.seed, args.robot)[: args.first]]
    if args.generate:
        for name, make in chosen:
            if not (work / "truth" / f"{name}.json").is_file():
                make(work)
                say(name)
        return
    if args.done:
        chosen = [c for c in chosen if (work / "diagnoses" / c[0] / "diagnosis.json").is_file()]

    def one(item: tuple[str, Make]) -> judge.Score:
        score = diagnose(*item, work, args.engine, args.limit, args.again)
        mark = "ok   " if score.exact else ("FAIL " if score.verdict == "failed" else "WRONG")
        say(f"{mark} {score.case}: {score.truth} -> {score.named or 'nothing'} ({score.verdict})")
        return score

    with ThreadPoolExecutor(args.jobs) as pool:
        scores = list(pool.map(one, chosen))
    report(scores, work, (args.reference or work).absolute())


if __name__ == "__main__":
    main()
