"""One rigid body from all that is fixed together, and what its inertia must be for any engine to move it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from realitygap_engines.errors import ModelError
from realitygap_engines.model.robot import Array, Link

ROUNDING = 2e-3
"""By how much of the largest moment the other two may fall short of it: three moments that were each rounded to three
digits. What is within is mended, and said."""
SPARE = 1e-9
"""What mended moments have to spare, of the largest, so that no engine's own check finds rounding."""
LEAST = 1e-12
"""Smallest moment, of the largest, that is not just rounding of 0."""
Inertial = tuple[float, Array, Array]
"""Mass [kg], centre of mass (3,) [m], and inertia (3, 3) [kg·m²] about it."""
HEAVIEST, FARTHEST, LARGEST_MOMENT = 1e8, 1e4, 1e12
"""[kg], [m] and [kg·m²] beyond which a number is no machine's: the heaviest vehicles weigh 1.4e7 kg."""
LEAST_MOMENT = 1e-15
"""[kg·m²] MuJoCo's mjMINVAL: no engine here takes less on a link that moves."""


@dataclass(frozen=True)
class FixedBody:
    """A body that is fixed to a link: `com` (3,) [m] in the link's frame, `inertia` (3, 3) [kg·m²] about it, its axes.

    `mass` [kg] is None where the file gives none.
    """

    name: str
    mass: float | None
    com: Array
    inertia: Array


def lump(path: Path, parts: list[FixedBody], *, moves: bool, root: bool) -> tuple[Link, list[str]]:
    """One link from a body and all that is fixed to it (parallel-axis theorem), and sentences on what was mended.

    The link has the first part's name. A link that does not move may have no mass, and gets a stand-in then.

    Raises:
        ModelError: for an inertia that no body has, or that no engine can move.
    """
    names = tuple(part.name for part in parts)
    weighed = [(part, part.mass) for part in parts if part.mass is not None]
    for part, _ in weighed:
        _check(path, part)
    if sum(m for _, m in weighed) <= 0:
        if moves:
            instead = ", or a base that is fixed" if root else ""
            raise ModelError(f"{path}: link {names[0]} moves but has no mass; expected an <inertial> on it{instead}")
        return Link(names[0], 1.0, np.zeros(3), np.eye(3) * 1e-3, (), names), []
    mass, com, inertia = together([(m, part.com, part.inertia) for part, m in weighed])
    notes: list[str] = []
    if moves:
        inertia, notes = _movable(path, names[0], inertia)
    return Link(names[0], mass, com, inertia, (), names), notes


def together(bodies: Sequence[Inertial]) -> Inertial:
    """The body that several are when they are fixed together (parallel-axis theorem); one of negative mass and inertia
    is taken away. Their masses must not cancel.
    """
    mass = sum(m for m, _, _ in bodies)
    com = sum((m * c for m, c, _ in bodies), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for m, c, own in bodies:
        d = c - com
        inertia += own + m * (d @ d * np.eye(3) - np.outer(d, d))
    return mass, com, inertia


def _check(path: Path, part: FixedBody) -> None:
    for what, unit, found, most in (
        ("mass", "kg", part.mass, HEAVIEST),
        ("centre of mass", "m", part.com, FARTHEST),
        ("inertia", "kg·m²", part.inertia, LARGEST_MOMENT),
    ):
        largest = float(np.abs(np.asarray(found, dtype=np.float64)).max())
        if not largest <= most:
            raise ModelError(
                f"{path}: link {part.name}: {what} is {largest:.4g} {unit}, which no machine has; expected at most "
                f"{most:g} {unit}"
            )
    moments = _moments(part.inertia)
    allowed = ROUNDING * max(moments[2], 1e-12)
    if moments[0] < -1e-6 * max(moments[2], 1e-12) or moments[0] + moments[1] < moments[2] - allowed:
        raise ModelError(
            f"{path}: link {part.name} has principal moments of inertia {_listed(moments)} kg·m², which no body has; "
            "expected all to be positive and none larger than the other two together"
        )


def _movable(path: Path, name: str, inertia: Array) -> tuple[Array, list[str]]:
    """The inertia of a moving link, with moments that rounding left too small made fit."""
    moments = _moments(inertia)
    if moments[0] <= max(LEAST * moments[2], LEAST_MOMENT):
        raise ModelError(
            f"{path}: link {name} moves but has principal moments of inertia {_listed(moments)} kg·m²; expected all "
            "three above 0, because no engine can turn a body without inertia (a point mass is a small ball)"
        )
    short = moments[2] * (1 + SPARE) - moments[0] - moments[1]
    if short <= 0:
        return inertia, []
    note = (
        f"link {name}: the moments of inertia {_listed(moments)} kg·m² miss the triangle rule by rounding; all three "
        f"were raised by {short:.2g}"
    )
    return inertia + short * np.eye(3), [note] if short > 2 * SPARE * moments[2] else []


def _moments(inertia: Array) -> Array:
    """The principal moments, rising. Shape (3,)."""
    return np.asarray(np.linalg.eigvalsh(inertia), dtype=np.float64)


def _listed(moments: Array) -> str:
    return ", ".join(f"{max(m, 0.0) if abs(m) < 1e-18 else m:.4g}" for m in moments)
