"""The command as services and shells start it: without some of the standard streams, or where nobody reads them."""

import os
import signal
import subprocess
import sys
from itertools import combinations
from pathlib import Path

import pytest

DEMO = Path(__file__).parents[2] / "scenarios" / "demo"
STREAMS = ("0<&-", "1>&-", "2>&-")


@pytest.mark.parametrize("closed", [c for n in (1, 2, 3) for c in combinations(STREAMS, n)], ids=" ".join)
def test_a_stream_that_is_closed_is_missed_by_nobody(closed: tuple[str, ...]) -> None:
    """PyBullet greets at its import, which is not printed: that needs somewhere to put it."""
    command = f"exec '{sys.executable}' -m realitygap engines {' '.join(closed)}"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert ("mujoco" in done.stdout) == (STREAMS[1] not in closed)


UNREAD = 128 + signal.SIGPIPE


def unread(*arguments: str | Path, errors: bool = False) -> tuple[int, str]:
    """Status of a command whose output nobody reads any more, and what it said on standard error where that is read."""
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-m", "realitygap", *map(str, arguments)]
    said = write if errors else subprocess.PIPE
    done = subprocess.run(command, stdout=write, stderr=said, text=True, timeout=120, check=False)
    os.close(write)
    return done.returncode, done.stderr or ""


@pytest.mark.parametrize("arguments", [["engines"], ["effects", "backlash"], ["--help"], ["bench", "-h"]], ids=" ".join)
def test_output_that_nobody_reads_is_no_failed_check(arguments: list[str]) -> None:
    """The status of shells for a command that a pipe ended, as of `cat`, and not a word."""
    assert unread(*arguments) == (UNREAD, "")


def test_a_run_that_nobody_reads_is_there(tmp_path: Path) -> None:
    status, _ = unread("run", DEMO / "scenario.yaml", "--engine", "mujoco", "--out", tmp_path / "out")
    assert status == UNREAD
    assert (tmp_path / "out" / "report.html").is_file()


def test_an_error_that_nobody_reads_is_one() -> None:
    assert unread("effects", "magic", errors=True)[0] == 2


WRITTEN = """
import os, sys
from realitygap.cli import entry, main
main.main = lambda: (open(sys.argv[1], "w").write("mine"), os.write(1, b"a library's"), os.write(2, b"greeting"))
entry.main()
"""


def test_no_file_gets_what_goes_to_a_stream_that_is_closed(tmp_path: Path) -> None:
    file = tmp_path / "results"
    command = f"exec '{sys.executable}' -c \"$0\" '{file}' 0<&- 1>&- 2>&-"
    assert subprocess.run(["sh", "-c", command, WRITTEN], timeout=60, check=False).returncode == 0
    assert file.read_text() == "mine"
