"""The servos of the foreign plant: from the command on the bus to the effort of the motor, and their supply."""

import numba
import numpy as np

DC, PID, CASCADE = 0, 1, 2
BALANCE, ONE_WAY = 0, 1
"""Laws of the supply: the power balance of the list; or each servo behind a diode, on a battery that needs `RECOVERY`
to give way and to recover."""
RECOVERY = 0.02
"""Time constant of a lithium battery's fast double layer, at its quickest [s]."""
FIRMWARE = 1e-3
"""Period of a servo's own control loop [s]: the time over which it takes the derivative of a command."""
NOMINAL_ERROR = 0.1
"""The error at which a gain that changes with the error is the nominal one [rad or m]."""


@numba.njit(cache=True)
def take_commands(drive, state, times, command, enabled, t, begun, h):  # type: ignore[no-untyped-def]
    """The command in force at time t at each joint, with its own delay and profile, and its rate (`feed`)."""
    for j in range(drive.size):
        d, s = drive[j], state[j]
        while s.pointer + 1 < times.size and times[s.pointer + 1] <= t - d.delay:
            s.pointer += 1
        now = command[s.pointer, j]
        s.live = 1 if enabled[s.pointer] > 0 else 0
        if d.profile_speed > 0.0 or d.profile_acceleration > 0.0:
            _profile(d, s, now, h)
        elif now != s.held:
            s.feed = (now - s.held) / FIRMWARE
            s.fresh = t
            s.held = now
        elif t - s.fresh >= FIRMWARE:
            s.feed = 0.0
        _look(d, s, t - begun)


@numba.njit(cache=True)
def _profile(d, s, goal, h):  # type: ignore[no-untyped-def]
    """Towards the goal with bounded speed and acceleration, braking in time to rest there."""
    if s.live == 0:
        s.held, s.feed = goal, 0.0
        return
    way = goal - s.held
    top = d.profile_speed if d.profile_speed > 0.0 else np.inf
    if d.profile_acceleration <= 0.0:
        pace = way / h
        s.feed = min(max(pace, -top), top)
        s.held += h * s.feed
        return
    least = d.profile_acceleration * h
    if abs(way) <= least * h and abs(s.feed) <= 2.0 * least:
        s.held, s.feed = goal, 0.0
        return
    pace = min(np.sqrt(2.0 * d.profile_acceleration * abs(way)), top, abs(way) / h)
    wanted = pace if way > 0.0 else -pace
    s.feed += min(max(wanted - s.feed, -least), least)
    s.held += h * s.feed


@numba.njit(cache=True)
def _look(d, s, t):  # type: ignore[no-untyped-def]
    """Whether a servo of its own rate looks at its error now."""
    s.looks = 1
    if d.rate > 0.0:
        count = np.floor(t * d.rate + d.rate_phase + 1e-9)
        s.looks = 1 if count != s.count else 0
        s.count = count


@numba.njit(cache=True)
def position_error(d, s, reading):  # type: ignore[no-untyped-def]
    """The error as the controller takes it: sampled, cut by protection, less its dead band, bent by its gain law."""
    if d.rate > 0.0:
        if s.looks == 1:
            s.error = s.held - reading
    else:
        s.error = s.held - reading
    error = s.error
    share = d.protection_share if d.protection > 0.0 and abs(error) > d.protection else 1.0
    if d.dead_band > 0.0:
        half = 0.5 * d.dead_band
        error = 0.0 if abs(error) < half else error - np.sign(error) * half
    if d.gain_exponent != 1.0:
        error = np.sign(error) * NOMINAL_ERROR * (abs(error) / NOMINAL_ERROR) ** d.gain_exponent
    return error * share


@numba.njit(cache=True)
def _fading(d, t):  # type: ignore[no-untyped-def]
    """What is left of the torque constant at time t, before the current is known."""
    left = max(0.0, 1.0 - d.heating * max(t, 0.0))
    if d.fading != 0.0:
        left *= 1.0 - d.fading * (1.0 - np.exp(-max(t, 0.0) / d.fading_time))
    return left


@numba.njit(cache=True)
def _saturation(d, torque):  # type: ignore[no-untyped-def]
    """What is left of the torque constant at the current that would give this torque."""
    return 1.0 - d.saturation * min(1.0, (torque / d.saturation_torque) ** 2)


@numba.njit(cache=True)
def supply_voltage(drive, state, speed, sag, law, bus, t, h):  # type: ignore[no-untyped-def]
    """The voltage of the supply that all servos share: what they draw is duty·current, as lossless choppers do."""
    drawn = 0.0
    for j in range(drive.size):
        d, s = drive[j], state[j]
        if d.kind != DC or s.live == 0:
            continue
        duty = min(max(d.gain * s.seen, -d.duty_limit), d.duty_limit)
        part = duty * (duty * bus - d.torque_constant * _fading(d, t) * speed[j]) / d.resistance
        drawn += max(0.0, part) if law == ONE_WAY else part
    lower = max(0.0, drive[0].supply - sag * drawn)
    return bus + h / RECOVERY * (lower - bus) if law == ONE_WAY else 0.5 * (bus + lower)


@numba.njit(cache=True)
def _rate(d, s, rate, h):  # type: ignore[no-untyped-def]
    """The rate of the error as the controller knows it: late, where it is."""
    s.rate = rate if d.derivative_lag == 0.0 else s.rate + (1.0 - np.exp(-h / d.derivative_lag)) * (rate - s.rate)
    return s.rate


@numba.njit(cache=True)
def motor_effort(d, s, w, bus, t, h):  # type: ignore[no-untyped-def]
    """The motor's effort at the output before friction; `w` is the speed of its shaft."""
    if s.live == 0:
        s.integral, s.current, s.rate = 0.0, 0.0, -w
        kt = d.torque_constant * _fading(d, t)
        return -d.braking * kt * kt / d.resistance * w if d.kind == DC else 0.0
    if d.kind == DC:
        duty = min(max(d.gain * s.seen, -d.duty_limit), d.duty_limit)
        kt = d.torque_constant * _fading(d, t)
        torque = kt / d.resistance * (duty * bus - kt * w)
        if d.saturation != 0.0:
            kt *= _saturation(d, torque)
            torque = kt / d.resistance * (duty * bus - kt * w)
    elif d.kind == PID:
        torque = d.kp * s.seen + s.integral + d.kd * _rate(d, s, s.feed - w, h)
        torque = min(max(torque, -d.effort_limit), d.effort_limit)
        if abs(w) >= d.velocity_limit and torque * w > 0.0:
            torque = 0.0
    else:
        torque = d.gain * (d.kv * (d.kp * s.seen + _rate(d, s, -w, h)))
        torque = min(max(torque, -d.effort_limit), d.effort_limit)
    if d.kind != DC and (d.fading != 0.0 or d.saturation != 0.0):  # a drive whose torque loop trusts its constant
        torque *= _fading(d, t) * _saturation(d, torque)
    torque /= 1.0 + d.saturating * abs(torque)
    if d.stall_torque < np.inf:
        sign = 1.0 if torque > 0.0 else -1.0
        bound = max(0.0, d.stall_torque * (1.0 - w * sign / d.no_load_speed))
        torque = min(max(torque, -bound), bound)
    torque = min(max(torque, -d.real_limit), d.real_limit)
    if d.lag > 0.0:
        s.current += (1.0 - np.exp(-h / d.lag)) * (torque - s.current)
        torque = s.current
    if d.kind == PID and abs(torque) < d.effort_limit:
        s.integral += d.ki * s.seen * h
    return torque
