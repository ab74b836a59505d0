"""Simulations that stay open: what a process simulates next is often the same machine.

To open one takes an engine 1 to 45 ms; to reset it, which is the same to the last bit (a law of `tests/engines`), takes
microseconds.
"""

import pickle
from collections.abc import Iterator
from contextlib import contextmanager

import realitygap_engines as engines
from realitygap_engines import Physics, Simulation
from realitygap_engines.model.robot import Model

KEPT = 2
"""Simulations of an engine that a process keeps open: one at the step rate, one at that of the numerical floors. In
PyBullet each holds 34 MB."""

_open: dict[tuple[str, bytes], Simulation] = {}
"""By engine and machine, the one that was used last at the end."""


@contextmanager
def opened(engine: str, model: Model, physics: Physics) -> Iterator[Simulation]:
    """A simulation of the machine that nobody else uses meanwhile, in whatever state: `reset` it.

    One in which something was raised is not used again.

    Raises:
        Unsupported: where the engine cannot express what the model or the physics ask for.
    """
    key = engine, pickle.dumps((model, physics))
    simulation = _open.pop(key, None) or engines.load(engine).open(model, physics)
    try:
        yield simulation
    except BaseException:
        simulation.close()
        raise
    if _open.setdefault(key, simulation) is not simulation:  # another thread was faster
        simulation.close()
    for old in [k for k in list(_open) if k[0] == engine][:-KEPT]:
        stale = _open.pop(old, None)
        if stale is not None:
            stale.close()
