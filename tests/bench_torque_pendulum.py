"""A pendulum whose motor is told torques, with what `diagnose` names (synthetic recordings).

    python tests/bench_torque_pendulum.py [--seed 1] [--way commanded|measured|followed]

A kilogram on half a metre at a geared motor of 1.2 N·m, which cannot hold it up: it is swung up by its energy and held,
swings freely, and follows sines and multisines. Friction grows from rest as a hyperbolic tangent of the speed, by side
and with ripples; the motor is late by 2 ms, its torque constant is off, and the model knows of no friction and no
rotor. Positions and speeds come in steps as coarse as such drives tell them, at 200 Hz. The robot is simulated by the
recorded command, by the measured torque, or followed. What was planted is printed beside what is named.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from realitygap.trace.trace import Array
from told_torques import Recorded, bench

MASS, LENGTH, GRAVITY = 0.6, 0.5, 9.81
LIMIT, RATE, STEP = 1.2, 200.0, 2e-4
ANGLE, SPEED, TORQUE = 0.0029, 0.066, 0.0088
"""Steps in which the drive tells its angle [rad], its speed [rad/s] and its torque [N·m]."""
URDF = f"""<robot name="pendulum"><link name="base"/><link name="arm"><inertial><origin xyz="0 0 -{LENGTH}"/>
<mass value="{MASS}"/><inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 -1 0"/></joint></robot>
"""
Command = Callable[[float, float, float], float]
"""(time, angle, speed) -> the torque that is commanded [N·m]."""


@dataclass
class Truth:
    """What the machine is like."""

    mass: float
    rotor: float
    dry: float
    uneven: float
    viscous: float
    onset: float
    ripple: float
    phase: float
    constant: float
    shown: float

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> "Truth":
        """A machine."""
        return cls(
            mass=MASS * rng.uniform(0.98, 1.02),
            rotor=rng.uniform(0.002, 0.012),
            dry=rng.uniform(0.04, 0.12),
            uneven=rng.uniform(-0.06, 0.06),
            viscous=rng.uniform(0.01, 0.05),
            onset=rng.uniform(0.02, 0.08),
            ripple=rng.uniform(0.03, 0.08),
            phase=rng.uniform(0.0, 6.0),
            constant=rng.uniform(0.9, 1.02),
            shown=rng.uniform(0.97, 1.03),
        )

    def acceleration(self, angle: float, speed: float, torque: float) -> float:
        """Of the arm [rad/s²], by the motor's torque."""
        side = np.tanh(speed / self.onset)
        dry = self.dry * side * (1.0 + self.uneven * side) * (1.0 + self.ripple * np.sin(6.0 * angle + self.phase))
        pull = self.mass * GRAVITY * LENGTH * np.sin(angle)
        inertia = self.mass * LENGTH**2 + self.rotor
        return float((torque - pull - dry - self.viscous * speed) / inertia)


def swung_up(push: float, gain: float) -> Command:
    """Energy pumped in, and the arm held where it stands upright."""

    def command(_: float, angle: float, speed: float) -> float:
        off = angle % (2 * np.pi) - np.pi
        if abs(off) < 0.35 and abs(speed) < 3.0:
            return float(-gain * off - 0.12 * gain * speed)
        lacks = 2 * MASS * GRAVITY * LENGTH - (
            0.5 * MASS * LENGTH**2 * speed**2 + MASS * GRAVITY * LENGTH * (1 - np.cos(angle))
        )
        return push * float(np.clip(2.0 * lacks, -1.0, 1.0)) * (1.0 if speed >= 0.0 else -1.0)

    return command


def followed(size: float, rate: float) -> Command:
    """A sine that a stiff controller follows."""

    def command(time: float, angle: float, speed: float) -> float:
        wanted, turns = size * np.sin(rate * time), size * rate * np.cos(rate * time)
        return float(8.0 * (wanted - angle) + 0.5 * (turns - speed))

    return command


def multisine(size: float, seed: int) -> Command:
    """Torques of several frequencies, whatever the arm does."""
    rng = np.random.default_rng(seed)
    rates, phases = rng.uniform(0.6, 9.0, 6), rng.uniform(0.0, 6.3, 6)
    return lambda time, _angle, _speed: float(size * np.sin(rates * time + phases).sum() / 2.0)


def released(_time: float, _angle: float, _speed: float) -> float:
    """No torque."""
    return 0.0


MOTIONS: tuple[tuple[str, Command, float, str], ...] = (
    ("swing_up_1", swung_up(0.7, 9.0), 0.0, "train"),
    ("sine_1", followed(0.9, 3.0), 0.0, "train"),
    ("multisine_1", multisine(0.8, 1), 0.0, "train"),
    ("multisine_1_again", multisine(0.8, 1), 0.0, "train"),
    ("released_1", released, 1.9, "train"),
    ("swing_up_2", swung_up(0.9, 7.0), 0.0, "held_out"),
    ("sine_2", followed(0.5, 6.0), 0.0, "held_out"),
    ("released_2", released, 1.2, "held_out"),
)
"""Name, command, angle at the beginning, use."""


def recorded(truth: Truth, command: Command, begin: float, rng: np.random.Generator) -> Array:
    """Time, angle, speed, command and torque as a drive tells them, every 5 ms. Shape (t, 5)."""
    angle, speed, torque, told, rows = begin, 0.0, 0.0, 0.0, []
    every = round(1.0 / RATE / STEP)
    for k in range(int(10.0 / STEP)):
        time = k * STEP
        if k % every == 0:
            seen = [angle + rng.normal() * 2e-4, speed + rng.normal() * 0.06]
            told = float(np.clip(command(time, seen[0], seen[1]), -LIMIT, LIMIT))
            shown = truth.shown * torque + rng.normal() * 0.02
            steps = (ANGLE, SPEED, TORQUE)
            values = [round(v / s) * s for v, s in zip([*seen, shown], steps, strict=True)]
            rows.append([time + rng.normal() * 5e-6, *values[:2], told, values[2]])
        torque += (truth.constant * told - torque) * STEP / 0.002
        speed += STEP * truth.acceleration(angle, speed, torque)
        angle += STEP * speed
    return np.array(rows)


def machine(rng: np.random.Generator) -> tuple[Truth, Recorded]:
    """One that is drawn, and its motions."""
    truth = Truth.drawn(rng)
    return truth, ((title, use, recorded(truth, command, begin, rng)) for title, command, begin, use in MOTIONS)


if __name__ == "__main__":
    bench(__doc__, "pendulum", URDF, ("hinge",), machine)
