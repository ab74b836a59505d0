"""Physics engines behind one contract. Adding an engine is one file and one line in `ENGINES`."""

import ctypes.util
import importlib
import importlib.util
from dataclasses import dataclass

from realitygap_engines.engine import (
    GRAVITY,
    Capability,
    Engine,
    Ground,
    Physics,
    Simulation,
    State,
)
from realitygap_engines.errors import Diverged, Failed, ModelError, RealityGapError, Unsupported

__all__ = [
    "ENGINES",
    "GRAVITY",
    "Capability",
    "Diverged",
    "Engine",
    "Failed",
    "Ground",
    "ModelError",
    "Physics",
    "RealityGapError",
    "Simulation",
    "State",
    "Unsupported",
    "available",
    "load",
]


@dataclass(frozen=True)
class Entry:
    """Where an engine lives: the adapter's module, what it needs and how to get that.

    What it needs is a Python package or, where `library` is given, a shared library of the system (without "lib").
    """

    module: str
    package: str
    install: str
    library: str | None = None

    @property
    def installed(self) -> bool:
        """Whether what it needs is there; nothing is imported."""
        if self.library is not None:
            return ctypes.util.find_library(self.library) is not None
        return importlib.util.find_spec(self.package) is not None


ENGINES = {
    "dart": Entry("realitygap_engines.dart", "dartpy", "pip install dartpy"),
    "drake": Entry("realitygap_engines.drake", "pydrake", "pip install drake"),
    "exudyn": Entry("realitygap_engines.exudyn", "exudyn", "pip install exudyn"),
    "mujoco": Entry("realitygap_engines.mujoco", "mujoco", "pip install mujoco"),
    "ode": Entry("realitygap_engines.ode.adapter", "", "apt-get install libode8", library="ode"),
    "pybullet": Entry("realitygap_engines.pybullet", "pybullet", "pip install pybullet"),
    "simbody": Entry("realitygap_engines.simbody", "opensim", "pip install opensim"),
}


def available() -> list[str]:
    """The names of the engines that are installed, sorted; nothing is imported."""
    return [name for name, entry in ENGINES.items() if entry.installed]


def load(name: str) -> Engine:
    """The engine of that name, imported now.

    Raises:
        KeyError: for a name that is not in `ENGINES`.
        Unsupported: where what the engine needs is not installed, with how to install it.
    """
    entry = ENGINES[name]
    if not entry.installed:
        raise Unsupported(f"engine {name} is not installed; install it with: {entry.install}")
    engine: Engine = importlib.import_module(entry.module).ENGINE
    return engine
