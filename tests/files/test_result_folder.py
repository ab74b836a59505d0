"""Whatever happens while results are written, a folder shows one state, and nobody else's files are touched."""

import json
import os
import subprocess
import sys
import time
from itertools import count
from pathlib import Path

import pytest
from realitygap.files.result_folder import settle, written_whole
from realitygap.files.unfinished import part_folder, sweep

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
