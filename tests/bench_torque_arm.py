"""Two links whose motors are told torques, with what `diagnose` names (synthetic recordings).

    python tests/bench_torque_arm.py [--seed 1] [--way commanded|measured|followed]

Two pendulums of 0.3 and 0.25 m at quasi direct drives: they follow sines by the torques of a stiff controller, are
driven by multisines, and swing freely, in one motion with the second joint held. Friction grows from rest as a
hyperbolic tangent of the speed, by side and with ripples; motors are late by 1.5 ms, torque constants are off, the
second link carries more than the model knows, and the model knows of no friction and no rotors. Angles and speeds come
in steps, at 400 Hz. The robot is simulated by the recorded command, by the measured torque, or followed. What was
planted is printed beside what is named.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from realitygap.trace.trace import Array
from told_torques import Recorded, bench

GRAVITY, RATE, STEP, LASTS = 9.81, 400.0, 2.5e-4, 10.0
LENGTH, CENTRE, MASS, INERTIA = (0.3, 0.25), (0.26, 0.2), (0.55, 0.5), (1.5e-3, 1e-3)
LIMIT = np.array([5.0, 3.0])
ANGLE, SPEED, TORQUE = 0.0004, 0.02, 0.005
"""Steps in which a drive tells its angle [rad], its speed [rad/s] and its torque [N·m]."""
LINK = """<link name="{name}"><inertial><origin xyz="0 0 -{centre}"/><mass value="{mass}"/>
<inertia ixx="{inertia}" iyy="{inertia}" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="{joint}" type="continuous"><parent link="{parent}"/><child link="{name}"/><origin xyz="0 0 -{at}"/>
<axis xyz="0 -1 0"/></joint>"""
JOINTS, NAMES = ("shoulder", "elbow"), ("upper", "lower")
Command = Callable[[float, Array, Array], Array]
"""(time, angles, speeds) -> the torques that are commanded [N·m]. Shape (2,) each."""


def urdf() -> str:
    """The robot as the model knows it."""
    parents, at = ("base", "upper"), (0.0, LENGTH[0])
    links = [
        LINK.format(name=n, joint=j, parent=p, at=a, centre=c, mass=m, inertia=i)
        for n, j, p, a, c, m, i in zip(NAMES, JOINTS, parents, at, CENTRE, MASS, INERTIA, strict=True)
    ]
    return f'<robot name="arm"><link name="base"/>{"".join(links)}</robot>\n'


@dataclass
class Truth:
    """What the machine is like, by joint where it is an array."""

    load: float
    rotor: Array
    dry: Array
    uneven: Array
    viscous: Array
    onset: Array
    ripple: Array
    phase: Array
    constant: Array
    shown: Array

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> "Truth":
        """A machine."""
        return cls(
            load=rng.uniform(0.1, 0.25),
            rotor=rng.uniform(0.003, 0.01, 2),
            dry=rng.uniform(0.08, 0.25, 2),
            uneven=rng.uniform(-0.06, 0.06, 2),
            viscous=rng.uniform(0.01, 0.05, 2),
            onset=rng.uniform(0.02, 0.1, 2),
            ripple=rng.uniform(0.03, 0.08, 2),
            phase=rng.uniform(0.0, 6.0, 2),
            constant=rng.uniform(0.92, 1.02, 2),
            shown=rng.uniform(0.98, 1.02, 2),
        )

    def acceleration(self, angle: Array, speed: Array, torque: Array) -> Array:
        """Of the joints, by the motors' torques: the load sits at the end of the second link. Shape (2,)."""
        side = np.tanh(speed / self.onset)
        dry = self.dry * side * (1.0 + self.uneven * side) * (1.0 + self.ripple * np.sin(8.0 * angle + self.phase))
        masses = (MASS[0], MASS[1], self.load)
        reach, inertia = ((CENTRE[0], 0.0), (LENGTH[0], CENTRE[1]), (LENGTH[0], LENGTH[1])), (*INERTIA, 0.0)
        s, c = np.sin([angle[0], angle.sum()]), np.cos(angle[1])
        whole, forces, twist = np.diag(self.rotor), torque - dry - self.viscous * speed, np.sin(angle[1])
        for m, (a, b), i in zip(masses, reach, inertia, strict=True):
            own, both = (i, 0.0) if b == 0.0 else (0.0, i)
            lower = m * b * b + both
            mixed = lower + m * a * b * c
            whole = whole + np.array([[m * a * a + own + mixed + m * a * b * c, mixed], [mixed, lower]])
            turn = m * a * b * twist
            forces = forces + turn * np.array([2 * speed[0] * speed[1] + speed[1] ** 2, -(speed[0] ** 2)])
            forces = forces - m * GRAVITY * np.array([a * s[0] + b * s[1], b * s[1]])
        return np.asarray(np.linalg.solve(whole, forces))


def followed(size: Array, rate: Array, held: Array) -> Command:
    """Sines, about angles that are held, that a stiff controller follows."""

    def command(time: float, angle: Array, speed: Array) -> Array:
        rise = min(time / 1.0, 1.0)
        wanted, turns = held * rise + rise * size * np.sin(rate * time), rise * size * rate * np.cos(rate * time)
        return np.asarray([60.0, 30.0] * (wanted - angle) + [2.0, 1.0] * (turns - speed))

    return command


def multisine(size: float, seed: int) -> Command:
    """Torques of several frequencies, whatever the arm does."""
    rng = np.random.default_rng(seed)
    rates, phases = rng.uniform(0.6, 12.0, (6, 2)), rng.uniform(0.0, 6.3, (6, 2))
    return lambda time, _angle, _speed: size * np.array([1.0, 0.5]) * np.sin(rates * time + phases).sum(axis=0) / 2.0


def released(_time: float, _angle: Array, _speed: Array) -> Array:
    """No torque."""
    return np.zeros(2)


def elbow_held(_time: float, angle: Array, speed: Array) -> Array:
    """The second joint is held straight, the first swings."""
    return np.array([0.0, -30.0 * angle[1] - 1.0 * speed[1]])


HANGING = (0.0, 0.0)
MOTIONS: tuple[tuple[str, Command, tuple[float, float], str], ...] = (
    ("sines_1", followed(np.array([0.8, 0.7]), np.array([2.1, 3.3]), np.array([0.3, 0.6])), HANGING, "train"),
    ("sines_1_again", followed(np.array([0.8, 0.7]), np.array([2.1, 3.3]), np.array([0.3, 0.6])), HANGING, "train"),
    ("sines_2", followed(np.array([0.4, 0.9]), np.array([5.2, 1.7]), np.array([-0.7, 0.2])), HANGING, "train"),
    ("multisine_1", multisine(1.1, 1), HANGING, "train"),
    ("released_1", released, (1.8, -0.6), "train"),
    ("sines_3", followed(np.array([0.9, 0.5]), np.array([1.3, 4.7]), np.array([-0.4, -0.5])), HANGING, "held_out"),
    ("multisine_2", multisine(1.0, 2), HANGING, "held_out"),
    ("elbow_held", elbow_held, (1.4, 0.0), "held_out"),
)
"""Name, command, angles at the beginning, use."""


def recorded(truth: Truth, command: Command, begin: tuple[float, float], rng: np.random.Generator) -> Array:
    """Time, angles, speeds, commands and torques as the drives tell them, every 2.5 ms. Shape (t, 9)."""
    angle, speed, torque, told, rows = np.array(begin), np.zeros(2), np.zeros(2), np.zeros(2), []
    every = round(1.0 / RATE / STEP)
    for k in range(int(LASTS / STEP)):
        time = k * STEP
        if k % every == 0:
            seen = angle + rng.normal(size=2) * 1e-4, speed + rng.normal(size=2) * 0.02
            told = np.clip(command(time, *seen), -LIMIT, LIMIT)
            shown = truth.shown * torque + rng.normal(size=2) * 0.015
            told_as = [np.round(v / s) * s for v, s in zip((*seen, shown), (ANGLE, SPEED, TORQUE), strict=True)]
            rows.append([time, *told_as[0], *told_as[1], *told, *told_as[2]])
        torque += (truth.constant * told - torque) * STEP / 0.0015
        speed = speed + STEP * truth.acceleration(angle, speed, torque)
        angle = angle + STEP * speed
    return np.array(rows)


def machine(rng: np.random.Generator) -> tuple[Truth, Recorded]:
    """One that is drawn, and its motions."""
    truth = Truth.drawn(rng)
    return truth, ((title, use, recorded(truth, command, begin, rng)) for title, command, begin, use in MOTIONS)


if __name__ == "__main__":
    bench(__doc__, "arm", urdf(), JOINTS, machine)
