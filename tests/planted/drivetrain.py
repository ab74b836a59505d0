"""The drive train of the foreign plant: servo, friction, transmission, ripple and supply of all joints.

Friction is a bristle model (elasto-plastic, Dupont et al. 2002): a stuck joint is a stiff spring, not a constraint.
Backlash and compliance are two masses with a contact stiffness and damping of their own.
"""

import numba
import numpy as np
from numpy.typing import NDArray

DC, PID, CASCADE = 0, 1, 2
OVER_SUPPLY, ONE_WAY = 0, 1
"""Laws of the supply: power over the nominal voltage, as on the list; power over the bus voltage, each servo behind a
diode, and a battery that needs `RECOVERY` to give way and to recover."""
RECOVERY = 0.02
"""Time constant of a lithium battery's fast double layer, at its quickest [s]."""
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
    # what keeps the laws nearly right: see `imperfections`
    "uneven_direction": 0.0,
    "uneven_angle": 0.0,
    "uneven_periods": 0.0,
    "uneven_phase": 0.0,
    "thinning": 0.0,  # of viscous friction with speed [s/rad]
    "saturation": 0.0,  # of the torque, at `saturation_torque`
    "saturation_torque": 1.0,
    "fading": 0.0,  # of the torque, long after `fading_time` [s]
    "fading_time": 1.0,
    "cable": 0.0,  # largest pull [N·m]
    "cable_rest": 0.0,
    "cable_width": 1.0,
    "stiffening": 0.0,  # of the compliance with the square of its twist [1/rad²]
}
DRIVE = np.dtype([("kind", np.int64), *((name, np.float64) for name in _NUMBERS)])


def drives(n: int) -> NDArray[np.void]:
    """n drives without friction and without effects. Shape (n,) of `DRIVE`."""
    out = np.zeros(n, DRIVE)
    for name, value in _NUMBERS.items():
        out[name] = value
    return out


@numba.njit(cache=True)
def _bristle(d, z, v, q, through, h):
    """Bristle force at sliding speed v and angle q, and the new deflection (backward Euler: stiff at high speed)."""
    speed = abs(v)
    bound = d.coulomb
    if d.static != d.coulomb:
        bound += (d.static - d.coulomb) * np.exp(-((speed / d.stribeck_velocity) ** d.stribeck_exponent))
    if d.load != 0.0 or d.load_static != 0.0:
        share = d.load
        if d.load_static != 0.0:
            share += d.load_static * np.exp(-((speed / d.load_velocity) ** d.load_exponent))
        bound += share * through
    if d.uneven_direction != 0.0 or d.uneven_angle != 0.0:
        side = 1.0 if v > 0.0 else (-1.0 if v < 0.0 else 0.0)
        bound *= 1.0 + d.uneven_direction * side + d.uneven_angle * np.sin(d.uneven_periods * q + d.uneven_phase)
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
def _fading(d, t):
    """What is left of the torque constant at time t, before the current is known."""
    left = max(0.0, 1.0 - d.heating * max(t, 0.0))
    if d.fading != 0.0:
        left *= 1.0 - d.fading * (1.0 - np.exp(-max(t, 0.0) / d.fading_time))
    return left


@numba.njit(cache=True)
def _saturation(d, torque):
    """What is left of the torque constant at the current that would give this torque."""
    return 1.0 - d.saturation * min(1.0, (torque / d.saturation_torque) ** 2)


@numba.njit(cache=True)
def _motor(d, command, reading, w, bus, t, integral, feed):
    """Motor effort before friction, duty, position error, and the torque constant now."""
    error = command - reading
    if d.dead_band > 0.0:
        error = 0.0 if abs(error) < d.dead_band else error - np.sign(error) * d.dead_band
    duty, kt = 0.0, 1.0
    if d.kind == DC:
        duty = min(max(d.gain * error, -d.duty_limit), d.duty_limit)
        kt = d.torque_constant * _fading(d, t)
        torque = kt / d.resistance * (duty * bus - kt * w)
        if d.saturation != 0.0:
            kt *= _saturation(d, torque)
            torque = kt / d.resistance * (duty * bus - kt * w)
    elif d.kind == PID:
        torque = d.kp * error + integral + d.kd * (feed - w)
        torque = min(max(torque, -d.effort_limit), d.effort_limit)
        if abs(w) >= d.velocity_limit and torque * w > 0.0:
            torque = 0.0
    else:
        torque = d.gain * (d.kv * (d.kp * error - w))
        torque = min(max(torque, -d.effort_limit), d.effort_limit)
    if d.kind != DC and (d.fading != 0.0 or d.saturation != 0.0):  # a drive whose torque loop trusts its constant
        torque *= _fading(d, t) * _saturation(d, torque)
    if d.stall_torque < np.inf:
        sign = 1.0 if torque > 0.0 else -1.0
        bound = max(0.0, d.stall_torque * (1.0 - w * sign / d.no_load_speed))
        torque = min(max(torque, -bound), bound)
    return torque, duty, error, kt


@numba.njit(cache=True)
def joint_efforts(
    drive, sag, law, bus, held, feed, live, noise, t, h,
    q, w, rotor, rotor_w, z, integral, through, link_torque, motor, applied,
):  # fmt: skip
    """The effort that each link gets from its joint over one step of length h at time t; returns the supply.

    Joints with two masses move their rotor here. `motor` and `applied` are written, the rest is remembered.
    """
    n = drive.size
    if sag > 0.0:  # all servos on one supply: fixed point, from the last step's voltage
        for _ in range(3 if law == OVER_SUPPLY else 1):
            drawn = 0.0
            for j in range(n):
                d = drive[j]
                if d.kind != DC or not live[j]:
                    continue
                two = d.backlash > 0.0 or d.stiffness > 0.0
                shown = (rotor[j] if d.stiffness > 0.0 else q[j]) - d.offset
                torque, duty, _e, kt = _motor(d, held[j], shown, rotor_w[j] if two else w[j], bus, t, 0.0, 0.0)
                drawn += max(0.0, duty * bus * (torque / kt) / (d.supply if law == OVER_SUPPLY else bus))
            lower = max(0.0, drive[0].supply - sag * drawn)
            bus = 0.5 * (bus + lower) if law == OVER_SUPPLY else bus + h / RECOVERY * (lower - bus)
    for j in range(n):
        d = drive[j]
        loose, soft = d.backlash > 0.0, d.stiffness > 0.0
        speed = rotor_w[j] if loose or soft else w[j]
        shaft = rotor[j] if soft else q[j]
        motor[j] = 0.0
        if live[j]:
            volts = bus if sag > 0.0 else d.supply
            motor[j], _duty, error, _kt = _motor(d, held[j], shaft - d.offset, speed, volts, t, integral[j], feed[j])
            if d.kind == PID and abs(motor[j]) < d.effort_limit:
                integral[j] += d.ki * error * h
        else:
            integral[j] = 0.0
        turn = rotor[j] if loose or soft else q[j]
        ripple = -d.ripple * np.sin(d.ripple_periods * turn + d.ripple_phase)
        extra = d.constant
        if shaft > d.stop:
            extra -= d.stop_stiffness * (shaft - d.stop) + 0.002 * d.stop_stiffness * w[j]
        through[j] += h / 2e-4 * (0.5 * abs(motor[j] + link_torque[j]) - through[j])
        if d.cable != 0.0:
            extra -= d.cable * np.tanh((q[j] - d.cable_rest) / d.cable_width)
        friction, z[j] = _bristle(d, z[j], speed, turn, through[j], h)
        drag = d.viscous * speed
        if d.thinning != 0.0:
            drag *= max(0.5, 1.0 - d.thinning * abs(speed))
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
            rotor_w[j] += h * (motor[j] + ripple - (1.0 - d.output_share) * friction - drag - touch) / d.armature
            rotor[j] += h * rotor_w[j]
            link_torque[j] = touch
        elif soft:
            twist = rotor[j] - q[j]
            spring = d.stiffness * twist * (1.0 + d.stiffening * twist * twist)
            spring += 0.02 * np.sqrt(d.stiffness * d.armature) * (rotor_w[j] - w[j])
            applied[j] = spring + noise[j]
            rotor_w[j] += h * (motor[j] + ripple + extra - friction - drag - spring) / d.armature
            rotor[j] += h * rotor_w[j]
            link_torque[j] = spring
        else:
            applied[j] = motor[j] + ripple + extra + noise[j] - friction - drag
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
