"""The recordings of cells, laid aside in files: every process that needs one maps it, and none gets a copy."""

import io
import pickle
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from realitygap.files.mapped import mapped
from realitygap.files.unfinished import part_folder
from realitygap.matrix.task import Task
from realitygap.trace.trace import Array

LARGE = 1 << 22
"""Bytes of an array from which on it is laid aside."""


class Aside:
    """Tasks whose large arrays lie in files, for the processes of this machine.

    Attributes:
        tasks: the tasks, with arrays that are mapped from there.
    """

    def __init__(self, folder: Path, tasks: Sequence[Task]) -> None:
        files: dict[int, tuple[Path, Array]] = {}
        self._pickled = {task.key: _pickled(task, folder, files) for task in tasks}
        # where nothing is laid aside, the tasks are as they were
        self.tasks: list[Task] = [pickle.loads(self._pickled[t.key]) for t in tasks] if files else list(tasks)

    def pickled(self, task: Task) -> bytes:
        """A task for a process of this machine."""
        return self._pickled[task.key]


@contextmanager
def laid_aside(tasks: Sequence[Task], out: Path) -> Iterator[Aside]:
    """Tasks with their large arrays in files below a folder, for as long as they are worked on."""
    with part_folder(out) as folder:
        aside = Aside(folder, tasks)
        del tasks  # what they hold in memory is not needed any more
        yield aside


class _Pickler(pickle.Pickler):
    def __init__(self, out: io.BytesIO, folder: Path, files: dict[int, tuple[Path, Array]]) -> None:
        super().__init__(out, protocol=pickle.HIGHEST_PROTOCOL)
        self._folder, self._files = folder, files

    def reducer_override(self, value: Any) -> Any:
        """A file in place of a large array; whatever else there is as ever."""
        if type(value) is not np.ndarray or value.nbytes < LARGE:
            return NotImplemented
        if id(value) not in self._files:
            path = self._folder / f"{len(self._files)}.npy"
            np.save(path, value)
            self._files[id(value)] = path, value  # holding the value keeps its id from being given away
        return mapped, (str(self._files[id(value)][0].absolute()),)


def _pickled(task: Task, folder: Path, files: dict[int, tuple[Path, Array]]) -> bytes:
    out = io.BytesIO()
    _Pickler(out, folder, files).dump(task)
    return out.getvalue()
