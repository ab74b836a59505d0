"""The command as services start it: without some of the standard streams."""

import subprocess
import sys
from itertools import combinations
from pathlib import Path

import pytest

STREAMS = ("0<&-", "1>&-", "2>&-")


@pytest.mark.parametrize("closed", [c for n in (1, 2, 3) for c in combinations(STREAMS, n)], ids=" ".join)
def test_a_stream_that_is_closed_is_missed_by_nobody(closed: tuple[str, ...]) -> None:
    """PyBullet greets at its import, which is not printed: that needs somewhere to put it."""
    command = f"exec '{sys.executable}' -m realitygap engines {' '.join(closed)}"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert ("mujoco" in done.stdout) == (STREAMS[1] not in closed)


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
