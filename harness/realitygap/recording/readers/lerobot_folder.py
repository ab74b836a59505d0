"""The folder of a LeRobot data set: what `meta/` says of its episodes and features, and where their rows lie.

Layouts after huggingface/lerobot: v2.0 and v2.1 keep one Parquet file per episode and their lists as JSON lines, v3.0
keeps many episodes in one file and their list as Parquet.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import pyarrow as pa
import pyarrow.parquet as pq

from realitygap.files.errors import InputError, did_you_mean
from realitygap.files.found import counted, kind_of
from realitygap.files.plain_file import check_plain, read_written
from realitygap.recording.readers.kind import ENOUGH, check_fetched

Found = TypeVar("Found")
SHOWN = 12
"""Episodes that a sentence lists."""


@dataclass(frozen=True)
class EpisodeRows:
    """One episode: its number, the names of its tasks, how many rows it has and the file that holds them."""

    number: int
    tasks: tuple[str, ...]
    length: int
    file: Path


@dataclass(frozen=True)
class DataFolder:
    """What a data set says of itself. `features` are the names of a feature's values, numbers where it has none."""

    path: Path
    version: str
    fps: float
    robot: str
    features: Mapping[str, tuple[str, ...]]
    episodes: tuple[EpisodeRows, ...]

    def episode(self, asked: int | str | None, key: str) -> EpisodeRows:
        """The episode with a number, or the only one with this task.

        Raises:
            InputError: where there is none, or more than one.
        """
        if asked is None:
            if len(self.episodes) == 1:
                return self.episodes[0]
            raise InputError(
                f"{key}: is missing; {self.path} has {len(self.episodes)} episodes; expected a number or a task, of "
                f"{self.listing()}"
            )
        found = [e for e in self.episodes if asked == e.number or asked in e.tasks]
        if len(found) == 1:
            return found[0]
        if found:
            raise InputError(
                f"{key}: {asked!r} is the task of {len(found)} episodes of {self.path}; expected one of the numbers "
                f"{_shortened([str(e.number) for e in found])}"
            )
        tasks = [task for e in self.episodes for task in e.tasks]
        raise InputError(
            f"{key}: {self.path} has no episode {asked!r}; it has {self.listing()}{did_you_mean(str(asked), tasks)}"
        )

    def listing(self) -> str:
        """The episodes with their tasks, for messages to the user."""
        return _shortened([f"{e.number} ({', '.join(e.tasks)})" if e.tasks else str(e.number) for e in self.episodes])

    def rows(self, episode: EpisodeRows, columns: Sequence[str]) -> pa.Table:
        """The rows of an episode, these columns of them.

        Raises:
            InputError: for a file that is missing, cut off or holds fewer rows than `meta/` says.
        """
        file = episode.file
        names = pq_read(file, partial(pq.read_schema, file)).names
        chosen = [name for name in columns if name in names]
        only = [("episode_index", "=", episode.number)] if "episode_index" in names else None
        table: pa.Table = pq_read(file, partial(pq.read_table, file, columns=chosen, filters=only))
        if table.num_rows < max(episode.length, 2):
            raise InputError(
                f"{episode.file}: holds {counted(table.num_rows, 'row')} of episode {episode.number}, expected "
                f"{max(episode.length, 2)} as in meta/; get the whole data set"
            )
        return table


def open_folder(path: Path) -> DataFolder:
    """What a data set's `meta/` says.

    Raises:
        InputError: for a layout that is not known here, or a file of `meta/` that is missing or broken.
    """
    file = path / "meta" / "info.json"
    info = _json(file)
    version = str(info.get("codebase_version", ""))
    number = version.removeprefix("v").split(".")[0]
    if number not in ("2", "3"):
        raise InputError(f"{file}: codebase_version: found {version or 'none'}, expected v2.0, v2.1 or v3.0")
    try:
        features = {
            name: _value_names(f.get("names"), (f.get("shape") or [1])[0])
            for name, f in info["features"].items()
            if f["dtype"] not in ("video", "image", "string")
        }
        fps = float(info["fps"])
        layout, per_chunk = str(info["data_path"]), int(info.get("chunks_size", 1000))
        listed = _parquet_episodes(path) if number == "3" else _json_lines(path / "meta" / "episodes.jsonl")
        episodes = tuple(_episode(path, layout, per_chunk, row) for row in listed)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else str(error)
        raise InputError(f"{file}: is not the description of a LeRobot {version} data set ({what})") from None
    if not episodes:
        raise InputError(f"{path}: the data set has no episodes")
    return DataFolder(path, version, fps, str(info.get("robot_type") or ""), features, episodes)


def pq_read(file: Path, action: Callable[[], Found]) -> Found:
    """What pyarrow returns; whatever it trips over in a broken file is a broken file."""
    check_plain(file)
    try:
        with file.open("rb") as opened:
            check_fetched(file, opened.read(ENOUGH))
        return action()
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError(f"{file}: is missing; expected the rows of the data set: get the whole of it") from None
    except Exception as error:
        what = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{file}: cannot be read ({what}); expected a whole Parquet file: get it again") from None


def _parquet_episodes(path: Path) -> list[dict[str, Any]]:
    files = sorted((path / "meta" / "episodes").rglob("*.parquet"))
    if not files:
        raise InputError(f"{path / 'meta' / 'episodes'}: holds no Parquet file; expected the list of episodes")
    rows: list[dict[str, Any]] = []
    for file in files:
        names = pq_read(file, partial(pq.read_schema, file)).names
        wanted = [n for n in ("episode_index", "tasks", "length", "data/chunk_index", "data/file_index") if n in names]
        rows += pq_read(file, partial(pq.read_table, file, columns=wanted)).to_pylist()
    return sorted(rows, key=lambda row: int(row["episode_index"]))


def _episode(path: Path, layout: str, per_chunk: int, row: Mapping[str, Any]) -> EpisodeRows:
    number = int(row["episode_index"])
    places = {"episode_index": number, "episode_chunk": number // per_chunk}
    if "data/chunk_index" in row:
        places |= {"chunk_index": int(row["data/chunk_index"]), "file_index": int(row["data/file_index"])}
    tasks = row.get("tasks") or []
    named = (tasks,) if isinstance(tasks, str) else tuple(str(task) for task in tasks)
    return EpisodeRows(number, named, int(row.get("length", 0)), path / layout.format(**places))


def _value_names(names: Any, count: int) -> tuple[str, ...]:
    """The names of a feature's values: a list, a mapping to one, or none."""
    while isinstance(names, dict):
        names = next(iter(names.values()), None)
    if names is None or len(names) != count:
        return tuple(str(i) for i in range(count))
    return tuple(str(name) for name in names)


def _json(file: Path) -> dict[str, Any]:
    try:
        found = json.loads(read_written(file))
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: cannot be read ({' '.join(str(error).split())}); expected JSON") from None
    if not isinstance(found, dict):
        raise InputError(f"{file}: holds {kind_of(found)}, expected a mapping of keys")
    return found


def _json_lines(file: Path) -> list[dict[str, Any]]:
    try:
        return [json.loads(line) for line in read_written(file).splitlines() if line.strip()]
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: cannot be read ({' '.join(str(error).split())}); expected lines of JSON") from None


def _shortened(items: Sequence[str]) -> str:
    more = len(items) - SHOWN
    return ", ".join(items[:SHOWN]) + (f" and {more} more" if more > 0 else "")
