"""The stops of joints over one step: what an engine's own will do, foreseen, or stops where it has none.

A stop keeps the joint from going beyond its limit within the step: v' >= (lower - q)/h, with an impulse that pushes
back only. It is an inertia that stays, beside the joint's own in the matrix of `law.joints`; which stops press is
guessed and corrected as the points of `law.ground` are.
"""
# mypy: allow-untyped-defs
# (compiled into `law.joints`; numba's cache of that file does not see a change made here)

from numba import njit

TOUCH = 1e-4
"""A joint limit nearer than this [rad or m], approached or left slower than this [rad/s or m/s], is touched."""
SHARE, RISE = 0.2, 0.1
"""What is beyond a limit, or below the ground, gets this share of the way back in a step, no faster than this [m/s or
rad/s]: nothing is thrown back."""


@njit(cache=True)
def foresee(position, velocity, limits, firm, matrix, right):
    """Add what an engine's own stops will do to `matrix` and `right`."""
    first = len(right) - len(position)
    for i in range(len(position)):
        rate = velocity[i]
        if position[i] - limits[i, 0] < TOUCH and rate < TOUCH:
            matrix[first + i, first + i] += firm
            right[first + i] -= firm * min(rate, 0.0)
        elif limits[i, 1] - position[i] < TOUCH and rate > -TOUCH:
            matrix[first + i, first + i] += firm
            right[first + i] -= firm * max(rate, 0.0)


@njit(cache=True)
def floor(room, h, rise):
    """The least speed at the end of a step of what may not come nearer than `room`; negative towards it."""
    return -room / h if room > 0.0 else min(-SHARE * room / h, rise)


@njit(cache=True)
def stop(position, velocity, limits, h, firm, side, matrix, right):
    """Add the stops that press, by `side` (-1 lower, 1 upper, 0 none; shape (n,)), to `matrix` and `right`."""
    first = len(right) - len(position)
    for i in range(len(position)):
        if side[i] != 0:
            room = side[i] * (limits[i, 0 if side[i] < 0 else 1] - position[i])
            matrix[first + i, first + i] += firm
            right[first + i] += firm * (-side[i] * floor(room, h, RISE) - velocity[i])


@njit(cache=True)
def settle_stops(position, velocity, change, limits, h, firm, side, push):
    """Correct `side`, now that the change of velocity is known, and write the impulses of the stops to `push` (n,).

    Returns:
        Whether a stop came or went.
    """
    first, moved = len(change) - len(position), False
    for i in range(len(position)):
        speed = velocity[i] + change[first + i]
        push[i] = 0.0
        if side[i] == 0:
            if speed < floor(position[i] - limits[i, 0], h, RISE):
                side[i], moved = -1, True
            elif -speed < floor(limits[i, 1] - position[i], h, RISE):
                side[i], moved = 1, True
            continue
        room = side[i] * (limits[i, 0 if side[i] < 0 else 1] - position[i])
        push[i] = firm * (-side[i] * floor(room, h, RISE) - speed)
        if push[i] * side[i] > 0.0:
            side[i], push[i], moved = 0, 0.0, True
    return moved
