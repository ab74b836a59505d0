"""What `realitygap matrix` prints, and its exit status."""

from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from realitygap.compare.budget import not_judged
from realitygap.compare.junit import write_junit
from realitygap.files.progress import Progress
from realitygap.matrix.junit import cases, excess
from realitygap.matrix.matrix import Settings, dry_run, run_matrix
from realitygap.report.folder import read_folder
from realitygap.report.sentences import sentences


def matrix_command(
    path: Path, out: Path, settings: Settings, budget: Mapping[str, float], junit: Path | None
) -> tuple[list[str], int]:
    """Run a matrix. Returns the lines to print and the exit status: 1 where a budget is exceeded."""
    collected, page = run_matrix(path, out, settings, Progress())
    over = excess(collected, budget)
    if junit is not None:
        write_junit(junit, path.stem, cases(collected, over))
    counts = Counter(o.outcome for _, o in collected.cells)
    lines = [f"{len(collected.cells)} cells: " + ", ".join(f"{n} {what}" for what, n in counts.most_common())]
    lines += [s.text for s in sentences(read_folder(out))]
    excesses = [line for found in over.values() for line in found] + not_judged(collected.gaps, budget)
    return [*lines, *excesses, f"report: {page}"], int(bool(excesses))


def listed(path: Path, out: Path, settings: Settings) -> tuple[list[str], int]:
    """The cells and an estimate, without running anything."""
    return dry_run(path, out, settings), 0
