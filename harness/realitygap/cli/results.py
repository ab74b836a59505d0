"""`run` and `matrix`: the matrix's room makes the result folder, the report's room its page, and here they meet."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from realitygap.cli.missing_effort import add_missing
from realitygap.compare.budget import stated_budget
from realitygap.compare.row import outcome_told
from realitygap.compare.table import means
from realitygap.files.errors import spared
from realitygap.files.found import counted
from realitygap.files.progress import Progress
from realitygap.files.result_kind import held_scenario
from realitygap.matrix.collect import Collected
from realitygap.matrix.junit import write_junit
from realitygap.matrix.matrix import ONCE, Settings, dry_run, results
from realitygap.matrix.matrix_file import MatrixFile, load_matrix, matrix_of
from realitygap.report import write_report
from realitygap.report.folder import read_folder
from realitygap.report.levels import differ, levels
from realitygap.report.sentences import NO_RESULT, SAME, sentences
from realitygap.scenario.engine_names import engine_names
from realitygap.scenario.file import load_scenario

CONTEXT = ("engine", "recording")
"""What cells of one scenario differ in."""
Said = tuple[list[str], int]
"""The lines to print and the exit status: 1 where a budget is exceeded."""


def run(
    path: Path,
    engines: Sequence[str],
    out: Path,
    budget: Mapping[str, float],
    junit: Path | None,
    progress: Progress,
    *,
    missing: bool = False,
    whole: bool = False,
) -> Said:
    """Run one scenario: the matrix of it alone. A budget that is given replaces the scenario's own for its signal.

    With `missing`, the effort that the model lacks is worked out, too; with `whole`, traces are kept however large.
    """
    chosen = engine_names(engines)
    file = load_scenario(path)
    limits = stated_budget(file.scenario.budget) | dict(budget)
    lacking: list[str] = []
    before = held_scenario(out)
    with results(matrix_of(file, chosen, whole=whole), out, ONCE, progress) as (made, folder, _):
        if missing:
            with spared("the missing effort", made.failures):
                lacking = add_missing(folder, file, chosen, progress)
        made.failures.extend(write_report(folder))
    _say_failed(made, progress)
    return _said(made, [*summary(made), *lacking, *_replaced(before, made.name, out)], out, limits, junit)


def matrix(
    path: Path, out: Path, settings: Settings, budget: Mapping[str, float], junit: Path | None, progress: Progress
) -> Said:
    """Run all cells of a matrix."""
    before = held_scenario(out)
    made = make(load_matrix(path), out, settings, progress)
    counts = Counter(o.outcome for _, o in made.cells)
    lines = [f"{counted(len(made.cells), 'cell')}: " + ", ".join(f"{n} {what}" for what, n in counts.most_common())]
    with spared("the summary", made.failures):
        lines += [s.text for s in sentences(read_folder(out))]
    _say_failed(made, progress)
    return _said(made, [*lines, *_replaced(before, made.name, out)], out, budget, junit)


def listed(path: Path, out: Path, settings: Settings) -> Said:
    """The cells and an estimate, without running anything."""
    return dry_run(load_matrix(path), out, settings), 0


def make(matrix: MatrixFile, out: Path, settings: Settings, progress: Progress) -> Collected:
    """The whole result folder of a matrix, with figures and page.

    Raises:
        InputError: for a matrix that cannot be run; nothing is written then.
    """
    with results(matrix, out, settings, progress) as (made, folder, here):
        made.failures.extend(write_report(folder, here.each))
    return made


def _replaced(before: str | None, name: str, out: Path) -> list[str]:
    """That results of another scenario are no longer there, as two folders of one name come to."""
    if before in (None, name):
        return []
    return [f"the results of {before}, which were in {out}, are replaced; --out takes another folder"]


def _say_failed(made: Collected, progress: Progress) -> None:
    """On standard error, as a build server shows it: nothing that was asked for is there."""
    if not made.has_result:
        progress.say(NO_RESULT)


def _said(made: Collected, lines: list[str], out: Path, budget: Mapping[str, float], junit: Path | None) -> Said:
    over = made.excess(budget)
    if junit is not None:
        write_junit(junit, made.name, made.cells, over)
    excess = [line for found in over.values() for line in found] + made.not_judged(budget)
    return [*lines, *made.failures, *excess, f"report: {out / 'report.html'}"], int(bool(excess))


def summary(made: Collected) -> list[str]:
    """What failed, and the mean gap of every engine beside both floors, and where they let no difference be seen."""
    lines = [
        f"{o.cell.engine}, {o.cell.recording or o.cell.scenario}: {outcome_told(o.outcome, o.note)}"
        for _, o in made.cells
        if o.outcome != "ok"
    ]
    if made.gaps.empty and made.has_result:
        return [*lines, "nothing was measured: no gap, traces only"]
    good = means(made.gaps[made.gaps["outcome"] == "ok"])
    for (group, signal, unit), part in good.groupby(["group", "signal", "unit"], sort=True):
        for engine, rows in part.groupby("engine", sort=True):
            lines.append(
                f"{signal:22} {group:9} {engine:9} {rows['mean_abs'].mean():9.4g} {unit:6}"
                f"(noise floor {_known(rows['noise_floor'])}, numerical floor {_known(rows['numerical_floor'])}"
                f"{_unseen(rows, part)})"
            )
    return lines


def _known(floors: "pd.Series[float]") -> str:
    return "unknown" if floors.isna().all() else f"{floors.mean():.2g}"


def _unseen(rows: pd.DataFrame, part: pd.DataFrame) -> str:
    """What an engine's gap is no different from: the recording, or the closest of all engines of a `part`."""
    for own in levels(rows, "engine", CONTEXT):
        if not own.seen:
            return f"; {SAME} from the recording"
    ran = sorted(levels(part, "engine", CONTEXT), key=lambda level: level.gap)
    engine = rows["engine"].iloc[0]
    alike = [level for level in ran[1:] if level.value == engine and not differ(ran[0], level)]
    return f"; {SAME} to {ran[0].value}" if alike else ""
