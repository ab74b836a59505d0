"""The drive law: what turns commands into joint efforts, compiled, for all joints at once.

One record per joint holds every parameter of servo, friction and transmission, so that an effect is an edit of
numbers and the law itself is one function. Units: rad, N·m (m, N for prismatic joints), V, Ω, A, s.

Numerics: engines are semi-implicit Euler, in which velocities sit half a step before positions. Back-EMF and viscous
friction therefore act on the mean of the velocities before and after the step (second order); where a rotor is too
light for that to be damped they act on the velocity after it.
"""

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NONE, DC, PID, CASCADE = 0, 1, 2, 3
POSITION, DUTY, EFFORT = 0, 1, 2
MEANINGS = {"position": POSITION, "duty": DUTY, "effort": EFFORT}

DRIVE = np.dtype(
    [
        ("kind", np.int64),
        ("meaning", np.int64),  # of the command: position, duty or effort
        ("gain", np.float64),
        ("duty_limit", np.float64),
        ("supply", np.float64),
        ("recorded_supply", np.int64),  # 1: the recorded voltage is used instead of `supply`
        ("torque_constant", np.float64),
        ("resistance", np.float64),
        ("kp", np.float64),
        ("ki", np.float64),
        ("kd", np.float64),
        ("kv", np.float64),
        ("effort_limit", np.float64),
        ("velocity_limit", np.float64),
        ("stall_torque", np.float64),
        ("no_load_speed", np.float64),
        ("sag_resistance", np.float64),
        ("sag_group", np.int64),
        ("heating", np.float64),
        ("offset", np.float64),
        ("armature", np.float64),
        ("coulomb", np.float64),
        ("static", np.float64),
        ("stribeck_velocity", np.float64),
        ("stribeck_exponent", np.float64),
        ("load", np.float64),
        ("load_static", np.float64),
        ("load_velocity", np.float64),
        ("load_exponent", np.float64),
        ("viscous", np.float64),
        ("ripple", np.float64),
        ("ripple_periods", np.float64),
        ("ripple_phase", np.float64),
        ("constant", np.float64),
        ("backlash", np.float64),
        ("stiffness", np.float64),
    ]
)
"""The parameters of one joint's drive."""

STATE = np.dtype(
    [
        ("integral", np.float64),
        ("error", np.float64),
        ("started", np.int64),
        ("velocity", np.float64),  # at the previous step
        ("motor", np.float64),  # motor effort over the previous step
        ("bus", np.float64),  # supply voltage after sag
    ]
)
"""What the drive of one joint remembers from step to step."""


def neutral_drive(n: int) -> NDArray[np.void]:
    """Drives without servo and without friction. Shape (n,) of `DRIVE`."""
    drive = np.zeros(n, DRIVE)
    for name in ("effort_limit", "velocity_limit", "stall_torque", "no_load_speed"):
        drive[name] = np.inf
    for name in ("duty_limit", "resistance", "stribeck_velocity", "load_velocity"):
        drive[name] = 1.0
    for name in ("stribeck_exponent", "load_exponent"):
        drive[name] = 2.0
    return drive


@numba.njit(cache=True)
def _sagged(drive, state, command, q, w, heat, recorded, j):  # type: ignore[no-untyped-def]
    """Supply of joint j after the drop that all servos on its supply cause together: a few fixed-point steps."""
    d = drive[j]
    supply = recorded if d.recorded_supply == 1 else d.supply
    bus = state[j].bus if state[j].bus > 0.0 else supply
    for _ in range(4):
        drawn = 0.0
        for i in range(drive.size):
            o = drive[i]
            if o.sag_group != d.sag_group or o.kind != DC or np.isnan(command[i]):
                continue
            duty = command[i] if o.meaning == DUTY else o.gain * (command[i] - (q[i] - o.offset))
            duty = min(max(duty, -o.duty_limit), o.duty_limit)
            kt = o.torque_constant * (1.0 - o.heating * heat)
            volts = duty * bus
            drawn += max(0.0, volts * (volts - kt * w[i]) / o.resistance / supply)
        bus = 0.5 * (bus + max(supply - d.sag_resistance * drawn, 0.0))
    return bus


@numba.njit(cache=True)
def drive_effort(  # type: ignore[no-untyped-def]
    drive, state, command, q, w, dry, recorded, t, h, effort, damping, friction, motor, emf
):
    """Efforts of all joints for the step that starts at time t.

    Args:
        drive, state: Shape (n,) of `DRIVE` and `STATE`.
        command: Shape (n,); NaN is no command: the servo gives no torque.
        q, w: joint positions and velocities now. Shape (n,).
        dry: dry friction effort of the previous step. Shape (n,).
        recorded: recorded supply voltage now [V].
        t, h: time and length of the step [s].
        effort, damping, friction: written: the three terms of the joint law in `engines.engine`. Shape (n,).
        motor, emf: written: the motor's effort is motor - emf·ω with ω the mean velocity of the step. Shape (n,).
    """
    for j in range(drive.size):
        d = drive[j]
        s = state[j]
        reading = q[j] - d.offset
        torque = 0.0
        back = 0.0
        if d.kind != NONE and not np.isnan(command[j]):
            kt = d.torque_constant * (1.0 - d.heating * t)
            error = command[j] - reading
            if d.meaning == EFFORT:
                torque = min(max(command[j], -d.effort_limit), d.effort_limit)
            elif d.kind == DC:
                duty = command[j] if d.meaning == DUTY else d.gain * error
                duty = min(max(duty, -d.duty_limit), d.duty_limit)
                if d.sag_resistance > 0.0:
                    bus = _sagged(drive, state, command, q, w, t, recorded, j)
                    s.bus = bus
                else:
                    bus = recorded if d.recorded_supply == 1 else d.supply
                torque = kt / d.resistance * duty * bus
                back = kt * kt / d.resistance
            elif d.kind == PID:
                rate = (error - s.error) / h if s.started == 1 else -w[j]
                s.error = error
                s.started = 1
                torque = d.kp * error + s.integral + d.kd * rate
                inside = abs(torque) < d.effort_limit
                torque = min(max(torque, -d.effort_limit), d.effort_limit)
                if inside:  # no wind-up while the limit holds
                    s.integral += d.ki * error * h
                if abs(w[j]) >= d.velocity_limit and torque * w[j] > 0.0:
                    torque = 0.0
            else:
                torque = d.gain * (d.kv * (d.kp * error - w[j]))
                torque = min(max(torque, -d.effort_limit), d.effort_limit)
            if d.stall_torque < np.inf:
                now = torque - back * w[j]
                sign = 1.0 if now > 0.0 else -1.0
                bound = d.stall_torque * max(0.0, 1.0 - w[j] * sign / d.no_load_speed)
                if abs(now) > bound:
                    # on the line the torque is bound(w): its slope is damping, as back-EMF is
                    torque = sign * d.stall_torque if bound > 0.0 else 0.0
                    back = d.stall_torque / d.no_load_speed if bound > 0.0 else 0.0
        else:
            s.started = 0
            s.integral = 0.0
        motor[j] = torque
        emf[j] = back
        # the torque through the gears: half the difference of what drives and what loads the joint
        speed = abs(w[j])
        bound = d.coulomb
        if d.static != d.coulomb:
            bound += (d.static - d.coulomb) * np.exp(-((speed / d.stribeck_velocity) ** d.stribeck_exponent))
        if d.load != 0.0 or d.load_static != 0.0:
            acceleration = (w[j] - s.velocity) / h
            # A·a = motor + load + dry - viscous·w over the previous step gives the load on the joint
            loading = d.armature * acceleration - s.motor - dry[j] + d.viscous * s.velocity
            through = 0.5 * abs(torque - back * w[j] - loading)
            coefficient = d.load
            if d.load_static != 0.0:
                coefficient += d.load_static * np.exp(-((speed / d.load_velocity) ** d.load_exponent))
            bound += coefficient * through
        s.velocity = w[j]
        s.motor = torque - back * w[j]
        friction[j] = bound
        extra = d.constant
        if d.ripple != 0.0:
            extra -= d.ripple * np.sin(d.ripple_periods * q[j] + d.ripple_phase)
        total = back + d.viscous
        half = 0.5 if h * total < d.armature else 1.0
        effort[j] = torque + extra - (1.0 - half) * total * w[j]
        damping[j] = half * total
