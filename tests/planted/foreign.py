"""A foreign plant: the robot whose recordings are diagnosed, simulated by nothing that the diagnosis uses.

Own dynamics, own integrator (semi-implicit Euler at 20 µs), own drive train. What the effects mean is DESIGN.md's;
nothing here imports `engines` or `harness`.
"""

from dataclasses import dataclass, field

import numba
import numpy as np
from chain import Array, Chain, inverse_dynamics
from drivetrain import at_rest, joint_efforts
from numpy.typing import NDArray
from servo import BALANCE, take_commands

STEP = 20e-6
EVERY = 10
"""Steps between samples of the dense result."""


@dataclass
class Foreign:
    """The plant: bodies, drives, supply lead.

    Attributes:
        chain: the bodies.
        drive: Shape (n,) of `DRIVE`.
        sag: resistance of the supply that all servos share [Ω].
        sag_law: `servo.BALANCE` or `servo.ONE_WAY`.
        velocity_time, velocity_scale: the reported velocity's low-pass [s] and scale. Shape (n,).
        dropout: joint, start and end [s] of a motor that does not pull; joint -1 is none.
        push: effort [N·m], period [s] and width [s] of a push on each joint. Shape (n, 3).
    """

    chain: Chain
    drive: NDArray[np.void]
    sag: float = 0.0
    sag_law: int = BALANCE
    velocity_time: Array = field(default_factory=lambda: np.zeros(0))
    velocity_scale: Array = field(default_factory=lambda: np.zeros(0))
    dropout: tuple[int, float, float] = (-1, 0.0, 0.0)
    push: Array | None = None

    def __post_init__(self) -> None:
        n = len(self.drive)
        if not len(self.velocity_time):
            self.velocity_time, self.velocity_scale = np.zeros(n), np.ones(n)

    def n(self) -> int:
        return len(self.drive)


@dataclass
class Motion:
    """What the plant did, on a dense clock. Arrays of shape (t, n) but `time`.

    Attributes:
        time: [s] from the first command.
        reading: what the encoder shows before it is quantised.
        velocity: of the encoder's shaft.
        effort: of the motor, at the output before friction.
        link: the link's own angle: differs from the encoder's behind a compliance.
    """

    time: Array
    reading: Array
    velocity: Array
    effort: Array
    link: Array


def simulate(
    plant: Foreign,
    times: Array,
    command: Array,
    enabled: Array,
    start: Array,
    duration: float,
    disturbance: Array | None = None,
    settle: float = 1.5,
    step: float = STEP,
) -> Motion:
    """Hold the first command for `settle` seconds, then play the commands.

    Args:
        plant: what is simulated.
        times: Shape (m,) [s]: when each command reaches the bus; held until the next.
        command: Shape (m, n).
        enabled: Shape (m,): 0 is a servo that is switched off.
        start: joint angles before settling. Shape (n,).
        duration: [s] from the first command.
        disturbance: efforts on a grid of 1 ms, from the beginning of settling. Shape (k, n).
        settle: [s].
        step: [s].
    """
    n = plant.n()
    drive = plant.drive.copy()
    if disturbance is None:
        disturbance = np.zeros((2, n))
    push = np.zeros((n, 3)) if plant.push is None else plant.push
    steps = round((settle + duration) / step)
    room = steps // EVERY + 1
    out = np.zeros((4, room, n))
    joint, off, on = plant.dropout
    _run(
        *plant.chain.arrays(),
        drive,
        at_rest(start.astype(float), command[0]),
        plant.sag,
        plant.sag_law,
        times + settle,
        command,
        enabled,
        disturbance,
        push,
        joint,
        off + settle,
        on + settle,
        start.astype(float).copy(),
        settle,
        step,
        steps,
        out,
    )
    time = np.arange(room, dtype=np.float64) * EVERY * step - settle
    keep = time >= -0.05
    return Motion(time[keep], *(x[keep] for x in out))


@numba.njit(cache=True)
def _solve(M, b, n):  # type: ignore[no-untyped-def]
    """Gaussian elimination without pivoting: M is symmetric and positive definite. Overwrites M and b."""
    for i in range(n):
        for j in range(i + 1, n):
            f = M[j, i] / M[i, i]
            for k in range(i, n):
                M[j, k] -= f * M[i, k]
            b[j] -= f * b[i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            b[i] -= M[i, k] * b[k]
        b[i] /= M[i, i]


@numba.njit(cache=True)
def _run(  # type: ignore[no-untyped-def]
    prismatic, axis, origin, turn, mass, com, inertia, gravity,
    drive, state, sag, law, times, command, enabled, disturbance, push, out_joint, out_off, out_on,
    q, settle, h, steps, out,
):  # fmt: skip
    n = mass.size
    w, noise = np.zeros(n), np.zeros(n)
    R, wrench = np.zeros((n, 3, 3)), np.zeros((n, 6))
    M, bias, column, unit, still = np.zeros((n, n)), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    calm = np.zeros(3)
    bus = drive[0].supply
    for step in range(steps + 1):
        t = step * h
        take_commands(drive, state, times, command, enabled, t, settle, h)
        if out_joint >= 0 and out_off <= t < out_on:
            state[out_joint].live = 0
        place = min(t / 1e-3, disturbance.shape[0] - 1.001)
        cell = int(place)
        for j in range(n):
            noise[j] = disturbance[cell, j] + (place - cell) * (disturbance[cell + 1, j] - disturbance[cell, j])
            if push[j, 1] > 0.0 and t > settle and (t - settle) % push[j, 1] < push[j, 2]:
                noise[j] += push[j, 0]
        if step % EVERY == 0:
            k = step // EVERY
            for j in range(n):
                soft = drive[j].stiffness > 0.0
                out[0, k, j] = (state[j].rotor if soft else q[j]) - drive[j].offset
                out[1, k, j] = state[j].rotor_w if soft else w[j]
                out[3, k, j] = q[j]
        bus = joint_efforts(drive, state, sag, law, bus, noise, t - settle, h, q, w)
        inverse_dynamics(prismatic, axis, origin, turn, mass, com, inertia, gravity, q, w, still, R, wrench, bias)
        for j in range(n):
            if step % EVERY == 0:
                out[2, step // EVERY, j] = state[j].motor
            unit[j] = 1.0
            inverse_dynamics(prismatic, axis, origin, turn, mass, com, inertia, calm, q, still, unit, R, wrench, column)
            unit[j] = 0.0
            for i in range(n):
                M[i, j] = column[i]
            if not (drive[j].backlash > 0.0 or drive[j].stiffness > 0.0):
                M[j, j] += drive[j].armature
            bias[j] = state[j].applied - bias[j]
        _solve(M, bias, n)
        for j in range(n):
            d = drive[j]
            if not (d.backlash > 0.0 or d.stiffness > 0.0):
                state[j].link = state[j].applied - d.armature * bias[j]
            w[j] += h * bias[j]
            q[j] += h * w[j]
