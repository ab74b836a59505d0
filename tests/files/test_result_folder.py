"""Whatever happens while results are written, a folder shows one state, and nobody else's files are touched."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from itertools import count
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

import pytest
from realitygap.files import result_folder
from realitygap.files.interrupted import Interrupted, last, listening
from realitygap.files.result_folder import settle, written_whole
from realitygap.files.unfinished import part_folder, sweep

if TYPE_CHECKING:
    from _typeshed import TraceFunction

WRITER = """
import os, sys
from pathlib import Path
from realitygap.files import result_folder

left = int(sys.argv[3])

def counted(before):
    def call(*args, **kwargs):
        global left
        left -= 1
        if left < 0:
            os.kill(os.getpid(), 9)
        return before(*args, **kwargs)
    return call

with result_folder.written_whole(Path(sys.argv[1])) as part:
    for name in ("gaps.csv", "manifest.json", f"figures/{sys.argv[2]}.svg", f"traces/{sys.argv[2]}.mcap"):
        (part / name).parent.mkdir(exist_ok=True)
        (part / name).write_text('{"scenario": "s"}' if name.endswith(".json") else sys.argv[2])
    for name in ("unlink", "replace", "rename", "rmdir", "mkdir"):
        setattr(Path, name, counted(getattr(Path, name)))
"""
"""Writes a result folder and is killed at its so-manieth change of the disk."""


def written(out: Path, name: str, changes: int = 10**6) -> int:
    return subprocess.run([sys.executable, "-c", WRITER, str(out), name, str(changes)], check=False).returncode


def content(out: Path) -> dict[str, str]:
    files = (p for p in out.rglob("*") if p.is_file() and p.name != "manifest.json")
    return {p.relative_to(out).as_posix(): p.read_text() for p in files}


def state(name: str) -> dict[str, str]:
    return {"gaps.csv": name, f"figures/{name}.svg": name, f"traces/{name}.mcap": name, "figures/mine.svg": "mine"}


def test_killed_at_any_moment_a_folder_shows_the_old_state_or_the_new(tmp_path: Path) -> None:
    seen = set()
    for changes in count():
        out = tmp_path / str(changes)
        assert written(out, "old") == 0
        (out / "figures" / "mine.svg").write_text("mine")
        status = written(out, "new", changes)
        settle(out)
        for part in out.glob(".unfinished-*"):
            os.utime(part, (0, 0))
        sweep(out)
        found = content(out)
        assert found in (state("old"), state("new"))
        seen.add(found["gaps.csv"])
        if status == 0:
            break
        assert written(out, "last") == 0
        assert content(out) == state("last"), "the next run finds everything in order"
        assert not list(out.glob(".*"))
    assert changes > 8
    assert seen == {"old", "new"}


def write_new(out: Path) -> None:
    with written_whole(out) as part:
        (part / "figures").mkdir()
        (part / "figures" / "new.svg").write_text("new")
        (part / "gaps.csv").write_text("new")
        (part / "manifest.json").write_text('{"scenario": "s"}')


def signalled(line: int, work: Callable[[], None]) -> tuple[bool, bool]:
    """Whether work was sent SIGTERM at a line of its files' room, as it counts them, and whether that ended it."""
    left = line

    def look(frame: FrameType, event: str, _: object) -> "TraceFunction | None":
        nonlocal left
        if Path(frame.f_code.co_filename).parent != Path(result_folder.__file__).parent:
            return None
        left -= event == "line"
        if event == "line" and left == 0:
            os.kill(os.getpid(), signal.SIGTERM)
        return look

    before = sys.gettrace()
    with listening():
        try:
            sys.settrace(look)
            work()
        except Interrupted:
            return True, True
        finally:
            sys.settrace(before)
    return left <= 0, False


@pytest.mark.parametrize("there", [True, False], ids=["earlier results", "a new folder"])
def test_told_to_end_at_any_line_a_folder_is_as_before_or_the_work_is_done(there: bool, tmp_path: Path) -> None:
    ends = set()
    for line in count(1):
        out = tmp_path / str(line) / "out"
        if there:
            (out / "figures").mkdir(parents=True)
            (out / "figures" / "old.svg").write_text("old")
            (out / "gaps.csv").write_text("old")
            (out / "manifest.json").write_text('{"files": ["figures/old.svg", "gaps.csv"]}')
        sent, ended = signalled(line, partial(write_new, out))
        state = "old" if ended else "new"
        if ended and not there:
            assert not out.exists()
        else:
            assert content(out) == {"gaps.csv": state, f"figures/{state}.svg": state}
            assert not list(out.glob(".*"))
        ends.add(ended)
        if not sent:
            break
    assert ends == {True, False}
    assert line > 30


def test_where_the_last_work_fails_signals_are_heard_again() -> None:
    def told_to_end() -> None:
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(1)

    with listening():
        with contextlib.suppress(OSError), last():
            raise OSError
        with pytest.raises(Interrupted):
            told_to_end()


def test_a_list_that_somebody_altered_removes_nothing_of_anybody(tmp_path: Path) -> None:
    out, other = tmp_path / "out", tmp_path / "other"
    assert written(out, "old") == 0
    other.mkdir()
    (other / "theirs.js").write_text("theirs")
    (out / "curves").symlink_to(other)
    (out / "notes.txt").write_text("mine")
    listed = [
        "curves/theirs.js",
        "../other/theirs.js",
        str(other / "theirs.js"),
        "notes.txt",
        7,
        "figures/../notes.txt",
    ]
    (out / "manifest.json").write_text(json.dumps({"files": listed}))
    assert written(out, "new") == 0
    assert (other / "theirs.js").read_text() == "theirs"
    assert (out / "notes.txt").read_text() == "mine"


def test_what_somebody_works_at_is_no_leftover(tmp_path: Path) -> None:
    with part_folder(tmp_path) as part:
        os.utime(part, (0, 0))
        sweep(tmp_path)
        assert part.is_dir()
    assert not part.exists()
    left = tmp_path / ".unfinished-left"
    left.mkdir()
    (left / "file").touch()
    sweep(tmp_path)
    assert left.is_dir(), "it is so young that its maker may not hold it yet"
    os.utime(left, (time.time() - 60,) * 2)
    sweep(tmp_path)
    assert not left.exists()


def test_where_the_work_fails_nothing_is_left(tmp_path: Path) -> None:
    def fail(out: Path) -> None:
        with written_whole(out) as part:
            (part / "gaps.csv").touch()
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail(tmp_path / "a" / "b")
    assert not list(tmp_path.iterdir())
