"""What a diagnosis makes of real machines: recordings of four servos and drives and of a thrown cube.

    REALITYGAP_DATA=... python tests/bench_stories.py [--only emps,cube_toss] [--write results/reference]

Each story starts from a model that lacks something, is fitted on some recordings and judged on others. Written are the
named effects with their 95 % intervals beside published values, the held-out gap and the plain root mean square error
before and after in every engine. `--only` leaves the rows of other stories as they were.
"""

import argparse
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import realitygap_engines as engines
from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.gaps import cost, rms
from realitygap.diagnose.result.diagnosis import Diagnosis
from realitygap.diagnose.result.summary import summary
from realitygap.diagnose.result.workflow import run_diagnosis
from realitygap.files.progress import Progress
from realitygap.recording.frames import angle_between
from realitygap.robot.drive import Array

SCENARIOS = Path(__file__).parents[1] / "scenarios"
STORIES = {
    "emps": ("emps/scenario.yaml", "A linear drive without friction and 10 % too light; two cycles each."),
    "mx106_bench": ("mx106_bench/scenario.yaml", "A servo without friction: loads 0, 4, 8; judged on 2 and 6."),
    "xl330_pendulum": ("xl330_pendulum/diagnose.yaml", "A servo without friction: firmware P 100; judged on 400."),
    "sts3215_pendulum": ("sts3215_pendulum/diagnose.yaml", "A servo without friction: 0.535 kg; judged on 0.969 kg."),
    "cube_toss": (
        "cube_toss/diagnose.yaml",
        "A cube on rigid ground of friction 0.8: even tosses; judged on odd ones.",
    ),
}
PUBLISHED = {
    ("emps", "viscous_friction", "coefficient"): 203.5,
    ("emps", "coulomb_friction", "torque"): 20.39,
    ("emps", "link_mass", "mass"): 95.11,
    ("emps", "constant_effort", "effort"): 3.16,  # -3.16 N on the other side of the published equation
}
UNITS = {
    "position": "rad or m",
    "velocity": "rad/s or m/s",
    "effort": "N·m or N",
    "base_position": "m",
    "base_quaternion": "rad",
}
COLUMNS = ["story", "quantity", "effect", "target", "name", "engine", "unit", "before", "after", "low", "high", "known"]


def findings(story: str, said: dict[str, Any]) -> list[dict[str, object]]:
    """A row per parameter of what was named, and of what was adjusted besides; `after` is its value."""
    rows = []
    told = [(f"finding {number}", f) for number, f in enumerate(said["findings"], 1)]
    for quantity, finding in [*told, *(("adjusted", f) for f in said["adjusted"])]:
        target = finding["target"] if isinstance(finding["target"], str) else " ".join(finding["target"])
        for name, p in finding["parameters"].items():
            rows.append(
                {
                    "story": story,
                    "quantity": quantity,
                    "effect": finding["effect"],
                    "target": target,
                    "name": name,
                    "engine": said["engines"][0],
                    "unit": p["unit"],
                    "after": p["value"],
                    "low": p["low"],
                    "high": p["high"],
                    "known": PUBLISHED.get((story, finding["effect"], name)),
                }
            )
    return rows


def held_out(story: str, result: Diagnosis) -> list[dict[str, object]]:
    """A row per engine and signal: gap in floors and root mean square error before and after, on held-out motions."""
    rows: list[dict[str, object]] = []
    with Simulations(result.problem, 1) as simulations:
        for engine in engines.available():
            before, after = (errors(result, simulations, changes, engine) for changes in ((), result.mended))
            if before is None or after is None:
                rows.append({"story": story, "quantity": "cannot be simulated", "engine": engine})
                continue
            for name, value in before.items():
                what = {"quantity": "gap" if name == "gap" else "rms", "name": name, "unit": UNITS.get(name, "floors")}
                rows.append({"story": story, **what, "engine": engine, "before": value, "after": after[name]})
    return rows


def errors(
    result: Diagnosis, simulations: Simulations, changes: Sequence[Change], engine: str
) -> dict[str, float] | None:
    """The gap in floors, and by signal the root mean square error of the held-out motions in SI units."""
    problem, judge = result.problem, result.problem.of("held_out")
    squares: dict[str, list[Array]] = {}
    costs = {}
    for case, simulated in zip(judge, simulations.of(changes, judge, engine=engine), strict=True):
        if simulated is None:
            return None
        costs[case] = cost(problem, result.floors, case, simulated)
        for signal, value in simulated.items():
            measured = problem.cases[case].value(signal)
            if signal == "base_quaternion":
                squares.setdefault(signal, []).append(angle_between(value, measured) ** 2)
            else:
                squares.setdefault(signal, []).append(np.sum((value - measured) ** 2, axis=1))
    means = {signal: float(np.sqrt(np.nanmean(np.concatenate(parts)))) for signal, parts in squares.items()}
    return {"gap": rms(costs, judge)} | means


def page(table: pd.DataFrame) -> str:
    """The table for people."""
    lines = [
        "# Stories of real machines",
        "",
        "Made by `tests/bench_stories.py`: what a diagnosis finds in public recordings, in MuJoCo, and the error on",
        "held-out recordings before and after in every engine. Values with 95 % intervals.",
    ]
    for story, (path, sentence) in STORIES.items():
        own = table[table["story"] == story]
        if own.empty:
            continue
        lines += ["", f"## {story}", "", f"{sentence} Scenario: `scenarios/{path}`."]
        row: Any  # pandas cannot type the columns of a row
        for row in own[own["quantity"] == "seconds"].itertuples():
            lines[-1] += f" {row.after:.0f} s on {WHERE}."
        lines += ["", "| effect | at | parameter | value | 95 % | published |", "|---|---|---|---|---|---|"]
        for row in own[own["quantity"].str.match("finding|adjusted")].itertuples():
            effect = f"{row.effect}{', adjusted' * (row.quantity == 'adjusted')}"
            known = "" if pd.isna(row.known) else f"{row.known:g} ({100 * (row.after / row.known - 1):+.1f} %)"
            between = "fixed" if row.low == row.high else f"{row.low:.4g} to {row.high:.4g}"
            value = f"{row.after:.4g} {'' if pd.isna(row.unit) else row.unit}".strip()
            lines.append(f"| {effect} | {row.target} | {row.name} | {value} | {between} | {known} |")
        judged = own[own["quantity"].isin(["gap", "rms"])]
        wide = judged.assign(
            cell=[f"{b:.3g} → {a:.3g}" for b, a in zip(judged["before"], judged["after"], strict=True)]
        )
        names = list(dict.fromkeys(wide["name"]))
        units = dict(zip(wide["name"], wide["unit"], strict=True))
        lines += ["", f"| engine | {' | '.join(f'{n} [{units[n]}]' for n in names)} |", "|---" * (len(names) + 1) + "|"]
        for engine, rows in wide.groupby("engine"):
            cells = dict(zip(rows["name"], rows["cell"], strict=True))
            lines.append(f"| {engine} | {' | '.join(cells[n] for n in names)} |")
        for row in own[own["quantity"].str.startswith("unsupported")].itertuples():
            lines += ["", f"{row.engine}: {row.quantity}."]
    return "\n".join(lines) + "\n"


WHERE = "two slow cores that other work shared"
"""Where the times in the page were taken."""


def main() -> None:
    """Run the stories, print what they say and write where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default=",".join(STORIES))
    parser.add_argument("--write", type=Path, help="the folder of stories.csv and stories.md")
    options = parser.parse_args()
    chosen = [s for s in STORIES if s in options.only.split(",")]
    file = options.write / "stories.csv" if options.write else None
    table = pd.read_csv(file) if file is not None and file.is_file() else pd.DataFrame(columns=COLUMNS)
    for story in chosen:
        began = time.perf_counter()
        with tempfile.TemporaryDirectory() as out:
            result = run_diagnosis(SCENARIOS / STORIES[story][0], [], Path(out), Progress())
        seconds = round(time.perf_counter() - began)
        print(f"{story}: {seconds} s", *summary(result), sep="\n", flush=True)
        rows = findings(story, result.to_json()) + held_out(story, result)
        rows.append({"story": story, "quantity": "seconds", "unit": "s", "after": seconds})
        kept = table[table["story"] != story]
        table = (
            pd.concat([kept, pd.DataFrame(rows, columns=COLUMNS)]) if len(kept) else pd.DataFrame(rows, columns=COLUMNS)
        )
        if file is not None:
            number = table["story"].map(list(STORIES).index)
            table = table.assign(number=number).sort_values("number", kind="stable").drop(columns="number")
            options.write.mkdir(parents=True, exist_ok=True)
            table.to_csv(file, index=False, float_format="%.5g", lineterminator="\n")
            (options.write / "stories.md").write_text(page(table), encoding="utf-8")


if __name__ == "__main__":
    main()
