"""Friction in a joint and its gears."""

import numpy as np
from realitygap_engines.law.compiled import compiled


@compiled
def dry_bound(d, speed, motor, transmitted):  # type: ignore[no-untyped-def]
    """The bound of dry friction; the load on the rotor is what it transmitted in the previous step.

    Where friction differs by direction it is the mean of both, and `lean` is half of their difference.
    """
    bound = d.coulomb
    if d.static != d.coulomb:
        bound += (d.static - d.coulomb) * np.exp(-((speed / d.stribeck_velocity) ** d.stribeck_exponent))
    if d.load != 0.0 or d.load_static != 0.0:
        coefficient = d.load
        if d.load_static != 0.0:
            coefficient += d.load_static * np.exp(-((speed / d.load_velocity) ** d.load_exponent))
        bound += coefficient * 0.5 * abs(motor + transmitted)
    return bound


@compiled
def grown(d, speed):  # type: ignore[no-untyped-def]
    """The share of dry friction that is there at a speed, where it grows from rest (`d.onset` above zero)."""
    return np.tanh(speed / d.onset)


@compiled
def creeping(d, speed):  # type: ignore[no-untyped-def]
    """That share over the speed: dry friction that grows from rest is a damping that falls with speed.

    As a damping it is stable for any step, however soon it has grown; that of the speed before the step is half a step
    late, and where a joint creeps steadily exact.
    """
    if speed < 1e-6 * d.onset:
        return 1.0 / d.onset
    return grown(d, speed) / speed


@compiled
def bent(share, moved, over):  # type: ignore[no-untyped-def]
    """The share of dry friction that has built up, with its sign, after a displacement (Dahl 1968).

    ds/dq = (1 - s·sign(dq)) / `over`, whose solution is exact for a displacement to one side.
    """
    side = np.sign(moved)
    return side - (side - share) * np.exp(-abs(moved) / over)


@compiled
def building(d, share, moved):  # type: ignore[no-untyped-def]
    """By how much that share grows over a displacement, per rad or m: its secant, or at rest its tangent."""
    x = abs(moved) / d.presliding
    return (1.0 - share * np.sign(moved)) * (-np.expm1(-x) / x if x > 1e-6 else 1.0) / d.presliding


@compiled
def viscous(d, speed):  # type: ignore[no-untyped-def]
    """The coefficient of viscous friction at a speed; at rest the mean of both directions."""
    if d.viscous_asymmetry == 0.0:
        return d.viscous
    return d.viscous * (1.0 + d.viscous_asymmetry * np.sign(speed))


@compiled
def unevenness(d, turn):  # type: ignore[no-untyped-def]
    """By what dry friction is multiplied at a rotor's angle."""
    if d.friction_ripple == 0.0:
        return 1.0
    return 1.0 + d.friction_ripple * np.sin(d.friction_periods * turn + d.friction_phase)
