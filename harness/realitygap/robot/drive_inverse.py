"""The drive law backwards: the effort that a motor gives where the motion is known, compiled.

The numbers are those of `robot.drive` and the dry friction is that of `robot.drive_law`; what a servo does with a
command plays no part. Dry friction opposes the motion, and at rest it is not determined by the motion: in place of the
sign of the velocity stands its expected value for a velocity that is known with a standard error, erf(v/(√2·error)).
Where it grows from rest, over an onset, the hyperbolic tangent has the slope at rest that both leave together; where it
builds up over an angle, it follows from the positions.
"""
# mypy: allow-untyped-defs
# (the compiled function takes arrays and numbers only; its callers are typed)

import math

import numpy as np
from realitygap_engines.law.compiled import compiled

from realitygap.robot.law.friction import bent, dry_bound, unevenness, viscous
from realitygap.robot.law.springs import springs

PASSES = 100
"""Friction that grows with the load depends on the effort that it is part of; each pass shrinks the error by half of
its coefficient. A gear with a coefficient of 2 and more locks itself, and no effort moves it."""
CLOSE = 1e-10
"""Relative change of an effort at which the passes end."""


@compiled
def motor_efforts(drive, position, velocity, acceleration, error, load, motor, joint, left):
    """Write the efforts of motors and on joints along a motion.

    Args:
        drive: Shape (n,) of `DRIVE`.
        position: true positions of the joints [rad or m]. Shape (t, n), as all that follows.
        velocity: their rates.
        acceleration: the rates of those.
        error: standard error of the velocities.
        load: what the motion takes behind the drives [N·m or N]: `Simulation.inverse_dynamics`.
        motor: written: of the motor, at the output, before friction.
        joint: written: on the joint, after friction.
        left: written: by how much dry friction could be more or less than that, as the joint is nearly at rest.
    """
    built = np.zeros(len(drive))
    for k in range(len(position)):
        for j in range(len(drive)):
            d, q, v = drive[j], position[k, j], velocity[k, j]
            pull, _ = springs(d, q, v, 1.0, 0.0)
            transmitted = load[k, j] - d.constant - pull
            uneven = unevenness(d, q)
            smooth = transmitted + d.armature * acceleration[k, j]
            if d.ripple != 0.0:
                smooth += d.ripple * np.sin(d.ripple_periods * q + d.ripple_phase)
            side = math.erf(v / (math.sqrt(2.0) * error[k, j])) if error[k, j] > 0.0 else np.sign(v)
            unknown, lean = 1.0 - abs(side), uneven * d.lean
            if d.presliding > 0.0:
                if k > 0:
                    built[j] = bent(built[j], q - position[k - 1, j], d.presliding)
                side = built[j]
            elif d.onset > 0.0:
                blurred = math.hypot(d.onset, math.sqrt(0.5 * math.pi) * error[k, j])
                side = np.tanh(v / blurred)
                unknown *= error[k, j] / blurred
                lean *= abs(side)
            steady = smooth + viscous(d, v) * v - lean
            given = steady
            for _ in range(PASSES):
                found = steady + side * uneven * dry_bound(d, abs(v), given, transmitted)
                change = abs(found - given)
                given = found
                if change <= CLOSE * abs(found):
                    break
            motor[k, j] = given
            left[k, j] = unknown * uneven * dry_bound(d, abs(v), given, transmitted)
            joint[k, j] = smooth
