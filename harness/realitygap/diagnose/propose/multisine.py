"""Multisines: sums of a few sines whose frequencies, phases and sizes are free."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from realitygap.robot.drive import Array

BANDS = {"slow": (0.3, 1.2), "fast": (0.6, 4.0)}
"""Frequencies that are drawn [Hz]: about what a position loop follows, and where it begins not to."""
SINES, PHASES = 5, 3
"""Sines of a multisine, and multisines of each band that are drawn."""
LENGTH, FADE = 3.5, 0.5
"""How long a multisine is, and how it begins and ends [s]."""
SIZE = 0.9
"""Of the range that a joint may use, where its speed allows."""
TURNED, TUNED, SCALED = 0.8, 0.15, 0.3
"""Standard deviations of a variation: of a phase [rad], and of the logarithm of a frequency and of a weight."""
FASTEST = 8.0
"""No sine is faster [Hz]."""


@dataclass(frozen=True)
class Multisine:
    """A sum of sines.

    Attributes:
        frequency: [Hz]. Shape (k,).
        phase: [rad]. Shape (k,).
        weight: of each sine. Shape (k,).
        size: of the whole, as a share of the range.
    """

    frequency: Array
    phase: Array
    weight: Array
    size: float

    def at(self, time: Array) -> Array:
        """The sum, as large as its weights say. Shape (t,)."""
        return np.asarray(np.sin(2 * np.pi * self.frequency * time[:, None] + self.phase) @ self.weight)

    def varied(self, random: np.random.Generator) -> Multisine:
        """Another one near by."""
        k = len(self.frequency)
        return Multisine(
            np.minimum(self.frequency * np.exp(TUNED * random.standard_normal(k)), FASTEST),
            self.phase + TURNED * random.standard_normal(k),
            self.weight * np.exp(SCALED * random.standard_normal(k)),
            float(np.clip(self.size * np.exp(SCALED * random.standard_normal()), 0.05, SIZE)),
        )


def drawn(band: tuple[float, float], random: np.random.Generator) -> Multisine:
    """A multisine of a band: sines of equal speed at equal distances, with random phases."""
    frequency = np.linspace(*band, SINES)
    return Multisine(frequency, random.uniform(0, 2 * np.pi, SINES), 1.0 / frequency, SIZE)
