"""How long a matrix takes with one worker process and with two, each from an empty folder.

    REALITYGAP_DATA=... python tests/bench_matrix.py [MATRIX] [--jobs 1 2] [--scheduler]

`--scheduler` gives the cells to a local Dask scheduler with that many worker processes instead.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
COMMAND = Path(sys.executable).with_name("realitygap")


def seconds(matrix: Path, *options: object) -> float:
    """Wall time of the command [s]."""
    with tempfile.TemporaryDirectory() as out:
        start = time.perf_counter()
        subprocess.run([COMMAND, "matrix", matrix, "--out", out, *map(str, options)], check=True, capture_output=True)
        return time.perf_counter() - start


def main() -> None:
    """Print one line per number of workers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("matrix", nargs="?", type=Path, default=ROOT / "scenarios" / "cube_toss" / "matrix.yaml")
    parser.add_argument("--jobs", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--scheduler", action="store_true")
    args = parser.parse_args()
    first = None
    for jobs in args.jobs:
        if args.scheduler:
            from distributed import LocalCluster  # an extra that only this needs

            with LocalCluster(n_workers=jobs, threads_per_worker=1, dashboard_address=None) as cluster:
                took = seconds(args.matrix, "--scheduler", cluster.scheduler_address)
        else:
            took = seconds(args.matrix, "-j", jobs)
        first = first or took
        sys.stdout.write(
            f"{jobs} worker{'s' * (jobs > 1)}: {took:.1f} s, {first / took:.2f} times as fast as the first\n"
        )
        sys.stdout.flush()


if __name__ == "__main__":
    main()
