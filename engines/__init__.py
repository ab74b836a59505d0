"""Physics engines behind one contract. Adding an engine is one file and one line in `ENGINES`."""

import importlib
import importlib.util
from dataclasses import dataclass

from engines.engine import Capability, Diverged, Engine, Ground, Physics, Simulation, State, Unsupported

__all__ = [
    "ENGINES",
    "Capability",
    "Diverged",
    "Engine",
    "Ground",
    "Physics",
    "Simulation",
    "State",
    "Unsupported",
    "available",
    "load",
]


@dataclass(frozen=True)
class Entry:
    """Where an engine lives: the adapter's module, the package it needs and how to get that."""

    module: str
    package: str
    install: str


ENGINES = {
    "dart": Entry("engines.dart", "dartpy", "pip install dartpy"),
    "drake": Entry("engines.drake", "pydrake", "pip install drake"),
    "mujoco": Entry("engines.mujoco", "mujoco", "pip install mujoco"),
    "pybullet": Entry("engines.pybullet", "pybullet", "pip install pybullet"),
}


def available() -> list[str]:
    """The names of the engines whose package is installed, sorted; nothing is imported."""
    return [name for name, entry in ENGINES.items() if importlib.util.find_spec(entry.package)]


def load(name: str) -> Engine:
    """The engine of that name, imported now.

    Raises:
        KeyError: for a name that is not in `ENGINES`.
        Unsupported: where the engine's package is not installed, with how to install it.
    """
    entry = ENGINES[name]
    if importlib.util.find_spec(entry.package) is None:
        raise Unsupported(f"engine {name} is not installed; install it with: {entry.install}")
    engine: Engine = importlib.import_module(entry.module).ENGINE
    return engine
