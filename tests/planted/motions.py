"""Motions that robot teams record: sines, steps, slow triangles, lift and drop. Commands are held between samples."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Array = np.ndarray
Course = Callable[[Array, np.random.Generator], Array]


@dataclass
class Command:
    """Commands at the times when they are sent: time (m,), value (m, n), enabled (m,)."""

    time: Array
    value: Array
    enabled: Array


def _rise(time: Array, length: float = 0.5) -> Array:
    x = np.clip((time - 0.2) / length, 0.0, 1.0)
    return np.asarray(x * x * (3 - 2 * x))


def sine(time: Array, rng: np.random.Generator) -> Array:
    swing = rng.uniform(0.5, 0.9) * np.sin(2 * np.pi * rng.uniform(0.5, 1.2) * (time - 0.2))
    return np.asarray(swing * _rise(time))


def sines(time: Array, rng: np.random.Generator) -> Array:
    frequency = rng.uniform((0.2, 0.7, 1.6, 3.0), (0.5, 1.3, 2.6, 4.5))
    size = np.array([0.5, 0.35, 0.15, 0.06])
    phase = rng.uniform(0, 2 * np.pi, 4)
    total = sum(a * np.sin(2 * np.pi * f * time + p) for a, f, p in zip(size, frequency, phase, strict=True))
    return np.asarray(total * _rise(time))


def steps(time: Array, rng: np.random.Generator) -> Array:
    out = np.zeros_like(time)
    at, goal = 0.3, 0.0
    while at < time[-1]:
        goal = rng.choice([g for g in (-0.9, -0.5, 0.0, 0.45, 0.85) if abs(g - goal) > 0.3])
        out[time >= at] = goal
        at += rng.uniform(0.55, 0.9)
    return out


def triangle(time: Array, rng: np.random.Generator) -> Array:
    period, size = rng.uniform(2.4, 3.6), rng.uniform(0.4, 0.8)
    x = np.maximum(time - 0.3, 0.0) / period + 0.25
    return size * (2 * np.abs(2 * ((x + 0.5) % 1.0) - 1) - 1) * -1.0


def chirp(time: Array, rng: np.random.Generator) -> Array:
    rate = rng.uniform(0.35, 0.6)
    x = np.maximum(time - 0.2, 0.0)
    return rng.uniform(0.3, 0.5) * np.sin(2 * np.pi * (0.3 * x + 0.5 * rate * x**2))


def lift(time: Array, rng: np.random.Generator) -> Array:
    x = np.clip((time - 0.3) / 1.2, 0.0, 1.0)
    return rng.uniform(0.9, 1.3) * (10 * x**3 - 15 * x**4 + 6 * x**5)


MOTIONS: dict[str, Course] = {
    "sine": sine,
    "sines": sines,
    "steps": steps,
    "triangle": triangle,
    "chirp": chirp,
    "lift_and_drop": lift,
}


def command(name: str, n: int, reach: float, rate: float, length: float, seed: int) -> Command:
    """The commands of one motion: `lift_and_drop` switches the servos off after 2.2 s."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(length * rate)) / rate
    value = np.stack([MOTIONS[name](time, rng) for _ in range(n)], axis=1) * reach
    if n > 1:
        value *= np.where(rng.random(n) < 0.5, -1.0, 1.0)
    enabled = np.ones(len(time))
    if name == "lift_and_drop":
        enabled[time >= 2.2] = 0.0
    return Command(time, np.round(value, 6), enabled)
