"""The matrix on a real Dask cluster: a scheduler and two workers, each a process of its own, one killed mid-run."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from realitygap.files.errors import InputError
from realitygap.matrix.cluster import run_cluster
from realitygap.matrix.matrix import finished
from realitygap.matrix.matrix_file import load_matrix
from realitygap.matrix.plan import plan
from realitygap.matrix.store import FolderStore, open_store
from realitygap.matrix.task import Task

pytest.importorskip("distributed")
DEMO = Path(__file__).parents[2] / "scenarios" / "demo"
QUIET: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


@pytest.fixture
def tasks(tmp_path: Path) -> list[Task]:
    """Six cells of about half a second."""
    path = tmp_path / "matrix.yaml"
    path.write_text(
        f"name: test\nscenarios: {DEMO}/scenario.yaml\nengines: mujoco\nrecordings: chirp_1\nfloors: false\n"
        "axes: {step_rate: [4000, 5000, 6000, 7000, 8000, 9000]}\ntraces: false\n"
    )
    return plan(load_matrix(path))


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """The address of a scheduler, and its two worker processes."""
    address = tmp_path / "scheduler.json"
    common = ["--no-dashboard", "--scheduler-file", str(address)]
    here = {"cwd": tmp_path, **QUIET}
    scheduler = subprocess.Popen(
        [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0", *common], **here
    )
    one = ["--nworkers", "1", "--nthreads", "1", "--no-nanny", "--local-directory", str(tmp_path)]
    command = [sys.executable, "-m", "distributed.cli.dask_worker", *common, *one]
    workers = [subprocess.Popen(command, **here) for _ in range(2)]
    try:
        yield address_of(address), workers
    finally:
        for process in (*workers, scheduler):
            process.kill()
            process.wait()


def address_of(file: Path) -> str:
    wait_for(lambda: file.exists() and file.stat().st_size)
    return str(json.loads(file.read_text())["address"])


def wait_for(what: Callable[[], object], seconds: float = 180.0) -> None:
    end = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < end, "waited too long"
        time.sleep(0.05)


def both_at_work(address: str) -> None:
    from distributed import Client

    with Client(address, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=120)


def test_a_worker_killed_in_the_middle_costs_no_cell(
    tasks: list[Task], cluster: tuple[str, list[subprocess.Popen[bytes]]], tmp_path: Path
) -> None:
    address, workers = cluster
    both_at_work(address)
    store = FolderStore(tmp_path / "cells")
    undone: list[tuple[str, str]] = []

    def done(task: Task, what: str | None) -> None:
        if what:
            undone.append((task.title, what))

    def kill() -> None:
        wait_for(lambda: len(store.keys()) >= 2)
        os.kill(workers[0].pid, signal.SIGKILL)

    killer = threading.Thread(target=kill, daemon=True)
    killer.start()
    run_cluster(tasks, address, str(tmp_path / "cells"), 120.0, done)
    killer.join()
    assert undone == []
    outcomes = finished(tasks, store)
    assert [o.outcome for o in outcomes.values()] == ["ok"] * len(tasks)
    assert workers[0].wait(10) == -signal.SIGKILL


def test_a_scheduler_that_is_not_there_is_one_sentence(
    tasks: list[Task], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("realitygap.matrix.cluster.CONNECT", "1s")
    with pytest.raises(InputError, match=r"--scheduler: tcp://127.0.0.1:9 does not answer .*; expected host:port"):
        run_cluster(tasks, "tcp://127.0.0.1:9", str(tmp_path), 1.0, lambda *_: None)


def test_an_address_that_is_none_is_told_at_once_and_alone(tmp_path: Path) -> None:
    """A client without scheduler waited 40 s to be closed as the interpreter ended, and left a traceback."""
    code = "from realitygap.matrix.cluster import run_cluster; run_cluster([], 'nonsense', '.', 1.0, print)"
    python = [sys.executable, "-c", code]
    said = subprocess.run(python, cwd=tmp_path, capture_output=True, text=True, timeout=35).stderr
    assert said.endswith("nonsense does not answer (missing port number in address 'nonsense'); expected host:port\n")


def test_a_store_at_a_url_is_one_at_a_folder(tmp_path: Path) -> None:
    remote, local = open_store(f"file://{tmp_path}/cells"), open_store(str(tmp_path / "cells"))
    assert remote.keys() == set()
    remote.write("a", b"one")
    remote.write("a", b"two")
    local.write("b", b"three")
    assert remote.keys() == local.keys() == {"a", "b"}
    assert (local.read("a"), remote.read("b")) == (b"two", b"three")
    assert sorted(p.name for p in (tmp_path / "cells").iterdir()) == ["a.zip", "b.zip"]


def test_a_url_that_cannot_be_reached_is_one_sentence() -> None:
    with pytest.raises(InputError, match=r"nowhere://cells: cannot be reached .*; expected a URL that fsspec knows"):
        open_store("nowhere://cells")
    with pytest.raises(InputError, match=r"^file:///proc/a: cannot be reached .*; expected a place that takes files"):
        open_store("file:///proc/a")
