"""The torque of a motor at the output, before friction."""

import numpy as np
from realitygap_engines.law.compiled import compiled

from realitygap.robot.drive import DC, EFFORT, NONE, TORQUE
from realitygap.robot.law.controller import clipped, duty, lag, loops


@compiled
def motor_torque(d, s, command, upcoming, rate, speed, t, h):  # type: ignore[no-untyped-def]
    """The motor's torque as torque - back·speed. `rate` is the encoder's speed, `speed` the rotor's."""
    if d.kind == NONE or np.isnan(command):
        return switched_off(d, s, t)
    torque, back = 0.0, 0.0
    if d.meaning == EFFORT:
        asked = d.gain * command if d.kind == TORQUE else command
        torque = min(max(asked, -d.effort_limit), d.effort_limit)
    elif d.kind == DC:
        kt = d.torque_constant * max(1.0 - d.heating * t, 0.0)
        torque = kt / d.resistance * duty(d, s.error, command) * s.bus
        back = kt * kt / d.resistance
    else:
        torque, back = loops(d, s, command, upcoming, rate, h)
    s.started = 1
    s.goal = command
    if d.saturation > 0.0:
        torque, back = saturated(d, torque, back, speed)
    if d.stall_torque < np.inf:
        torque, back = below_line(d, torque, back, speed)
    if abs(torque - back * speed) > d.real_limit:
        torque, back = clipped(torque, back, speed, d.real_limit)
    if d.lag > 0.0:
        torque, back = lagging(d, s, torque, back, speed, h)
    return torque, back


@compiled
def switched_off(d, s, t):  # type: ignore[no-untyped-def]
    """A servo without a command gives no torque, but for the current that its back-EMF drives through a short circuit.

    With a share of the time in short circuit the mean of that torque is the share of it.
    """
    s.started = 0
    s.integral = 0.0
    s.current, s.aim, s.aim_back = 0.0, 0.0, 0.0
    if d.kind != DC or d.braking == 0.0:
        return 0.0, 0.0
    kt = d.torque_constant * max(1.0 - d.heating * t, 0.0)
    return 0.0, d.braking * kt * kt / d.resistance


@compiled
def below_line(d, torque, back, speed):  # type: ignore[no-untyped-def]
    """torque - back·speed under the line from the stall torque to the speed without load."""
    now = torque - back * speed
    sign = 1.0 if now > 0.0 else -1.0
    bound = d.stall_torque * (1.0 - speed * sign / d.no_load_speed)
    if bound <= 0.0:
        return 0.0, 0.0
    if abs(now) > bound:  # on the line the torque is bound(ω): its slope is damping, as back-EMF is
        return sign * d.stall_torque, d.stall_torque / d.no_load_speed
    return torque, back


@compiled
def saturated(d, torque, back, speed):  # type: ignore[no-untyped-def]
    """torque - back·speed, less what saturation takes of it; its slope over the speed is damping, too."""
    now = torque - back * speed
    left = 1.0 / (1.0 + d.saturation * abs(now))
    back *= left * left
    return left * now + back * speed, back


@compiled
def lagging(d, s, torque, back, speed, h):  # type: ignore[no-untyped-def]
    """The mean over the step of a torque that follows torque - back·speed with a first-order lag.

    Exact for an aim that is constant over the step. What it was at the end of the step before is known only now, with
    the speed. A simulation begins in the steady state.
    """
    kept, early = lag(d.lag, h)
    if s.begun == 1:  # the first step
        s.current = torque - back * speed
    else:
        aim = s.aim - s.aim_back * 0.5 * (s.aim_speed + speed)
        s.current = aim + (s.current - aim) * kept
    s.aim, s.aim_back, s.aim_speed = torque, back, speed
    return early * s.current + (1.0 - early) * torque, (1.0 - early) * back
