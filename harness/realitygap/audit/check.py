"""A check measures one property of one engine as an error; this judges the error against its tolerance."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from realitygap_engines import Diverged, Engine, Failed, Simulation, State, Unsupported
from realitygap_engines.errors import as_its_outcome
from realitygap_engines.model.robot import Array

from realitygap.audit.certificate import Proof, Verdict


@dataclass(frozen=True)
class Check:
    """One property of an engine.

    Attributes:
        property: its name in the certificate.
        measure: the error in `unit`; may raise `Unsupported` or `Diverged`, which are results too.
            So is whatever else the engine raises.
        tolerance: the largest error that passes; infinite for information.
        unit: of the error; "1" for a relative one.
        note: how it is measured.
        capability: the entry of `Engine.capabilities` that this rests on; where its level is "no" an error is declared.
    """

    property: str
    measure: Callable[[Engine], float]
    tolerance: float
    unit: str = "1"
    note: str = ""
    capability: str | None = None

    def row(self, engine: Engine) -> Proof:
        """Measure and judge."""
        note = self.note
        try:
            with as_its_outcome(engine.name):
                measured = self.measure(engine)
        except (Diverged, Failed, Unsupported) as error:
            measured, note = np.inf, str(error)
        verdict: Verdict = "passed" if measured <= self.tolerance else "failed"
        if np.isinf(self.tolerance):
            verdict = "information"
        elif verdict == "failed" and self.capability is not None:
            capability = engine.capabilities()[self.capability]
            if capability.level == "no":
                verdict, note = "declared", capability.how
        return Proof(self.property, engine.name, float(measured), self.tolerance, self.unit, verdict, note)


def read(simulation: Simulation) -> State:
    """The present state."""
    n = len(simulation.model.joints)
    position, velocity = np.zeros(n), np.zeros(n)
    base = np.zeros(13)
    base[3] = 1.0
    simulation.read(position, velocity, base)
    return State(position, velocity, base[:3], base[3:7], base[7:10], base[10:])


def advance(
    simulation: Simulation,
    steps: int = 1,
    *,
    effort: Array | float = 0.0,
    damping: Array | float = 0.0,
    friction: Array | float = 0.0,
) -> State:
    """The state after some steps under constant effort, damping and friction of every joint."""
    n = len(simulation.model.joints)
    given = [np.broadcast_to(np.asarray(x, dtype=float), n).copy() for x in (effort, damping, friction)]
    for _ in range(steps):
        simulation.step(*given)
    return read(simulation)


def speeds(
    simulation: Simulation, steps: int, *, effort: float = 0.0, damping: float = 0.0, friction: float = 0.0
) -> Array:
    """The velocity of the first joint after every step. Shape (steps,)."""
    given = {"effort": effort, "damping": damping, "friction": friction}
    return np.array([advance(simulation, 1, **given).velocity[0] for _ in range(steps)])


def largest(found: Array, expected: Array) -> float:
    """The largest difference relative to the largest entry expected, or to 1 where that is smaller."""
    if np.shape(found) != np.shape(expected) or not np.isfinite(found).all():
        return float(np.inf)
    scale = max(1.0, float(np.abs(expected).max(initial=0.0)))
    return float(np.abs(np.asarray(found) - expected).max(initial=0.0)) / scale
