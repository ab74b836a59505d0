"""Simulations that stay open: what a process simulates next is often the same machine.

To open one takes an engine 0.2 to 10 ms, and PyBullet 34 MB besides, so that a toss of a cube took 38 ms longer in it
and 9 in Drake. To reset it, which is the same to the last bit (a law of `tests/engines`), takes microseconds.
"""

import pickle
from collections.abc import Iterator
from contextlib import contextmanager

import realitygap_engines as engines
from realitygap_engines import Physics, Simulation
from realitygap_engines.model.robot import Model

KEPT = 4
"""Simulations of an engine that are kept open: one at the step rate, one at that of the numerical floors, and two at
the coarser rates that motions are faithful at. With a third rate and one less, three of four simulations opened one
anew. In PyBullet each holds 34 MB."""


class _Kept:
    """How many blocks keep simulations open, and these by engine and machine, the one that was used last at the end."""

    blocks = 0
    simulations: dict[tuple[str, bytes], Simulation] = {}  # noqa: RUF012 (there is one of it)


@contextmanager
def kept_open() -> Iterator[None]:
    """Inside, simulations stay open for the next motion of the same machine; at the end they are closed."""
    _Kept.blocks += 1
    try:
        yield
    finally:
        _Kept.blocks -= 1
        while _Kept.simulations and not _Kept.blocks:
            _Kept.simulations.popitem()[1].close()


@contextmanager
def opened(engine: str, model: Model, physics: Physics) -> Iterator[Simulation]:
    """A simulation of the machine that nobody else uses meanwhile, in whatever state: `reset` it.

    One in which something was raised is not used again.

    Raises:
        Unsupported: where the engine cannot express what the model or the physics ask for.
    """
    key, kept = (engine, pickle.dumps((model, physics))), _Kept.simulations
    simulation = kept.pop(key, None) or engines.load(engine).open(model, physics)
    try:
        yield simulation
    except BaseException:
        simulation.close()
        raise
    if not _Kept.blocks or kept.setdefault(key, simulation) is not simulation:  # another thread was faster
        simulation.close()
    for old in [k for k in list(kept) if k[0] == engine][:-KEPT]:
        stale = kept.pop(old, None)
        if stale is not None:
            stale.close()
