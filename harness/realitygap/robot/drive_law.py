"""The drive law: what turns commands into joint efforts, compiled, for all joints at once.

Numerics: engines are semi-implicit Euler, in which velocities sit half a step before positions. What depends on speed
(back-EMF, viscous friction, the derivative term of a controller) therefore acts on the mean of the velocities before
and after the step, which is of second order; the weight of the latter grows from 1/2 to 1 as the damping becomes
large for the step (`_weight`), so that nothing rings.

Where backlash or a spring separates the rotor from the link, the rotor is integrated here, together with its
friction, and the engine's joint carries the link alone. Both ends get exactly the same impulse: the torque between
them is affine in the link's velocity after the step, which is what the joint law of `engine` takes, and the
rotor is moved once the engine has told that velocity (`arrive`).

- spring: stiffness·(twist, averaged over the three times around the step), the trapezoidal rule: of second order,
  stable for any stiffness and any link, without numerical damping until the step no longer resolves the rotor;
- backlash: rigid ends. A rotor at an end is an armature of the joint; one on its way to an end lands on it at the end
  of a step, without rebound; one that would have to pull lets go.
"""

import numba
import numpy as np

from realitygap.robot.drive import DC, DUTY, EFFORT, NONE, PID

BAND = 0.05
"""Over this last part of the velocity limit, the torque that accelerates a pid servo falls to zero."""


@numba.njit(cache=True, error_model="numpy")
def drive_effort(  # type: ignore[no-untyped-def]
    drive, state, command, upcoming, q, w, dry, inertia, recorded, t, h, effort, damping, friction, log
):
    """Efforts of all joints for the step that starts at time t.

    `drive`, `state` and `log` are Shape (n,) of `DRIVE`, `STATE` and `LOG`; the other arrays Shape (n,) too. `command`
    is NaN where there is none: the servo then gives no torque; `upcoming` is the next step's. `q` and `w` are the
    joints' positions and velocities now, `dry` their dry friction effort in the previous step, `inertia` about what
    each joint moves, with its rotor [kg·m² or kg], and `recorded` the recorded supply voltage now [V]. Written are
    `log` and the three terms of the joint law in `engine`: `effort`, `damping` and `friction`.
    """
    arrive(drive, state, q, w, dry, h, log)
    _sag(drive, state, command, recorded, t, log)
    for j in range(drive.size):
        d, s = drive[j], state[j]
        speed = log[j].rotor
        rate = w[j] if d.stiffness == 0.0 else speed  # of the encoder
        torque, back = _motor(d, s, command[j], upcoming[j], log[j].encoder - d.offset, rate, speed, t, h)
        log[j].motor = torque
        log[j].emf = back
        bound = _friction(d, abs(speed), torque - back * speed, s.transmitted)
        turn = s.rotor if _separate(d) else q[j]
        if d.ripple != 0.0:
            torque -= d.ripple * np.sin(d.ripple_periods * turn + d.ripple_phase)
        total = back + d.viscous
        if _separate(d):
            late = _weight(h * total / d.armature)
            s.momentum = d.armature * speed + h * (torque - (1.0 - late) * total * speed)
            s.mass = d.armature + h * late * total
            s.bound = bound
            driven = torque - back * speed
            if d.stiffness > 0.0:
                friction[j] = _spring(d, s, q[j], w[j], h)
            else:
                friction[j] = _backlash(d, s, q[j], w[j], driven - s.driven, h)
            s.driven = driven
        else:
            late = _weight(h * total / inertia[j])
            s.effort = torque - (1.0 - late) * total * w[j]
            s.damping = late * total
            friction[j] = bound
        effort[j] = s.effort + d.constant
        damping[j] = s.damping
        s.velocity = w[j]


@numba.njit(cache=True, error_model="numpy")
def arrive(drive, state, q, w, dry, h, log):  # type: ignore[no-untyped-def]
    """Finish the previous step, now that q, w and dry are known: what each joint transmitted and where rotors are.

    Arguments as in `drive_effort`; of `log`, the encoder, rotor and transmitted columns are written.
    """
    for j in range(drive.size):
        d, s = drive[j], state[j]
        s.transmitted = s.effort - s.damping * w[j] + dry[j]
        log[j].encoder = q[j]
        log[j].rotor = w[j]
        if not _separate(d):
            s.transmitted -= d.armature * (w[j] - s.velocity) / h
        else:
            if s.begun == 0:
                s.rotor, s.rotor_velocity = q[j], w[j]
            elif s.side != 0:
                s.rotor, s.rotor_velocity = q[j] + 0.5 * s.side * d.backlash, w[j] + s.closing
            else:
                s.rotor_velocity = _slowed(s.momentum - h * s.transmitted, h * s.bound) / s.mass
                s.rotor += h * s.rotor_velocity
                if d.stiffness == 0.0:  # a link that was faster than foreseen takes the end along
                    s.rotor = min(max(s.rotor, q[j] - 0.5 * d.backlash), q[j] + 0.5 * d.backlash)
            log[j].rotor = s.rotor_velocity
            if d.stiffness > 0.0:
                log[j].encoder = s.rotor
        log[j].transmitted = s.transmitted
        s.begun = 1


@numba.njit(cache=True, error_model="numpy")
def _separate(d):  # type: ignore[no-untyped-def]
    """Whether the rotor moves on its own."""
    return d.armature > 0.0 and (d.backlash > 0.0 or d.stiffness > 0.0)


@numba.njit(cache=True, error_model="numpy")
def _slowed(momentum, impulse):  # type: ignore[no-untyped-def]
    """A momentum after dry friction of at most this impulse, which stops it if it can."""
    return max(momentum - impulse, 0.0) + min(momentum + impulse, 0.0)


@numba.njit(cache=True, error_model="numpy")
def _weight(x):  # type: ignore[no-untyped-def]
    """The weight of the velocity after the step, for damping x = h·b/inertia: it makes a free decay exact."""
    if x < 0.05:
        return 0.5 + x / 12.0
    return 1.0 / (1.0 - np.exp(-x)) - 1.0 / x


@numba.njit(cache=True, error_model="numpy")
def _motor(d, s, command, upcoming, reading, rate, speed, t, h):  # type: ignore[no-untyped-def]
    """The motor's torque as torque - back·speed. `rate` is the encoder's speed, `speed` the rotor's."""
    if d.kind == NONE or np.isnan(command):
        s.started = 0
        s.integral = 0.0
        return 0.0, 0.0
    reading = _seen(d, command, reading)
    error = command - reading
    torque, back = 0.0, 0.0
    if d.meaning == EFFORT:
        torque = min(max(command, -d.effort_limit), d.effort_limit)
    elif d.kind == DC:
        kt = d.torque_constant * max(1.0 - d.heating * t, 0.0)
        torque = kt / d.resistance * _duty(d, command, reading) * s.bus
        back = kt * kt / d.resistance
    else:
        if d.kind == PID:
            before = s.goal if s.started == 1 else command
            after = command if np.isnan(upcoming) else upcoming
            torque, back = (d.kp + 0.5 * h * d.ki) * error + s.integral + d.kd * (after - before) / (2.0 * h), d.kd
        else:
            torque, back = d.gain * d.kv * d.kp * error, d.gain * d.kv
        inside = abs(torque - back * rate) < d.effort_limit
        if inside:  # no wind-up while the limit holds
            s.integral += d.ki * error * h
        else:
            torque, back = _clipped(torque, back, rate, d.effort_limit)
        if d.kind == PID and (torque - back * rate) * rate > 0.0 and abs(rate) > (1.0 - BAND) * d.velocity_limit:
            slope = abs(torque - back * rate) / (BAND * d.velocity_limit)
            torque, back = slope * d.velocity_limit * np.sign(rate), slope
            if abs(rate) >= d.velocity_limit:
                torque, back = 0.0, 0.0
        if d.backlash > 0.0:  # the encoder is not on the rotor
            torque, back = torque - back * rate, 0.0
    s.started = 1
    s.goal = command
    if d.stall_torque < np.inf:
        now = torque - back * speed
        sign = 1.0 if now > 0.0 else -1.0
        bound = d.stall_torque * (1.0 - speed * sign / d.no_load_speed)
        if bound <= 0.0:
            torque, back = 0.0, 0.0
        elif abs(now) > bound:  # on the line the torque is bound(ω): its slope is damping, as back-EMF is
            torque, back = sign * d.stall_torque, d.stall_torque / d.no_load_speed
    return torque, back


@numba.njit(cache=True, error_model="numpy")
def _seen(d, command, reading):  # type: ignore[no-untyped-def]
    """The reading as a controller with a dead band takes it: an error within the band is none."""
    if d.dead_band == 0.0:
        return reading
    error = command - reading
    return command - np.sign(error) * max(abs(error) - d.dead_band, 0.0)


@numba.njit(cache=True, error_model="numpy")
def _duty(d, command, reading):  # type: ignore[no-untyped-def]
    duty = command if d.meaning == DUTY else d.gain * (command - reading)
    return min(max(duty, -d.duty_limit), d.duty_limit)


@numba.njit(cache=True, error_model="numpy")
def _clipped(torque, back, rate, limit):  # type: ignore[no-untyped-def]
    """torque - back·rate within ±limit. Where damping is what exceeds it, there is less damping, which never rings."""
    sign = 1.0 if torque - back * rate > 0.0 else -1.0
    if sign * torque < limit:
        return torque, (torque - sign * limit) / rate
    return sign * limit, 0.0


@numba.njit(cache=True, error_model="numpy")
def _sag(drive, state, command, recorded, t, log):  # type: ignore[no-untyped-def]
    """Every servo's voltage, after the drop that all on its supply cause together.

    bus = supply - R·Σ max(0, volts·current/supply), volts = duty·bus: the right side falls and is concave in the
    bus, so Newton's method from the supply comes down to the one solution.
    """
    for j in range(drive.size):
        d = drive[j]
        supply = recorded if d.recorded_supply == 1 else d.supply
        state[j].bus = supply
        if d.sag_resistance <= 0.0 or d.kind != DC or supply <= 0.0:
            continue
        first = j
        for i in range(j):
            if _shared(drive[i], d):
                first = i
                break
        if first < j:
            state[j].bus = state[first].bus
            continue
        bus = supply
        for _ in range(20):
            drawn, slope = 0.0, 0.0
            for i in range(j, drive.size):
                o = drive[i]
                if not _shared(o, d) or o.meaning == EFFORT or np.isnan(command[i]):
                    continue
                duty = _duty(o, command[i], _seen(o, command[i], log[i].encoder - o.offset))
                induced = o.torque_constant * max(1.0 - o.heating * t, 0.0) * log[i].rotor
                power = duty * bus * (duty * bus - induced) / o.resistance
                if power > 0.0:
                    drawn += power / supply
                    slope += duty * (2.0 * duty * bus - induced) / o.resistance / supply
            change = (supply - d.sag_resistance * drawn - bus) / (1.0 + d.sag_resistance * slope)
            bus += change
            if abs(change) < 1e-12 * supply:
                break
        state[j].bus = bus


@numba.njit(cache=True, error_model="numpy")
def _shared(a, b):  # type: ignore[no-untyped-def]
    """Whether two servos share a supply."""
    same = a.sag_group == b.sag_group and a.sag_resistance == b.sag_resistance and a.kind == DC
    return same and a.supply == b.supply and a.recorded_supply == b.recorded_supply


@numba.njit(cache=True, error_model="numpy")
def _friction(d, speed, motor, transmitted):  # type: ignore[no-untyped-def]
    """The bound of dry friction; the load on the rotor is what it transmitted in the previous step."""
    bound = d.coulomb
    if d.static != d.coulomb:
        bound += (d.static - d.coulomb) * np.exp(-((speed / d.stribeck_velocity) ** d.stribeck_exponent))
    if d.load != 0.0 or d.load_static != 0.0:
        coefficient = d.load
        if d.load_static != 0.0:
            coefficient += d.load_static * np.exp(-((speed / d.load_velocity) ** d.load_exponent))
        bound += coefficient * 0.5 * abs(motor + transmitted)
    return bound


@numba.njit(cache=True, error_model="numpy")
def _spring(d, s, q, w, h):  # type: ignore[no-untyped-def]
    """The spring's torque on the link as s.effort - s.damping·w', with the rotor's motion eliminated."""
    ratio = h * h * d.stiffness / d.armature
    late = 0.5 + min(0.1, 0.25 * ratio * ratio)
    twist, twisting = s.rotor - q, s.rotor_velocity - w
    # the twist averaged with weights (1 - late)², 2·late·(1 - late), late² is base + give·(rotor' - w')
    base = d.stiffness * (twist - h * (1.0 - late) * (1.0 - late) * twisting)
    give = d.stiffness * h * late * late
    pushed = s.momentum - h * (base - give * w)
    if abs(pushed) <= h * s.bound:  # the rotor sticks
        s.effort, s.damping = base, give
    else:
        moved = s.momentum - h * s.bound * np.sign(pushed) - h * base
        s.effort = base + give * moved / (s.mass + h * give)
        s.damping = give * s.mass / (s.mass + h * give)
    return 0.0


@numba.njit(cache=True, error_model="numpy")
def _backlash(d, s, q, w, change, h):  # type: ignore[no-untyped-def]
    """The torque on the link across the dead zone, and the friction that the engine has to hold there.

    `change` is that of the driving torque since the previous step.
    """
    if s.side * (s.transmitted + change) < 0.0:
        s.side = 0
    s.closing = 0.0
    friction = s.bound
    s.effort, s.damping = s.momentum / h, s.mass / h  # at an end: rotor' = w'
    if s.side == 0:
        free = _slowed(s.momentum, h * s.bound) / s.mass
        twist = s.rotor - q
        after = twist + h * (free - w)
        if abs(after) < 0.5 * d.backlash:
            s.effort, s.damping = 0.0, 0.0
            return 0.0
        s.side = 1 if after > 0.0 else -1
        gap = 0.5 * s.side * d.backlash - twist
        if s.side * gap > 0.0:  # it lands at the end of this step
            s.closing = gap / h
            s.effort -= s.bound * np.sign(s.rotor_velocity) + s.damping * s.closing
            friction = 0.0
    return friction
