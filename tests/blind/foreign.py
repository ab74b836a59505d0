"""A foreign plant: the robot whose recordings are diagnosed, simulated by nothing that the diagnosis uses.

Own dynamics, own integrator (semi-implicit Euler at 20 µs), bristle friction (elasto-plastic, Dupont et al. 2002: a
stuck joint is a stiff spring, not a constraint), backlash and compliance as two masses with contact stiffness and
damping of their own. What the effects mean is DESIGN.md's; nothing here imports `engines` or `harness`.
"""

from dataclasses import dataclass, field

import numba
import numpy as np
from chain import Array, Chain, inverse_dynamics
from numpy.typing import NDArray

STEP = 20e-6
EVERY = 10
"""Steps between samples of the dense result."""
DC, PID, CASCADE = 0, 1, 2
FIRMWARE = 1e-3
"""Period of a servo's own control loop [s]: the time over which it takes the derivative of a command."""

_NUMBERS = {
    # servo
    "gain": 0.0,
    "duty_limit": 1.0,
    "supply": 12.0,
    "torque_constant": 1.0,
    "resistance": 1.0,
    "kp": 0.0,
    "ki": 0.0,
    "kd": 0.0,
    "kv": 0.0,
    "effort_limit": np.inf,
    "velocity_limit": np.inf,
    "stall_torque": np.inf,
    "no_load_speed": np.inf,
    "heating": 0.0,
    "dead_band": 0.0,  # of the position error: outside the list of effects
    # sensor
    "offset": 0.0,
    "delay": 0.0,
    # friction: total bound = coulomb + (static - coulomb)·exp(…) + load terms
    "coulomb": 0.0,
    "static": 0.0,
    "stribeck_velocity": 1.0,
    "stribeck_exponent": 2.0,
    "load": 0.0,
    "load_static": 0.0,
    "load_velocity": 1.0,
    "load_exponent": 2.0,
    "viscous": 0.0,
    "bristle": 0.0,  # stiffness of the bristles [N·m/rad]
    "bristle_damping": 0.0,
    # extra torque
    "ripple": 0.0,
    "ripple_periods": 0.0,
    "ripple_phase": 0.0,
    "constant": 0.0,
    "stop": np.inf,  # a joint stop at this angle, above it: outside the list of effects
    "stop_stiffness": 0.0,
    # transmission
    "armature": 0.0,
    "backlash": 0.0,
    "stiffness": 0.0,  # 0: none
    "output_share": 0.2,  # of the friction that sits behind the backlash
}
DRIVE = np.dtype([("kind", np.int64), *((name, np.float64) for name in _NUMBERS)])


def drives(n: int) -> NDArray[np.void]:
    """n drives without friction and without effects. Shape (n,) of `DRIVE`."""
    out = np.zeros(n, DRIVE)
    for name, value in _NUMBERS.items():
        out[name] = value
    return out


@dataclass
class Foreign:
    """The plant: bodies, drives, supply lead.

    Attributes:
        chain: the bodies.
        drive: Shape (n,) of `DRIVE`.
        sag: resistance of the supply that all servos share [Ω].
        velocity_time, velocity_scale: the reported velocity's low-pass [s] and scale. Shape (n,).
        dropout: joint, start and end [s] of a motor that does not pull; joint -1 is none.
        push: effort [N·m], period [s] and width [s] of a push on each joint. Shape (n, 3).
    """

    chain: Chain
    drive: NDArray[np.void]
    sag: float = 0.0
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
        plant.sag,
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
    time = np.arange(room) * EVERY * step - settle
    keep = time >= -0.05
    return Motion(time[keep], *(x[keep] for x in out))


@numba.njit(cache=True)
def _solve(M, b, n):
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
def _bristle(d, z, v, through, h):
    """Bristle force at sliding speed v and the new deflection (backward Euler: stiff at high speed)."""
    speed = abs(v)
    bound = d.coulomb
    if d.static != d.coulomb:
        bound += (d.static - d.coulomb) * np.exp(-((speed / d.stribeck_velocity) ** d.stribeck_exponent))
    if d.load != 0.0 or d.load_static != 0.0:
        share = d.load
        if d.load_static != 0.0:
            share += d.load_static * np.exp(-((speed / d.load_velocity) ** d.load_exponent))
        bound += share * through
    if bound <= 0.0 or d.bristle <= 0.0:
        return 0.0, 0.0
    edge = bound / d.bristle
    plastic = 0.0
    if z * v > 0.0:  # elasto-plastic: no creep below 70 % of break-away
        x = (abs(z) / edge - 0.7) / 0.3
        plastic = 0.0 if x <= 0.0 else (1.0 if x >= 1.0 else x * x * (3.0 - 2.0 * x))
    new = (z + h * v) / (1.0 + h * plastic * speed / edge)
    if abs(new) > edge and z * v <= 0.0:  # the bound fell while the joint came back
        new = edge if new > 0.0 else -edge
    rate = (new - z) / h
    return d.bristle * new + d.bristle_damping * rate, new


@numba.njit(cache=True)
def _motor(d, command, reading, w, bus, t, integral, feed):
    """Motor effort before friction, duty, and position error."""
    error = command - reading
    if d.dead_band > 0.0:
        error = 0.0 if abs(error) < d.dead_band else error - np.sign(error) * d.dead_band
    duty = 0.0
    if d.kind == DC:
        duty = min(max(d.gain * error, -d.duty_limit), d.duty_limit)
        kt = d.torque_constant * max(0.0, 1.0 - d.heating * max(t, 0.0))
        torque = kt / d.resistance * (duty * bus - kt * w)
    elif d.kind == PID:
        torque = d.kp * error + integral + d.kd * (feed - w)
        torque = min(max(torque, -d.effort_limit), d.effort_limit)
        if abs(w) >= d.velocity_limit and torque * w > 0.0:
            torque = 0.0
    else:
        torque = d.gain * (d.kv * (d.kp * error - w))
        torque = min(max(torque, -d.effort_limit), d.effort_limit)
    if d.stall_torque < np.inf:
        sign = 1.0 if torque > 0.0 else -1.0
        bound = max(0.0, d.stall_torque * (1.0 - w * sign / d.no_load_speed))
        torque = min(max(torque, -bound), bound)
    return torque, duty, error


@numba.njit(cache=True)
def joint_efforts(
    drive, sag, bus, held, feed, live, noise, t, h,
    q, w, rotor, rotor_w, z, integral, through, link_torque, motor, applied,
):  # fmt: skip
    """The effort that each link gets from its joint over one step of length h at time t; returns the supply.

    Joints with two masses move their rotor here. `motor` and `applied` are written, the rest is remembered.
    """
    n = drive.size
    if sag > 0.0:  # all servos on one supply: fixed point, from the last step's voltage
        for _ in range(3):
            drawn = 0.0
            for j in range(n):
                d = drive[j]
                if d.kind != DC or not live[j]:
                    continue
                two = d.backlash > 0.0 or d.stiffness > 0.0
                shown = (rotor[j] if d.stiffness > 0.0 else q[j]) - d.offset
                torque, duty, _e = _motor(d, held[j], shown, rotor_w[j] if two else w[j], bus, t, 0.0, 0.0)
                kt = d.torque_constant * max(0.0, 1.0 - d.heating * max(t, 0.0))
                drawn += max(0.0, duty * bus * (torque / kt) / d.supply)
            bus = 0.5 * (bus + max(0.0, drive[0].supply - sag * drawn))
    for j in range(n):
        d = drive[j]
        loose, soft = d.backlash > 0.0, d.stiffness > 0.0
        speed = rotor_w[j] if loose or soft else w[j]
        shaft = rotor[j] if soft else q[j]
        motor[j] = 0.0
        if live[j]:
            volts = bus if sag > 0.0 else d.supply
            motor[j], _duty, error = _motor(d, held[j], shaft - d.offset, speed, volts, t, integral[j], feed[j])
            if d.kind == PID and abs(motor[j]) < d.effort_limit:
                integral[j] += d.ki * error * h
        else:
            integral[j] = 0.0
        extra = d.constant - d.ripple * np.sin(d.ripple_periods * shaft + d.ripple_phase)
        if shaft > d.stop:
            extra -= d.stop_stiffness * (shaft - d.stop) + 0.002 * d.stop_stiffness * w[j]
        through[j] += h / 2e-4 * (0.5 * abs(motor[j] + link_torque[j]) - through[j])
        friction, z[j] = _bristle(d, z[j], speed, through[j], h)
        drag = d.viscous * speed
        if loose:
            gap = rotor[j] - q[j]
            over = gap - min(max(gap, -0.5 * d.backlash), 0.5 * d.backlash)
            touch = 0.0
            if over != 0.0:
                stiff = 4e5 * d.armature  # ω ≈ 630 rad/s at the rotor
                touch = stiff * over + 2.0 * 0.3 * np.sqrt(stiff * d.armature) * (rotor_w[j] - w[j])
                touch = max(touch, 0.0) if over > 0.0 else min(touch, 0.0)
            # a share of the friction sits at the output's bearing, where a smooth law will do
            bound = max(d.static, d.coulomb) + (d.load + d.load_static) * through[j]
            share = d.output_share * bound * np.tanh(w[j] / 2e-3)
            applied[j] = touch + extra + noise[j] - share
            rotor_w[j] += h * (motor[j] - (1.0 - d.output_share) * friction - drag - touch) / d.armature
            rotor[j] += h * rotor_w[j]
            link_torque[j] = touch
        elif soft:
            spring = d.stiffness * (rotor[j] - q[j])
            spring += 0.02 * np.sqrt(d.stiffness * d.armature) * (rotor_w[j] - w[j])
            applied[j] = spring + noise[j]
            rotor_w[j] += h * (motor[j] + extra - friction - drag - spring) / d.armature
            rotor[j] += h * rotor_w[j]
            link_torque[j] = spring
        else:
            applied[j] = motor[j] + extra + noise[j] - friction - drag
    return bus


@numba.njit(cache=True)
def hold_commands(drive, times, command, enabled, t, pointer, held, fresh, feed, live):
    """The command in force at time t for each joint, with its own delay; `feed` is its rate over a firmware period."""
    for j in range(drive.size):
        while pointer[j] + 1 < times.size and times[pointer[j] + 1] <= t - drive[j].delay:
            pointer[j] += 1
        now = command[pointer[j], j]
        live[j] = enabled[pointer[j]] > 0
        if now != held[j]:
            feed[j] = (now - held[j]) / FIRMWARE
            fresh[j] = t
            held[j] = now
        elif t - fresh[j] >= FIRMWARE:
            feed[j] = 0.0


@numba.njit(cache=True)
def _run(
    prismatic, axis, origin, turn, mass, com, inertia, gravity,
    drive, sag, times, command, enabled, disturbance, push, out_joint, out_off, out_on,
    q, settle, h, steps, out,
):  # fmt: skip
    n = mass.size
    w = np.zeros(n)
    rotor, rotor_w = q.copy(), np.zeros(n)  # of joints with two masses
    z, integral, through = np.zeros(n), np.zeros(n), np.zeros(n)
    link_torque = np.zeros(n)  # what the transmission gives to the link
    pointer, live = np.zeros(n, np.int64), np.ones(n, np.bool_)
    held, fresh, feed = command[0].copy(), np.full(n, -1.0), np.zeros(n)
    motor, applied, noise = np.zeros(n), np.zeros(n), np.zeros(n)
    R, wrench = np.zeros((n, 3, 3)), np.zeros((n, 6))
    M, bias, column, unit, still = np.zeros((n, n)), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    calm = np.zeros(3)
    bus = drive[0].supply
    for step in range(steps + 1):
        t = step * h
        hold_commands(drive, times, command, enabled, t, pointer, held, fresh, feed, live)
        if out_joint >= 0 and out_off <= t < out_on:
            live[out_joint] = False
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
                out[0, k, j] = (rotor[j] if soft else q[j]) - drive[j].offset
                out[1, k, j] = rotor_w[j] if soft else w[j]
                out[3, k, j] = q[j]
        bus = joint_efforts(
            drive, sag, bus, held, feed, live, noise, t - settle, h,
            q, w, rotor, rotor_w, z, integral, through, link_torque, motor, applied,
        )  # fmt: skip
        if step % EVERY == 0:
            out[2, step // EVERY] = motor
        inverse_dynamics(prismatic, axis, origin, turn, mass, com, inertia, gravity, q, w, still, R, wrench, bias)
        for j in range(n):
            unit[j] = 1.0
            inverse_dynamics(prismatic, axis, origin, turn, mass, com, inertia, calm, q, still, unit, R, wrench, column)
            unit[j] = 0.0
            for i in range(n):
                M[i, j] = column[i]
            if not (drive[j].backlash > 0.0 or drive[j].stiffness > 0.0):
                M[j, j] += drive[j].armature
            bias[j] = applied[j] - bias[j]
        _solve(M, bias, n)
        for j in range(n):
            d = drive[j]
            if not (d.backlash > 0.0 or d.stiffness > 0.0):
                link_torque[j] = applied[j] - d.armature * bias[j]
            w[j] += h * bias[j]
            q[j] += h * w[j]
