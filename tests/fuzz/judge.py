"""What every command promises for any input, asked of real commands."""

import json
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

LONGEST = 1100
"""Characters of a sentence with the path in it."""
MEMORY = 2048
"""MiB."""
HUNG = (-signal.SIGALRM, -signal.SIGXCPU)
WORKER = ("simulate",)
"""What stands for a worker here: it may die."""


class Zygote:
    """The process that runs commands; see `zygote.py`."""

    def __init__(self) -> None:
        path = Path(__file__).with_name("zygote.py")
        self._process = subprocess.Popen(
            [sys.executable, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )

    def run(self, folder: Path, arguments: list[str]) -> dict[str, Any]:
        """What became of a command that was run in a folder."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps([str(folder), arguments]).encode() + b"\n")
        self._process.stdin.flush()
        found: dict[str, Any] = json.loads(self._process.stdout.readline())
        return found

    def close(self) -> None:
        """End the process."""
        self._process.communicate()


@contextmanager
def zygote() -> Iterator[Zygote]:
    """A zygote for as long as it is needed."""
    started = Zygote()
    try:
        yield started
    finally:
        started.close()


def snapshot(folder: Path) -> dict[str, tuple[int, int]]:
    """Everything in a folder with size and time."""
    return {
        p.relative_to(folder).as_posix(): (p.lstat().st_size, p.lstat().st_mtime_ns) if not p.is_dir() else (0, 0)
        for p in folder.rglob("*")
    }


def judged(process: Zygote, folder: Path, arguments: list[str]) -> dict[str, Any]:
    """Run a command and hold it against the README's table of exit statuses. Returns what became of it."""
    before = snapshot(folder)
    done = process.run(folder, arguments)
    told = (
        f"{' '.join(arguments)}: {done['status']} in {done['seconds']} s, {done['memory']} MiB:\n{done['said'][:3000]}"
    )
    died = done["status"] < 0 and done["status"] != -14 and arguments[0] in WORKER
    assert done["status"] in (0, 1, 2) or died, told
    assert "Traceback" not in done["said"], told
    assert done["memory"] <= MEMORY, told
    if done["status"] == 2 and not (arguments[0] == "check" and "certain: " in done["said"]):
        lines = [line for line in done["said"].splitlines() if line.startswith("realitygap: ")]
        assert len(lines) == 1, told
        assert done["said"].rstrip("\n").endswith(lines[0]), told
        assert len(lines[0]) <= LONGEST, told
        assert "Warning: " not in done["said"], told
        assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f]", lines[0]), told
        assert snapshot(folder) == before, f"written: {snapshot(folder).keys() - before.keys()}\n{told}"
    return done
