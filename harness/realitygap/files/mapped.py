"""Arrays that lie in files and are mapped from there: every process that needs one reads it, and none has a copy."""

import mmap
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def mapped(path: Path | str) -> Array:
    """An array that was saved in a `.npy` file, to be read."""
    return np.asarray(np.load(path, mmap_mode="r"))


def let_go(value: Array | None) -> None:
    """Give back the memory that holds what was read of a mapped array; what is read again comes from the file.

    An array that lies in memory stays as it is.
    """
    owner: object = value
    while isinstance(owner, np.ndarray):
        if owner.flags.writeable:
            return
        owner = owner.base
    if isinstance(owner, mmap.mmap):
        owner.madvise(mmap.MADV_DONTNEED)
