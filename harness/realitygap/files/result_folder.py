"""A result folder is written whole: until everything is there, what an earlier run left stays as it was.

`manifest.json` lists the files that are ours. When new ones are complete, their folder is renamed, which is the moment
at which the new state holds; then they take the place of the old. A run that is killed in between is finished by the
next command that looks at the folder. Whatever the last manifest does not list is somebody else's and stays.
"""

import contextlib
import json
import os
from collections.abc import Iterator
from pathlib import Path

from realitygap.files.interrupted import last
from realitygap.files.own_files import content, own
from realitygap.files.unfinished import UNFINISHED, hold, part_folder
from realitygap.files.whole import made, write_whole

MANIFEST = "manifest.json"
FILES = "files"
"""The key of the manifest under which our files are listed."""
FINISHED = ".finished-"
"""How the name of a folder begins whose files are whole and on their way to their places."""
OURS = (
    *("curves/*.js", "traces/*.mcap", "traces/*.parquet", "figures/*.svg"),
    *("timings.csv", "gaps.csv", "report.html", "missing_effort.json", "missing_effort.yaml"),
)
"""What a run writes. Of a list that somebody altered, nothing else is taken."""


@contextlib.contextmanager
def written_whole(out: Path, keeps: tuple[str, ...] = ()) -> Iterator[Path]:
    """A folder to write results into. At the end they take the place of an earlier run's in `out`.

    Where the work fails or is interrupted, `out` is as before. Files that no run has written stay in any case, and so
    do those of the earlier run that match the patterns in `keeps`.
    """
    with made(out):
        settle(out)
        with part_folder(out) as part:  # inside: files are moved, never copied
            yield part
            with last():
                _finish(out, part, keeps)


def settle(out: Path) -> None:
    """Finish what a run began that was killed while its files moved to their places."""
    for part in sorted(out.glob(f"{FINISHED}*")):
        held = hold(part)
        if held is not None:
            try:
                _replace(out, part)
            finally:
                os.close(held)


def _finish(out: Path, part: Path, keeps: tuple[str, ...]) -> None:
    """The moment from which the new state holds, and what follows from it."""
    new = sorted(f.relative_to(part).as_posix() for f in part.rglob("*") if f.is_file() and f.name != MANIFEST)
    kept = [name for name in _listed(out) if any(Path(name).match(k) for k in keeps) and name not in new]
    manifest = content(part / MANIFEST) or content(out / MANIFEST)
    if manifest:
        text = json.dumps(manifest | {FILES: sorted([*new, *kept])}, indent=1, ensure_ascii=False)
        write_whole(part / MANIFEST, text + "\n")
    for name in new:
        (out / name).parent.mkdir(exist_ok=True)
    _replace(out, part.rename(part.with_name(FINISHED + part.name.removeprefix(UNFINISHED))))


def _replace(out: Path, part: Path) -> None:
    """Put new files in their places; the manifest, which tells which these are, last."""
    if (part / MANIFEST).exists():  # else everything was moved already, or nothing is known of what lies there
        for name in set(_listed(out)) - set(_listed(part)):
            (out / name).unlink(missing_ok=True)
    files = sorted(f for f in part.rglob("*") if f.is_file())
    for file in sorted(files, key=lambda f: f.name == MANIFEST):
        file.replace(out / file.relative_to(part))
    for folder in sorted((f for f in part.rglob("*") if f.is_dir()), reverse=True):
        folder.rmdir()
    part.rmdir()


def _listed(folder: Path) -> list[str]:
    """The files that a folder's manifest lists, as far as they can be ours and lie in it."""
    return own(folder, content(folder / MANIFEST).get(FILES), OURS)
