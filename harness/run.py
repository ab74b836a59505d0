"""`realitygap run`: one scenario through the engines, each compared with what was measured."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

import engines
from harness.comparison import Comparison, Motion, compare, motions
from harness.errors import InputError
from harness.experiment import experiments
from harness.manifest import write_manifest
from harness.mcap import write_mcap
from harness.progress import Progress
from harness.report import write_curves, write_figures, write_page
from harness.results import means, slug, table, to_csv, write_whole
from harness.scenario_file import load_scenario


@dataclass
class RunResult:
    """What a run gave: the table, the comparisons behind it, and the page."""

    folder: Path
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
    file = load_scenario(path)
    chosen = engine_names(names)
    found = motions(experiments(file))
    result = RunResult(out, table([]))
    with progress.task("simulating", len(found) * len(chosen)) as advance:
        for engine in chosen:
            for motion in found:
                advance(f"{engine}: {motion.name}")
                comparison = compare(file, motion, engine)
                result.comparisons.append(comparison)
                write_traces(out, comparison, motion)
    result.gaps = table(r for c in result.comparisons for r in c.rows)
    write_tables(out, result.gaps, result.comparisons)
    write_manifest(
        out,
        file.scenario.name,
        [(file, motion) for motion in found],
        [(c.cell, c.settings) for c in result.comparisons if c.settings],
        {slug(c.cell): f"{c.outcome}: {c.note}" for c in result.comparisons if c.outcome != "ok"},
        [f"traces/{slug(c.cell)}.mcap" for c in result.comparisons if c.simulated is not None],
    )
    write_figures(out)
    result.page = write_page(out)
    return result


def engine_names(names: Sequence[str]) -> list[str]:
    """The engines asked for, or all that are installed.

    Raises:
        InputError: for an engine that does not exist or is not installed.
    """
    for name in names:
        if name not in engines.ENGINES:
            raise InputError(f"--engine: found {name}; expected one of {', '.join(sorted(engines.ENGINES))}")
        if name not in engines.available():
            raise InputError(f"--engine: {name} is not installed; install it with: {engines.ENGINES[name].install}")
    return list(dict.fromkeys(names)) or engines.available()


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


def summary(gaps: pd.DataFrame) -> list[str]:
    """Lines for the terminal: the mean gap of every engine, beside both floors."""
    lines = []
    if gaps.empty:
        return ["nothing was measured: no gap, traces only"]
    bad = gaps[gaps["outcome"] != "ok"].drop_duplicates(["engine", "recording"])
    for record in bad.itertuples():
        lines.append(f"{record.engine}, {record.recording}: {record.outcome}: {record.note}")
    good = gaps[gaps["outcome"] == "ok"]
    for (group, signal, unit), part in means(good).groupby(["group", "signal", "unit"], sort=True):
        for engine, rows in part.groupby("engine"):
            floor = rows[["noise_floor", "numerical_floor"]].mean()
            lines.append(
                f"{signal:22} {group:9} {engine:9} {rows['mean_abs'].mean():9.4g} {unit:6}"
                f"(noise floor {floor['noise_floor']:.2g}, numerical floor {floor['numerical_floor']:.2g})"
            )
    return lines
