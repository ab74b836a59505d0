"""How long a matrix takes with one worker process and with two, each from an empty folder.

    REALITYGAP_DATA=... python tests/bench_matrix.py [MATRIX] [--twenty] [--jobs 1 2] [--scheduler]

`--twenty` is a matrix of 20 cells, five kicks of a humanoid in four engines. `--scheduler` gives the cells to a local
Dask scheduler with that many worker processes instead. Beside the wall time stands the processor time of all processes,
of the one that plans, collects and writes the page alone, and of the worker that took most: what has to happen one
after the other is the sum of the last two, from which follows what more workers gain where nothing else runs.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
COMMAND = (sys.executable, "-m", "realitygap.cli.main")
TWENTY = f"""name: twenty
scenarios: {ROOT / "scenarios" / "sigmaban" / "scenario.yaml"}
engines: [mujoco, pybullet, drake, dart]
recordings: kick_*
"""
TICKS = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Took:
    """Wall time, processor time of all processes, of the command's own, and of its worker that took most [s]."""

    wall: float
    processor: float
    alone: float
    most: float

    @property
    def path(self) -> float:
        """What has to happen one after the other [s]."""
        return self.alone + self.most


def took(matrix: Path, *options: object) -> Took:
    """What the command takes, from an empty folder."""
    with tempfile.TemporaryDirectory() as out:
        start, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        spent: dict[int, float] = {}
        command = [*COMMAND, "matrix", str(matrix), "--out", out, *map(str, options)]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
            while process.poll() is None:
                for pid in (process.pid, *children(process.pid)):
                    spent[pid] = max(spent.get(pid, 0.0), processor(pid))
                time.sleep(0.02)
        if process.returncode:
            raise SystemExit(f"{' '.join(command)} ended with {process.returncode}")
        wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
        alone = spent.pop(process.pid)
        whole = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return Took(wall, whole, alone, max(spent.values(), default=0.0))


def processor(pid: int) -> float:
    """The processor time of a process so far [s]; 0 of one that has just ended."""
    with suppress(OSError, IndexError):
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / TICKS
    return 0.0


def children(pid: int) -> list[int]:
    """The processes that a process has started."""
    found: list[int] = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        with suppress(OSError):
            found += map(int, task.read_text().split())
    return found


def main() -> None:
    """Print one line per number of workers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("matrix", nargs="?", type=Path, default=ROOT / "scenarios" / "cube_toss" / "matrix.yaml")
    parser.add_argument("--twenty", action="store_true")
    parser.add_argument("--jobs", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--scheduler", action="store_true")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        if args.twenty:
            args.matrix = Path(folder) / "matrix.yaml"
            args.matrix.write_text(TWENTY)
        _measure(args.matrix, args.jobs, scheduler=args.scheduler)


def _measure(matrix: Path, numbers: Sequence[int], *, scheduler: bool) -> None:
    first = None
    for jobs in numbers:
        if scheduler:
            from distributed import LocalCluster  # an extra that only this needs

            with LocalCluster(n_workers=jobs, threads_per_worker=1, dashboard_address=None) as cluster:
                now = took(matrix, "--scheduler", cluster.scheduler_address)
        else:
            now = took(matrix, "-j", jobs)
        first = first or now
        workers = f"{jobs} worker{'s' * (jobs > 1)}"
        lines = (
            f"{workers}: {now.wall:.1f} s, {first.wall / now.wall:.2f} times as fast as the first",
            f"  processor time {now.processor:.1f} s; {now.alone:.1f} s alone and {now.most:.1f} s of one worker make "
            f"{now.path:.1f} s: {first.path / now.path:.2f} times as fast where nothing else runs",
        )
        sys.stdout.write("\n".join([*lines, ""]))
        sys.stdout.flush()


if __name__ == "__main__":
    main()
