"""Work in processes of this machine comes to the same as without them."""

import math
import os
import shutil
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import synthetic
from realitygap.matrix.local import local
from realitygap.report import write_report


def test_figures_and_page_by_two_processes_are_those_by_one(tmp_path: Path) -> None:
    cells = synthetic.grid(engine=["mujoco", "drake"], robot_revision=["old", "new"], recording=["kick", "squat"])
    one = synthetic.write_folder(
        tmp_path / "one", joints=("hip", "knee"), cells=cells, error=lambda c: np.inf if c.engine == "drake" else 0.01
    )
    two = Path(shutil.copytree(one, tmp_path / "two"))
    assert write_report(one) == []
    with local(2) as here:
        assert write_report(two, here.each) == []
    assert _content(one) == _content(two)
    assert len(_content(one)) > len(cells)


def _content(folder: Path) -> dict[str, bytes]:
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_results_come_in_the_order_of_the_items() -> None:
    squares = [float(k * k) for k in range(20)]
    with local(2) as here:
        assert here.each(math.sqrt, squares) == [math.sqrt(x) for x in squares]


def test_what_is_raised_there_is_raised_here() -> None:
    with local(2) as here, pytest.raises(ValueError, match=r"math domain error|nonnegative"):
        here.each(math.sqrt, [4.0, -1.0])


def test_what_a_killed_process_leaves_is_done_here() -> None:
    killed: list[int] = []

    def kill() -> None:
        while not killed:
            for child in (c for t in Path("/proc/self/task").iterdir() for c in (t / "children").read_text().split()):
                if b"matrix.worker" in Path(f"/proc/{child}/cmdline").read_bytes():
                    killed.append(int(child))
                    os.kill(killed[0], signal.SIGKILL)
                    return
            time.sleep(0.02)

    with local(2) as here:
        killing = threading.Thread(target=kill, daemon=True)
        killing.start()
        assert here.each(abs, [-1, 2]) == [1, 2]
    assert len(killed) == 1
