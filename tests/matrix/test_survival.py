"""A matrix survives its worker processes and itself: signals are sent to real processes in the middle of real cells."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TypeVar

import pytest
from realitygap.compare.table import read_gaps
from realitygap.matrix.local import local
from realitygap.matrix.matrix import finished
from realitygap.matrix.matrix_file import load_matrix
from realitygap.matrix.plan import plan
from realitygap.matrix.store import FolderStore
from realitygap.matrix.task import Outcome, Task, read_outcome

T = TypeVar("T")
DEMO = Path(__file__).parents[2] / "scenarios" / "demo"
WORDS = "name: test\nscenarios: {demo}/scenario.yaml\nengines: mujoco\nrecordings: [chirp_1, triangle_1]\n"
SAME = ("gaps.csv", "manifest.json")


@pytest.fixture
def matrix(tmp_path: Path) -> Path:
    """A matrix of four cells of about a second and more, longer than a signal takes to be sent."""
    path = tmp_path / "matrix.yaml"
    path.write_text(WORDS.format(demo=DEMO) + "axes: {step_rate: [50000, 60000]}\nfloors: false\n")
    return path


def workers(parent: int) -> list[int]:
    """The worker processes of a process."""
    found = []
    for task in Path(f"/proc/{parent}/task").iterdir():
        for child in (task / "children").read_text().split():
            try:
                words = Path(f"/proc/{child}/cmdline").read_bytes()
            except OSError:
                continue
            if b"realitygap.matrix.worker" in words:
                found.append(int(child))
    return found


def temporary_folder(pid: int) -> Path:
    """Where a process puts temporary files."""
    words = Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
    return Path(next(word for word in words if word.startswith(b"TMPDIR=")).removeprefix(b"TMPDIR=").decode())


def wait_for(what: Callable[[], T], seconds: float = 120.0) -> T:
    end = time.monotonic() + seconds
    while not (found := what()):
        assert time.monotonic() < end, "waited too long"
        time.sleep(0.02)
    return found


def send(signals: list[int], store: FolderStore) -> None:
    """Send signals to the worker of this process, each after a further cell is done."""
    for number in signals:
        wait_for(partial(grown, store, len(store.keys())))
        time.sleep(0.3)
        os.kill(wait_for(lambda: workers(os.getpid()))[0], number)


def grown(store: FolderStore, size: int) -> bool:
    return len(store.keys()) > size


def run(
    matrix: Path, folder: Path, signals: list[int], limit: float = 60.0
) -> tuple[dict[str, Outcome], dict[str, str]]:
    """What became of the cells of a matrix whose worker got signals: outcome by key, and what was not done."""
    tasks = plan(load_matrix(matrix))
    store = FolderStore(folder)
    undone: dict[str, str] = {}

    def done(task: Task, what: str | None) -> None:
        if what is not None:
            undone[task.key] = what

    sender = threading.Thread(target=send, args=(signals, store), daemon=True)
    sender.start()
    there = finished(tasks, store)
    with local(1) as here:
        here.cells([t for t in tasks if t.key not in there], str(folder), limit, done)
    sender.join()
    return finished(tasks, store), undone


def test_a_segmentation_fault_is_the_outcome_of_one_cell(matrix: Path, tmp_path: Path) -> None:
    outcomes, undone = run(matrix, tmp_path / "cells", [signal.SIGSEGV])
    assert not undone
    crashed = [o for o in outcomes.values() if o.outcome != "ok"]
    assert len(outcomes) == 4
    assert len(crashed) == 1
    assert crashed[0].outcome == "crashed"
    assert crashed[0].note == "the process was ended by SIGSEGV (segmentation fault)"
    assert crashed[0].rows
    assert all(r.mean_abs == float("inf") and r.outcome == "crashed" for r in crashed[0].rows)
    again, _ = run(matrix, tmp_path / "cells", [])
    assert [o.outcome for o in again.values()].count("crashed") == 1, "a crash stays until it is asked for again"
    tasks = plan(load_matrix(matrix))
    assert len(finished(tasks, FolderStore(tmp_path / "cells"), retry_crashed=True)) == 3


def test_a_process_that_hangs_is_ended_at_the_time_limit(matrix: Path, tmp_path: Path) -> None:
    outcomes, undone = run(matrix, tmp_path / "cells", [signal.SIGSTOP], limit=20.0)
    assert not undone
    bad = [(o.outcome, o.note) for o in outcomes.values() if o.outcome != "ok"]
    assert bad == [("timeout", "took longer than the time limit of 20 s")]


def test_a_cell_whose_process_was_killed_is_tried_once_more(matrix: Path, tmp_path: Path) -> None:
    outcomes, undone = run(matrix, tmp_path / "cells", [signal.SIGKILL, signal.SIGKILL])
    assert not undone
    assert [o.outcome for o in outcomes.values()] == ["ok"] * 4


def command(matrix: Path, out: Path) -> list[str]:
    return [sys.executable, "-m", "realitygap.cli.main", "matrix", str(matrix), "-j", "2", "--out", str(out)]


def content(folder: Path) -> dict[str, bytes]:
    """The files of a result folder that tell physics: without timings and what is drawn from them."""
    paths = [folder / name for name in SAME] + sorted((folder / "curves").glob("*"))
    paths += sorted((folder / "traces").glob("*")) + sorted((folder / "figures").glob("*"))
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in paths}


def test_killed_and_started_again_it_ends_with_the_same_files(matrix: Path, tmp_path: Path) -> None:
    disturbed = tmp_path / "a" / "out"
    process = subprocess.Popen(command(matrix, disturbed), stderr=subprocess.DEVNULL)
    store = FolderStore(disturbed / "cells")
    wait_for(lambda: store.keys())
    os.kill(wait_for(lambda: workers(process.pid))[0], signal.SIGKILL)
    wait_for(lambda: len(store.keys()) >= 2)
    orphans = workers(process.pid)
    process.kill()
    process.wait()
    wait_for(lambda: not any(Path(f"/proc/{pid}").exists() for pid in orphans))
    kept = store.keys()
    assert 2 <= len(kept) < 4
    assert not (disturbed / "gaps.csv").exists()
    stamps = {k: (disturbed / "cells" / f"{k}.zip").stat().st_mtime_ns for k in kept}
    (disturbed / "cells" / f"{'0' * 32}.zip").write_bytes(b"of a cell that is no longer in the matrix")
    subprocess.run(command(matrix, disturbed), check=True, capture_output=True)
    assert stamps == {k: (disturbed / "cells" / f"{k}.zip").stat().st_mtime_ns for k in kept}, "computed twice"
    undisturbed = tmp_path / "b" / "out"
    subprocess.run(command(matrix, undisturbed), check=True, capture_output=True)
    a, b = content(disturbed), content(undisturbed)
    for files, out in ((a, disturbed), (b, undisturbed)):
        files["manifest.json"] = files["manifest.json"].replace(str(out).encode(), b"OUT")
    assert a == b
    assert len(read_gaps(disturbed / "gaps.csv")["step_rate"].unique()) == 2
    assert json.loads(a["manifest.json"])["failures"] == {}


def test_interrupted_it_ends_at_once_and_goes_on_from_there(matrix: Path, tmp_path: Path) -> None:
    out, temporary = tmp_path / "out", tmp_path / "temporary"
    temporary.mkdir()
    environment = os.environ | {"TMPDIR": str(temporary)}
    process = subprocess.Popen(command(matrix, out), stderr=subprocess.PIPE, text=True, env=environment)
    store = FolderStore(out / "cells")
    wait_for(lambda: store.keys())
    orphans = wait_for(lambda: workers(process.pid))
    for place in map(temporary_folder, orphans):
        assert place.parent == temporary
        (place / "left").touch()  # as one leaves it that is ended in the middle of a file
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=15)
    assert process.returncode == 130
    assert said.splitlines()[-1].startswith("realitygap: interrupted; cells that are done are kept")
    assert "Traceback" not in said
    assert not any(Path(f"/proc/{pid}").exists() for pid in orphans)
    assert not list(temporary.iterdir())
    assert not (out / "gaps.csv").exists()
    kept = store.keys()
    assert 1 <= len(kept) < 4
    stamps = {k: (out / "cells" / f"{k}.zip").stat().st_mtime_ns for k in kept}
    subprocess.run(command(matrix, out), check=True, capture_output=True)
    assert stamps == {k: (out / "cells" / f"{k}.zip").stat().st_mtime_ns for k in kept}, "computed twice"
    assert (read_gaps(out / "gaps.csv")["outcome"] == "ok").all()


def test_a_broken_file_of_a_cell_counts_as_absent(matrix: Path, tmp_path: Path) -> None:
    """Cut off, or with any bit of it turned over."""
    tasks = plan(load_matrix(matrix))[:2]
    store = FolderStore(tmp_path / "cells")
    with local(1) as here:
        here.cells(tasks, str(tmp_path / "cells"), 60.0, lambda *_: None)
    assert len(finished(tasks, store)) == 2
    whole = store.read(tasks[0].key)
    store.write(tasks[0].key, whole[:500])
    assert list(finished(tasks, store)) == [tasks[1].key]
    outcome = read_outcome(whole)
    for place in range(7, len(whole), len(whole) // 200):
        damaged = bytearray(whole)
        damaged[place] ^= 0x10
        try:
            assert read_outcome(bytes(damaged)) == outcome, "a bit that nothing depends on"
        except ValueError:
            continue
