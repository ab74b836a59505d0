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
- dry friction that builds up over an angle: a spring, whose torque is that of the positions before the step, as in any
  semi-implicit step; beyond what such a step resolves it is that of those after it, as far as damping makes it so.
- backlash: rigid ends. A rotor at an end is an armature of the joint; one on its way to an end lands on it at the end
  of a step, without rebound; one that would have to pull lets go.
"""

import numpy as np
from realitygap_engines.law.compiled import compiled

from realitygap.robot.law.controller import look
from realitygap.robot.law.friction import bent, building, creeping, dry_bound, grown, unevenness, viscous
from realitygap.robot.law.motor import motor_torque
from realitygap.robot.law.springs import springs
from realitygap.robot.law.supply import sag
from realitygap.robot.law.transmission import backlash, separate, slowed, spring, weight


@compiled
def drive_effort(  # type: ignore[no-untyped-def]
    drive, state, command, upcoming, q, w, dry, inertia, recorded, t, h, effort, damping, friction, log
):
    """Efforts of all joints for the step that starts at time t.

    `drive`, `state` and `log` are Shape (n,) of `DRIVE`, `STATE` and `LOG`; the other arrays Shape (n,) too. `command`
    is NaN where there is none: the servo is then off; `upcoming` is the next step's. `q` and `w` are the joints'
    positions and velocities now, `dry` their dry friction effort in the previous step, `inertia` about what each joint
    moves, with its rotor [kg·m² or kg], and `recorded` the recorded supply voltage now [V]. Written are `log` and the
    three terms of the joint law in `engine`: `effort`, `damping` and `friction`.
    """
    sags = False
    for j in range(drive.size):
        settle(drive[j], state[j], q[j], w[j], dry[j], h, log[j])
        look(drive[j], state[j], command[j], upcoming[j], w[j], log[j], recorded, t, h)
        sags |= drive[j].sag_resistance > 0.0
    if sags:
        sag(drive, state, command, t, log)
    for j in range(drive.size):
        d, s = drive[j], state[j]
        speed = log[j].rotor
        rate = w[j] if d.stiffness == 0.0 else speed
        torque, back = motor_torque(d, s, command[j], upcoming[j], rate, speed, t, h)
        log[j].motor = torque
        log[j].emf = back
        turn = s.rotor if separate(d) else q[j]
        uneven = unevenness(d, turn)
        bound = uneven * dry_bound(d, abs(speed), torque - back * speed, s.transmitted)
        lean, drag = uneven * d.lean, viscous(d, speed)
        total = back + drag
        if d.presliding > 0.0:
            lean -= bound * s.bent
            stiffness = bound * building(d, s.bent, h * speed)
            ratio = h * h * stiffness / (d.armature if separate(d) else inertia[j])
            drag += h * stiffness * ratio / (1.0 + ratio)
            total = back + drag
            bound = 0.0
        elif d.onset > 0.0:
            creep = bound * creeping(d, abs(speed))
            drag, total = drag + creep, total + creep
            lean *= grown(d, abs(speed))
            bound = 0.0
        log[j].lean, log[j].drag = lean, drag
        torque += lean
        if d.ripple != 0.0:
            torque -= d.ripple * np.sin(d.ripple_periods * turn + d.ripple_phase)
        if separate(d):
            late = weight(h * total / d.armature)
            s.momentum = d.armature * speed + h * (torque - (1.0 - late) * total * speed)
            s.mass = d.armature + h * late * total
            s.bound = bound
            driven = torque - back * speed
            if d.stiffness > 0.0:
                friction[j] = spring(d, s, q[j], w[j], inertia[j], h)
            else:
                friction[j] = backlash(d, s, q[j], w[j], driven - s.driven, inertia[j], h)
            s.driven = driven
        else:
            late = weight(h * total / inertia[j])
            s.effort = torque - (1.0 - late) * total * w[j]
            s.damping = late * total
            friction[j] = bound
        effort[j] = s.effort + d.constant
        damping[j] = s.damping
        if d.cable_stiffness != 0.0 or d.stop_stiffness != 0.0:
            pull, give = springs(d, q[j], w[j], inertia[j], h)
            effort[j] += pull
            damping[j] += give
        s.velocity = w[j]
        s.begun = 2


@compiled
def arrive(drive, state, q, w, dry, h, log):  # type: ignore[no-untyped-def]
    """Finish the previous step, now that q, w and dry are known: what each joint transmitted and where rotors are.

    Arguments as in `drive_effort`; of `log`, the encoder, rotor and transmitted columns are written.
    """
    for j in range(drive.size):
        settle(drive[j], state[j], q[j], w[j], dry[j], h, log[j])


@compiled
def settle(d, s, q, w, dry, h, logged):  # type: ignore[no-untyped-def]
    """`arrive` of one joint."""
    s.transmitted = s.effort - s.damping * w + dry
    logged.encoder = q
    logged.rotor = w
    if not separate(d):
        s.transmitted -= d.armature * (w - s.velocity) / h
    else:
        if s.begun == 0:
            s.rotor, s.rotor_velocity = q + s.rotor, w  # as far ahead as it is at rest
        elif s.side != 0:
            s.rotor, s.rotor_velocity = q + 0.5 * s.side * d.backlash, w + s.closing
        else:
            s.rotor_velocity = slowed(s.momentum - h * s.transmitted, h * s.bound) / s.mass
            s.rotor += h * s.rotor_velocity
            if d.stiffness == 0.0:  # a link that was faster than foreseen takes the end along
                s.rotor = min(max(s.rotor, q - 0.5 * d.backlash), q + 0.5 * d.backlash)
        logged.rotor = s.rotor_velocity
        if d.stiffness > 0.0:
            logged.encoder = s.rotor
    if d.presliding > 0.0 and s.begun == 2:
        s.bent = bent(s.bent, h * logged.rotor, d.presliding)
    logged.transmitted = s.transmitted
    s.begun = max(s.begun, 1)
