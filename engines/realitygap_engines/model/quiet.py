"""Without what another library logs, for as long as it is used and no longer."""

import logging
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
