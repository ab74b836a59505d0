"""`realitygap run`: one scenario through the engines, each compared with what was measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from realitygap.compare.budget import not_judged, over_budget, stated_budget
from realitygap.compare.comparison import Comparison, Motion, compare, motions_of
from realitygap.compare.junit import Case, write_junit
from realitygap.compare.manifest import write_manifest
from realitygap.compare.table import means, slug, table, to_csv
from realitygap.files.progress import Progress
from realitygap.files.result_folder import written_whole
from realitygap.files.whole import write_whole
from realitygap.report import write_curves, write_figures, write_page
from realitygap.scenario.engine_names import engine_names
from realitygap.scenario.file import load_scenario
from realitygap.trace.mcap import write_mcap


@dataclass
class RunResult:
    """What a run gave: the scenario's name and stated budget, the table, the comparisons behind it, and the page."""

    folder: Path
    scenario: str
    budget: dict[str, float]
    gaps: pd.DataFrame
    comparisons: list[Comparison] = field(default_factory=list)
    page: Path | None = None


def run(path: Path, names: Sequence[str], out: Path, progress: Progress) -> RunResult:
    """Simulate every motion of a scenario in every engine and write traces, tables, figures and the page.

    Args:
        path: the scenario file.
        names: engines; empty for all that are installed.
        out: the result folder.
        progress: told what is being done.

    Raises:
        InputError: for a scenario that cannot be run; nothing is written then.
    """
    chosen = engine_names(names)
    file = load_scenario(path)
    found = motions_of(file)
    for note in dict.fromkeys(note for motion in found for e in motion.experiments for note in e.notes):
        progress.say(note)
    garbled = sum(len(e.recording.outliers) for motion in found for e in motion.experiments if e.recording is not None)
    if garbled:
        progress.say(f"readings that jump far away and back, and are not taken: {garbled} (listed in manifest.json)")
    result = RunResult(out, file.scenario.name, stated_budget(file.scenario.budget), table([]))
    with written_whole(out) as folder:
        with progress.task("simulating", len(found) * len(chosen)) as advance:
            for engine in chosen:
                for motion in found:
                    advance(f"{engine}: {motion.name}")
                    comparison = compare(motion, engine)
                    result.comparisons.append(comparison)
                    write_traces(folder, comparison, motion)
        result.gaps = table(r for c in result.comparisons for r in c.rows)
        write_tables(folder, result.gaps, result.comparisons)
        write_manifest(
            folder,
            file.scenario.name,
            [(file, motion) for motion in found],
            [(c.cell, c.settings) for c in result.comparisons if c.settings],
            {slug(c.cell): f"{c.outcome}: {c.note}" for c in result.comparisons if c.outcome != "ok"},
            [f"traces/{slug(c.cell)}.mcap" for c in result.comparisons if c.simulated is not None],
        )
        write_figures(folder)
        result.page = out / write_page(folder).name
    return result


def write_traces(out: Path, comparison: Comparison, motion: Motion) -> None:
    """The traces of one cell as MCAP, and the curves for the page."""
    if comparison.simulated is None:
        return
    traces = {"simulated": comparison.simulated}
    if comparison.measured is not None:
        traces["measured"] = comparison.measured
    name = slug(comparison.cell)
    write_mcap(out / "traces" / f"{name}.mcap", traces)
    write_curves(out, comparison.cell, comparison.simulated, comparison.measured, motion.experiments[0].plant.model)


def write_tables(out: Path, gaps: pd.DataFrame, comparisons: Sequence[Comparison]) -> None:
    """`gaps.csv` and `timings.csv`."""
    write_whole(out / "gaps.csv", to_csv(gaps))
    rows = []
    for c in comparisons:
        if c.rollout is not None:
            seconds = c.rollout.steps / c.cell.step_rate
            wall = c.rollout.wall
            rows.append(
                {**vars(c.cell), "wall_seconds": wall, "real_time_factor": seconds / wall, "steps": c.rollout.steps}
            )
    write_whole(out / "timings.csv", to_csv(pd.DataFrame(rows)))


def summary(result: RunResult) -> list[str]:
    """Lines for the terminal: what failed, and the mean gap of every engine beside both floors."""
    lines = [
        f"{c.cell.engine}, {c.cell.recording or c.cell.scenario}: {c.outcome}: {c.note}"
        for c in result.comparisons
        if c.outcome != "ok"
    ]
    if result.gaps.empty:
        return [*lines, "nothing was measured: no gap, traces only"]
    good = means(result.gaps[result.gaps["outcome"] == "ok"])
    for (group, signal, unit, engine), rows in good.groupby(["group", "signal", "unit", "engine"], sort=True):
        lines.append(
            f"{signal:22} {group:9} {engine:9} {rows['mean_abs'].mean():9.4g} {unit:6}"
            f"(noise floor {_known(rows['noise_floor'])}, numerical floor {_known(rows['numerical_floor'])})"
        )
    return lines


def _known(floors: pd.Series[float]) -> str:
    return "unknown" if floors.isna().all() else f"{floors.mean():.2g}"


def judge(result: RunResult, budget: Mapping[str, float], junit: Path | None = None) -> list[str]:
    """Sentences on the cells that exceed a budget and, where asked for, JUnit XML with every cell as a test."""
    if junit is not None:
        cases = [
            Case(
                suite=c.cell.scenario,
                name=f"{c.cell.engine}: {c.cell.recording or c.cell.scenario}",
                outcome=c.outcome,
                note=c.note,
                seconds=c.rollout.wall if c.rollout is not None else None,
                over=over_budget(table(c.rows), budget),
            )
            for c in result.comparisons
        ]
        write_junit(junit, result.scenario, cases)
    return over_budget(result.gaps, budget) + not_judged(result.gaps, budget)
