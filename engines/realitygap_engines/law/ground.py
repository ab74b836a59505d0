"""What the ground does to a tree of joints over one step: which contact points press, which stick and which slide.

A point below the surface of soft ground is pressed by a spring and damper at the end of the step, one on rigid ground
is kept from going below it; along the ground friction of at most the coefficient times that force holds it. The
joints are known by their inertia matrix, to which a point adds an inertia [kg] and an impulse [N·s] along an axis.

A pass solves with the guess of the pass before and corrects it: a point that would have to be pulled lets go; one whose
friction exceeds the cone slides, against the friction it had; one that slides is braked by the inertia that gives its
friction at the speed it was last seen to have (iteratively reweighted least squares, which converges to Coulomb's law).

With several points, as of a cube that lands flat, that may go in circles, and what is guessed on the way throws a body:
corners that are pulled down are let go while the others still press against them. Then one point at a time presses or
lets go, the first that has to, which comes to an end (Murty 1974, Opsearch 11), and friction is corrected only there;
where that goes in circles too, it is kept: an inertia that brakes takes energy, whatever its size.
"""
# mypy: allow-untyped-defs
# (compiled into `law.joints`; numba's cache of that file does not see a change made here)

import numpy as np
from numba import njit

from realitygap_engines.law.limits import floor

TOUCH = 1e-4
"""A point nearer than this [m] to rigid ground is looked at, where the ground is the engine's own."""
FAST = 10.0
"""Where it is not, a point is looked at that could get there within a step at this speed [m/s]."""
PRESS, GRIP, ALONG_X, ALONG_Y, LIFT, FORCE, OLD_X, OLD_Y = range(8)
"""Of a point: inertia [kg] along the normal (0: off) and along the ground, impulses [N·s] along the ground that are
given instead of an inertia, the impulse of the normal's inertia, the normal impulse, and those along the ground."""


@njit(cache=True)
def begin(speed, height, soil, ancestor, motion, point, point_end, touching, rows, points):
    """Find the points near the ground and guess what they do: as in the step before, where they touched already.

    Args:
        speed: of every coordinate. Shape (nv,).
        height: of every contact point [m]. Shape (k,).
        soil: step [s], stiffness [N/m] (inf: rigid), damping [N·s/m], friction, inertia of what is held firm [kg],
            a speed below which a point is at rest [m/s], the height at which it is looked at [m], and the speed [m/s]
            at which a point that is below rigid ground comes up at most (0 where the engine sees to that). Shape (8,).
        ancestor: as in `Dynamics`.
        motion: as in `Dynamics`.
        point: as in `Dynamics`.
        point_end: as in `Dynamics`.
        touching: out: the points near the ground. Shape (k,).
        rows: out: their velocities along x, y and z that each coordinate gives. Shape (k, 3, nv).
        points: the state of every point, from step to step. Shape (k, 8).

    Returns:
        The number of points near the ground.
    """
    h, stiffness, damping, firm, slow, reach, rise = soil[0], soil[1], soil[2], soil[4], soil[5], soil[6], soil[7]
    rigid = stiffness == np.inf
    count = 0
    for i in range(len(height)):
        state = points[i]
        if height[i] > (reach if rigid else 0.0) or point_end[i] < 0:
            state[:] = 0.0
            continue
        touching[count] = i
        row = rows[count]
        x, y, z = 0.0, 0.0, 0.0
        j = point_end[i]
        while j >= 0:
            for d in range(3):
                a, b = (d + 1) % 3, (d + 2) % 3
                row[d, j] = motion[j, d] + motion[j, 3 + a] * point[i, b] - motion[j, 3 + b] * point[i, a]
            x += row[0, j] * speed[j]
            y += row[1, j] * speed[j]
            z += row[2, j] * speed[j]
            j = ancestor[j]
        fresh = state[FORCE] == 0.0
        if rigid:
            lands = z < slow + floor(height[i], h, rise)
            state[PRESS] = firm if lands and (fresh or state[PRESS] > 0.0) else 0.0
        else:
            weight = h * (damping + h * stiffness)
            state[PRESS] = weight if -h * stiffness * height[i] - weight * z > 0.0 else 0.0
        if fresh:
            state[GRIP] = firm if abs(x) + abs(y) < slow else 0.0
        count += 1
    return count


@njit(cache=True)
def press(speed, height, soil, ancestor, point_end, touching, count, rows, points, matrix, right):
    """Add the inertias and impulses of the points to `matrix` (its lower triangle) and `right`."""
    h, stiffness = soil[0], soil[1]
    for c in range(count):
        i = touching[c]
        state, row = points[i], rows[c]
        x, y, z = _velocity(row, speed, ancestor, point_end[i])
        if state[PRESS] == 0.0:
            state[LIFT] = state[FORCE] = state[OLD_X] = state[OLD_Y] = 0.0
            continue
        if stiffness == np.inf:
            state[LIFT] = state[PRESS] * (floor(height[i], h, soil[7]) - z)
        else:
            state[LIFT] = -h * stiffness * height[i] - state[PRESS] * z
        along_x, along_y = state[ALONG_X] - state[GRIP] * x, state[ALONG_Y] - state[GRIP] * y
        j = point_end[i]
        while j >= 0:
            right[j] += row[0, j] * along_x + row[1, j] * along_y + row[2, j] * state[LIFT]
            a, b, n = state[GRIP] * row[0, j], state[GRIP] * row[1, j], state[PRESS] * row[2, j]
            k = j
            while k >= 0:
                matrix[j, k] += a * row[0, k] + b * row[1, k] + n * row[2, k]
                k = ancestor[k]
            j = ancestor[j]


@njit(cache=True)
def settle(speed, change, height, soil, ancestor, point_end, touching, count, rows, points, careful, kept):
    """Correct the guess, now that the change of velocity is known; `careful` is slower and lets one point turn at most.

    What brakes a point that slides is not corrected where it is `kept`.

    Returns:
        By how much the impulse of a point has changed at most, in units of the largest of them.
    """
    friction, firm = soil[3], soil[4]
    moved, largest = 0.0, 0.0
    for c in range(count if careful else 0):
        i = touching[c]
        state, row = points[i], rows[c]
        end = point_end[i]
        own, before = _velocity(row, change, ancestor, end), _velocity(row, speed, ancestor, end)
        if _turns(state, height[i], soil, own[2], before[2]):
            if state[PRESS] == 0.0:
                state[GRIP] = state[ALONG_X] = state[ALONG_Y] = 0.0
            return np.inf
    for c in range(count):
        i = touching[c]
        state, row = points[i], rows[c]
        x, y, z = _velocity(row, change, ancestor, point_end[i])
        before_x, before_y, before_z = _velocity(row, speed, ancestor, point_end[i])
        if _turns(state, height[i], soil, z, before_z):
            moved = np.inf
            continue
        if state[PRESS] == 0.0:
            continue
        normal = state[LIFT] - state[PRESS] * z
        x, y = x + before_x, y + before_y
        along_x, along_y = state[ALONG_X] - state[GRIP] * x, state[ALONG_Y] - state[GRIP] * y
        moved = max(moved, abs(normal - state[FORCE]), abs(along_x - state[OLD_X]), abs(along_y - state[OLD_Y]))
        largest = max(largest, normal)
        state[FORCE], state[OLD_X], state[OLD_Y] = normal, along_x, along_y
        bound, size, fast = friction * normal, np.hypot(along_x, along_y), np.hypot(x, y)
        given = state[ALONG_X] != 0.0 or state[ALONG_Y] != 0.0
        if given:  # was told to slide: does it, and against its friction?
            slides = along_x * x + along_y * y < 0.0
            state[GRIP] = min(firm, bound / fast) if slides else firm
            state[ALONG_X] = state[ALONG_Y] = 0.0
            moved = np.inf
        elif kept:
            continue
        elif state[GRIP] == firm and size > bound:
            moved = np.inf
            if careful:
                state[GRIP] = firm * bound / size
            else:
                state[GRIP] = 0.0
                state[ALONG_X], state[ALONG_Y] = along_x * bound / size, along_y * bound / size
        elif state[GRIP] != firm:
            state[GRIP] = min(firm, bound / fast) if fast > 0.0 else firm
    return moved / largest if largest > 0.0 else moved


@njit(cache=True)
def _turns(state, height, soil, change, before):
    """Let a point press or let go, where the change of its vertical velocity asks for it; whether it did."""
    h, stiffness = soil[0], soil[1]
    if state[PRESS] > 0.0:
        if state[LIFT] - state[PRESS] * change >= 0.0:
            return False
        state[PRESS], state[FORCE] = 0.0, 0.0
    elif stiffness == np.inf:
        if change + before >= floor(height, h, soil[7]):
            return False
        state[PRESS] = soil[4]
    else:
        if -stiffness * (height + h * (change + before)) - soil[2] * (change + before) <= 0.0:
            return False
        state[PRESS] = h * (soil[2] + h * stiffness)
    return True


@njit(cache=True)
def push(ancestor, point_end, touching, count, rows, points, h, out):
    """Add the points' forces to the generalized efforts `out`."""
    for c in range(count):
        i = touching[c]
        state, row = points[i], rows[c]
        if state[FORCE] == 0.0:
            continue
        j = point_end[i]
        while j >= 0:
            out[j] += (row[0, j] * state[OLD_X] + row[1, j] * state[OLD_Y] + row[2, j] * state[FORCE]) / h
            j = ancestor[j]


@njit(cache=True)
def _velocity(row, speed, ancestor, end):
    x, y, z = 0.0, 0.0, 0.0
    j = end
    while j >= 0:
        x += row[0, j] * speed[j]
        y += row[1, j] * speed[j]
        z += row[2, j] * speed[j]
        j = ancestor[j]
    return x, y, z
