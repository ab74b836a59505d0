"""What a controller asks for: a duty of its motor, or a torque."""

import numpy as np
from realitygap_engines.law.compiled import compiled

from realitygap.robot.drive import DUTY, NONE, PID, SPEED

BAND = 0.05
"""Over this last part of the velocity limit, the torque that accelerates a pid servo falls to zero."""
NOMINAL_ERROR = 0.1
"""Where a gain that changes with the error is the nominal one [rad or m]: amid the errors of servos in motion, 0.02 to
0.4 rad in recordings, so that the size of a gain and the bend of its law are nearly independent."""


@compiled
def look(d, s, command, upcoming, w, logged, recorded, t, h):  # type: ignore[no-untyped-def]
    """Write what a servo knows before it acts: its position error, and the voltage of its supply."""
    if d.kind != NONE:
        rate = w if d.stiffness == 0.0 else logged.rotor  # of the encoder
        s.error = position_error(d, s, command, upcoming, logged.encoder - d.offset, rate, t, h)
    s.bus = recorded if d.recorded_supply == 1 else d.supply


@compiled
def position_error(d, s, command, upcoming, reading, rate, t, h):  # type: ignore[no-untyped-def]
    """The position error as the controller takes it.

    Sampled and held, without what lies in its dead band, bent by its gain law, and cut where protection acts. `rate` is
    the encoder's speed.
    """
    error = command - reading
    if d.servo_rate * h < 1.0:
        error = sampled(d, s, error, command, upcoming, rate, t, h)
    share = d.protection_share if abs(error) > d.protection else 1.0
    if d.dead_band > 0.0:
        error = np.sign(error) * max(abs(error) - d.dead_band, 0.0)
    if d.gain_exponent != 1.0:
        error = np.sign(error) * NOMINAL_ERROR * (abs(error) / NOMINAL_ERROR) ** d.gain_exponent
    return error * share


@compiled
def sampled(d, s, error, command, upcoming, rate, t, h):  # type: ignore[no-untyped-def]
    """The mean over the step of an error that is sampled at `servo_rate` and held.

    A sample within the step is taken at its own time, between the commands of the steps: the result is a continuous
    function of the rate.
    """
    into = np.floor((t + 0.5 * h) * d.servo_rate) / d.servo_rate - (t - 0.5 * h)
    if s.started == 0:
        s.held = error
    elif into > 0.0:
        before, later = s.held, into - 0.5 * h
        other = upcoming if later > 0.0 else s.goal
        rising = 0.0 if np.isnan(other) else abs(later) / h * (other - command)
        s.held = error + rising - rate * later
        return (before * into + s.held * (h - into)) / h
    return s.held


@compiled
def duty(d, error, command):  # type: ignore[no-untyped-def]
    """The part of its supply that a servo gives its motor."""
    asked = command if d.meaning == DUTY else d.gain * error
    return min(max(asked, -d.duty_limit), d.duty_limit)


@compiled
def loops(d, s, command, upcoming, rate, h):  # type: ignore[no-untyped-def]
    """What a pid, cascade or velocity controller gives, as torque - back·rate, within the limits of its joint."""
    if d.kind == PID:
        before = s.goal if s.started == 1 else command
        after = command if np.isnan(upcoming) else upcoming
        torque, back = (d.kp + 0.5 * h * d.ki) * s.error + s.integral, d.kd
        rising = (after - before) / (2.0 * h)
    elif d.kind == SPEED:
        torque, back, rising = d.gain * command, d.gain, 0.0
    else:
        torque, back, rising = d.gain * d.kv * d.kp * s.error, d.gain * d.kv, 0.0
    if d.derivative_lag > 0.0:
        rising, early = differentiated(d, s, rising, rate, h)
        torque, back = torque + back * rising, (1.0 - early) * back
    else:
        torque += back * rising
    inside = abs(torque - back * rate) < d.effort_limit
    if inside:  # no wind-up while the limit holds
        s.integral += d.ki * s.error * h
    else:
        torque, back = clipped(torque, back, rate, d.effort_limit)
    if d.kind == PID and (torque - back * rate) * rate > 0.0 and abs(rate) > (1.0 - BAND) * d.velocity_limit:
        slope = abs(torque - back * rate) / (BAND * d.velocity_limit)
        torque, back = slope * d.velocity_limit * np.sign(rate), slope
        if abs(rate) >= d.velocity_limit:
            torque, back = 0.0, 0.0
    if d.backlash > 0.0:  # the encoder is not on the rotor
        torque, back = torque - back * rate, 0.0
    return torque, back


@compiled
def differentiated(d, s, rising, rate, h):  # type: ignore[no-untyped-def]
    """The mean over the step of rising - rate behind a first-order lag, as known - (1 - early)·rate.

    `rising` is what the controller takes of the command's rate. Exact for a rate that is constant over the step; what
    it was over the step before is known only now. A servo that is switched on begins in the steady state.
    """
    kept, early = lag(d.derivative_lag, h)
    if s.started == 0:
        s.slope = rising - rate
    else:
        aim = s.rising - 0.5 * (s.rate + rate)
        s.slope = aim + (s.slope - aim) * kept
    s.rising, s.rate = rising, rate
    return early * s.slope + (1.0 - early) * rising, early


@compiled
def lag(time, h):  # type: ignore[no-untyped-def]
    """What a first-order lag keeps over a step, and the weight of where it begins in its mean over the step."""
    kept = np.exp(-h / time)
    return kept, (1.0 - kept) * time / h


@compiled
def clipped(torque, back, rate, limit):  # type: ignore[no-untyped-def]
    """torque - back·rate within ±limit. Where damping is what exceeds it, there is less damping, which never rings."""
    sign = 1.0 if torque - back * rate > 0.0 else -1.0
    if sign * torque < limit:
        return torque, (torque - sign * limit) / rate
    return sign * limit, 0.0
