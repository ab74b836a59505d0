"""A result folder is written whole: until everything is there, what an earlier run left stays as it was."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

MARKS = ("gaps.csv", "manifest.json")
"""What makes a folder a result folder; without them nothing in it is taken for an earlier run's."""
OURS = ("curves/*.js", "traces/*.mcap", "traces/*.parquet", "figures/*.svg", "timings.csv", "report.html", *MARKS)


@contextlib.contextmanager
def written_whole(out: Path) -> Iterator[Path]:
    """A folder to write results into. At the end they take the place of an earlier run's in `out`.

    Where the work fails or is interrupted, `out` is as before. Files that no run has written stay in any case.
    """
    absent = [folder for folder in (out, *out.parents) if not folder.exists()]
    out.mkdir(parents=True, exist_ok=True)
    try:
        with TemporaryDirectory(prefix=".unfinished-", dir=out) as part:  # inside: files are moved, never copied
            yield Path(part)
            _replace(out, Path(part))
    except BaseException:
        for folder in absent:
            with contextlib.suppress(OSError):  # something else was put there meanwhile
                folder.rmdir()
        raise


def _replace(out: Path, part: Path) -> None:
    if all((out / name).is_file() for name in MARKS):
        for file in [f for pattern in OURS for f in out.glob(pattern)]:
            file.unlink()
    for file in sorted(f for f in part.rglob("*") if f.is_file()):
        place = out / file.relative_to(part)
        place.parent.mkdir(exist_ok=True)
        file.replace(place)
