"""What lies between rotor and link: nothing, a spring, or backlash."""

import numpy as np
from realitygap_engines.law.compiled import compiled


@compiled
def separate(d):  # type: ignore[no-untyped-def]
    """Whether the rotor moves on its own."""
    return d.armature > 0.0 and (d.backlash > 0.0 or d.stiffness > 0.0)


@compiled
def slowed(momentum, impulse):  # type: ignore[no-untyped-def]
    """A momentum after dry friction of at most this impulse, which stops it if it can."""
    return max(momentum - impulse, 0.0) + min(momentum + impulse, 0.0)


@compiled
def weight(x):  # type: ignore[no-untyped-def]
    """The weight of the velocity after the step, for damping x = h·b/inertia: it makes a free decay exact."""
    if x < 0.05:
        return 0.5 + x / 12.0
    return 1.0 / (1.0 - np.exp(-x)) - 1.0 / x


@compiled
def damper(d, inertia, h):  # type: ignore[no-untyped-def]
    """The weight of the velocities after the step in the damping between rotor and link."""
    link = max(inertia - d.armature, 1e-9)
    return weight(h * d.give_damping * (1.0 / d.armature + 1.0 / link))


@compiled
def coupled(s, base, give, w, h):  # type: ignore[no-untyped-def]
    """Write a torque base + give·(rotor' - w') on the link as effort - damping·w', with the rotor's motion eliminated.

    rotor' and w' are the speeds after the step.
    """
    pushed = s.momentum - h * (base - give * w)
    if abs(pushed) <= h * s.bound:  # the rotor sticks
        s.effort, s.damping = base, give
    else:
        moved = s.momentum - h * s.bound * np.sign(pushed) - h * base
        s.effort = base + give * moved / (s.mass + h * give)
        s.damping = give * s.mass / (s.mass + h * give)


@compiled
def spring(d, s, q, w, inertia, h):  # type: ignore[no-untyped-def]
    """Write the torque of a spring and damper on the link; returns the friction that the engine has to hold there."""
    ratio = h * h * d.stiffness / d.armature
    late = 0.5 + min(0.1, 0.25 * ratio * ratio)
    twist, twisting = s.rotor - q, s.rotor_velocity - w
    # the twist averaged with weights (1 - late)², 2·late·(1 - late), late² is base + give·(rotor' - w')
    base = d.stiffness * (twist - h * (1.0 - late) * (1.0 - late) * twisting)
    give = d.stiffness * h * late * late
    if d.give_damping > 0.0:
        after = damper(d, inertia, h)
        base += d.give_damping * (1.0 - after) * twisting
        give += d.give_damping * after
    coupled(s, base, give, w, h)
    return 0.0


@compiled
def foreseen(d, s, w, inertia, h):  # type: ignore[no-untyped-def]
    """The speed of a link after the step if its rotor lets go: accelerated as before, but for what the rotor gave.

    A rotor that a motor drives on is no reason to hold a link that runs away from it faster. What stops a link at once,
    as the ground, is no acceleration that goes on: a rotor lands where its link's speed before the step says so, too.
    """
    if s.begun < 2:
        return w
    return 2.0 * w - s.velocity - h * s.transmitted / max(inertia - d.armature, 1e-9)


@compiled
def backlash(d, s, q, w, change, inertia, h):  # type: ignore[no-untyped-def]
    """Write the torque on the link across the dead zone; returns the friction that the engine has to hold there.

    `change` is that of the driving torque since the previous step. Within the dead zone there is the grease's damping.
    """
    if s.side * (s.transmitted + change) < 0.0:
        s.side = 0
    s.closing = 0.0
    friction = s.bound
    if s.side == 0:
        base, give = 0.0, 0.0
        if d.give_damping > 0.0:
            late = damper(d, inertia, h)
            base = d.give_damping * (1.0 - late) * (s.rotor_velocity - w)
            give = d.give_damping * late
        free = slowed(s.momentum - h * (base - give * w), h * s.bound) / (s.mass + h * give)
        twist = s.rotor - q
        after, later = twist + h * (free - w), twist + h * (free - foreseen(d, s, w, inertia, h))
        if abs(later) < abs(after):
            after = later
        if abs(after) < 0.5 * d.backlash:
            coupled(s, base, give, w, h)
            return 0.0
        s.side = 1 if after > 0.0 else -1
        gap = 0.5 * s.side * d.backlash - twist
        if s.side * gap > 0.0:  # it lands at the end of this step
            s.closing = gap / h
            s.effort = s.momentum / h - (s.bound * np.sign(s.rotor_velocity) + s.mass / h * s.closing)
            s.damping = s.mass / h
            return 0.0
    s.effort, s.damping = s.momentum / h, s.mass / h  # at an end: rotor' = w'
    return friction
