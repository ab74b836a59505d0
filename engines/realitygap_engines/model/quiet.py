"""Without what another library logs or prints, for as long as it is used and no longer."""

import ctypes
import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def quiet(library: str) -> Iterator[None]:
    """A library's log without anything short of an error that ends the process.

    For a library whose complaints are told here, in a sentence, or that are none; its level is put back afterwards,
    because it belongs to whoever runs the process.
    """
    log = logging.getLogger(library)
    level = log.level
    log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        log.setLevel(level)


@contextmanager
def unprinted(descriptor: int = 1) -> Iterator[None]:
    """Without what a library's compiled code prints: on the standard output (1) or error (2) of the process."""
    buffered = ctypes.CDLL(None)
    sys.stdout.flush()
    buffered.fflush(None)
    kept, sink = os.dup(descriptor), os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, descriptor)
    try:
        yield
    finally:
        buffered.fflush(None)
        os.dup2(kept, descriptor)
        os.close(kept)
        os.close(sink)
