"""The joint law of `engines.engine`, for engines that lack armature, implicit damping or dry friction.

The torque that the engine gets makes its own step come out as the law asks. With the machine's inertia M and bias c
(from `engines.dynamics`), armature A, damping D and step h, the end-of-step velocity v' solves

    (M + A + h D + K) (v' - v) = h (effort - D v + dry - c + load) + K (v_ground - v),     abs(dry) <= friction,

and the engine, which lacks some of A, D and dry, is handed effort + dry - D v' - A (v' - v)/h of those it lacks.

The ground: a rigid contact point that does not slide moves on as it must (v_ground: not into the ground), which K, a
very large inertia at that point, sees to. This matters: a planted foot has an inertia of 4.5e-4 kg·m² against an
armature of 0.027, and a law that took the ground's force from the previous step would need 60 steps to follow a
change of torque. What K cannot know, the force on sliding or soft points, is taken from the previous step (`load`:
what that step's change of velocity asks for beyond the torque given). After a rigid contact begins or ends that force
says nothing about the next step (an impact is a spike of 100 times the weight) and is dropped. Where the engine
moved a joint otherwise than foreseen, as in such a step, the momentum that its rotor should have kept is given back
in the next step.

The friction is a box-constrained linear complementarity problem; it is solved exactly by block principal pivoting
(Júdice and Pires 1994) over which joints are stuck, starting from those of the previous step. All factorisations use
the branches of the tree (L^T D L; Featherstone, Rigid Body Dynamics Algorithms, 2008, section 6.4).
"""

import numpy as np
from numba import njit

from engines.dynamics import Dynamics
from engines.engine import Physics
from engines.model import Array, Model

HEIGHT = 1e-4
"""A contact point or limit within this distance [m, rad] counts as touching."""
FIRM = 1e4
"""Inertia of a firm contact point in units of the robot's mass."""


class JointLaw:
    """The joint law of one simulation, outside the engine.

    Attributes:
        dry: the dry friction of the last step, signed [N·m or N]. Shape (n,).
    """

    def __init__(self, model: Model, physics: Physics, *, native_armature: bool, native_damping: bool) -> None:
        """`native_armature`, `native_damping`: the engine itself adds the model's armature, the step's damping."""
        n = len(model.joints)
        self._dynamics = d = Dynamics(model)
        nv = len(d.bias)
        self._gravity = np.asarray(physics.gravity, dtype=float)
        self.dry = np.zeros(n)
        self._out = np.zeros(n)
        self._stick = np.zeros(n, dtype=np.int64)
        self._lacks_armature = not native_armature and bool(model.armature.any())
        self._lacks_damping = not native_damping
        ground = physics.ground
        soft = ground is not None and ground.stiffness is not None
        self._ground = np.array(
            [
                float(ground is not None),
                float(soft),
                (ground.stiffness or 0.0) if ground else 0.0,
                (ground.damping or 0.0) if ground else 0.0,
            ]
        )
        self._options = np.array([physics.timestep, float(native_armature), float(native_damping), FIRM * model.mass])
        limits = np.array([[j.lower, j.upper] for j in model.joints]).reshape(n, 2)
        self._law = (np.append(np.zeros(nv - n), model.armature), limits, self._options, self._ground)
        # of the previous step: inertia, bias, velocity, joint torque the engine had, foreseen velocity, touching
        self._past = (
            np.zeros((nv, nv)), np.zeros(nv), np.zeros(nv), np.zeros(n), np.zeros(n),
            np.zeros(len(d.height) + n, dtype=np.bool_), np.zeros(1, dtype=np.bool_),
        )  # fmt: skip
        self._work = (np.zeros((nv, nv)), np.zeros((nv, nv)), np.zeros((5, nv)), np.zeros(nv))

    def reset(self) -> None:
        """Forget the previous step."""
        self.dry[:] = 0.0
        self._stick[:] = 0
        self._past[-1][0] = False

    def effort(
        self, position: Array, velocity: Array, base: Array, effort: Array, damping: Array, friction: Array
    ) -> Array:
        """The torque to hand to the engine for this step; valid until the next call. Shape (n,).

        Args:
            position: of the joints at the start of the step. Shape (n,), as are velocity, effort, damping, friction.
            velocity: of the joints at the start of the step.
            base: the row of `Simulation.read`; for a fixed base its pose and zero velocity. Shape (13,).
            effort: the motors' effort.
            damping: as in `Simulation.step`.
            friction: as in `Simulation.step`.
        """
        if not (self._lacks_armature or friction.any() or (self._lacks_damping and damping.any())):
            self.reset()
            return effort
        d = self._dynamics
        d.update(position, velocity, base, self._gravity)
        _solve(
            position, velocity, base, effort, damping, friction,
            d.inertia, d.bias, d.ancestor, d.motion, d.point, d.height, d.point_end,
            *self._law, *self._past, *self._work, self._stick, self.dry, self._out,
        )  # fmt: skip
        return self._out


@njit(cache=True)
def _solve(
    position, velocity, base, effort, damping, friction,
    inertia, bias, ancestor, motion, point, height, point_end,
    armature, limits, options, ground,
    old_inertia, old_bias, old_velocity, old_torque, foreseen, old_touch, known,
    matrix, factor, vectors, row, stick, dry, out,
):  # fmt: skip
    n, nv = len(position), len(bias)
    first = nv - n
    h, native_armature, native_damping, firm = options[0], options[1] > 0, options[2] > 0, options[3]
    speed, load, right, change, free = vectors[0], vectors[1], vectors[2], vectors[3], vectors[4]
    for i in range(first):
        speed[i] = base[7 + i]
    for i in range(n):
        speed[first + i] = velocity[i]

    # what the previous step's change of velocity asks for beyond the torque given: contact, limits
    load[:] = 0.0
    if known[0]:
        for i in range(nv):
            change[i] = (speed[i] - old_velocity[i]) / h
        _multiply(old_inertia, ancestor, change, load)
        for i in range(nv):
            load[i] += old_bias[i]
        for i in range(n):
            load[first + i] -= old_torque[i]
            if native_damping:
                load[first + i] += damping[i] * velocity[i]
            if native_armature:
                load[first + i] += armature[first + i] * change[first + i]

    for i in range(nv):
        j = i
        while j >= 0:
            matrix[i, j] = old_inertia[i, j] = inertia[i, j]
            j = ancestor[j]
        matrix[i, i] += armature[i]
        old_bias[i], old_velocity[i] = bias[i], speed[i]
        right[i] = -h * bias[i]
    for i in range(n):
        matrix[first + i, first + i] += h * damping[i]
        out[i] = effort[i]
        if known[0]:
            kept = (0.0 if native_armature else armature[first + i]) + (0.0 if native_damping else h * damping[i])
            if kept > 0:
                out[i] -= kept * (velocity[i] - foreseen[i]) / h
        right[first + i] += h * (out[i] - damping[i] * velocity[i])

    touching, same = _touch(
        position,
        speed,
        limits,
        h,
        firm,
        ground,
        ancestor,
        motion,
        point,
        height,
        point_end,
        old_touch,
        matrix,
        right,
        row,
    )
    if touching and (same or ground[1] > 0):
        for i in range(nv):
            right[i] += h * load[i]

    _pivot(matrix, factor, ancestor, right, change, free, speed, friction, h, stick, dry)

    for i in range(n):
        after = velocity[i] + change[first + i]
        foreseen[i] = after
        torque = out[i]
        if friction[i] > 0:
            torque += dry[i]
        if damping[i] != 0 and not native_damping:
            torque -= damping[i] * after
        if armature[first + i] != 0 and not native_armature:
            torque -= armature[first + i] * change[first + i] / h
        out[i] = old_torque[i] = torque
    known[0] = True


@njit(cache=True)
def _touch(
    position, speed, limits, h, firm, ground, ancestor, motion, point, height, point_end, old_touch, matrix, right, row
):  # fmt: skip
    """Add the inertia of what touches to `matrix` and `right`; whether anything touches, and the same as before."""
    touching, same = False, True
    n, k = len(position), len(height)
    first = len(speed) - n
    slow = 0.5 * 9.81 * h  # half of what a free fall gains in a step: slower than this is at rest
    soft = ground[1] > 0
    for i in range(k):
        touch = ground[0] > 0 and height[i] < (0.0 if soft else HEIGHT)
        if touch:
            push = np.zeros(3)
            for d in range(3):
                j = point_end[i]
                while j >= 0:
                    push[d] += _reach(motion, point, i, j, d) * speed[j]
                    j = ancestor[j]
            stays = abs(push[0]) + abs(push[1]) < slow
            if soft:
                weight = h * (ground[3] + h * ground[2])
                _hold(
                    matrix, right, row, ancestor, motion, point, point_end, i, 2, weight, -h * h * ground[2] * push[2]
                )
            else:
                touch = push[2] < slow
                stays = stays and touch
                if touch:
                    end = max(push[2], -max(height[i], 0.0) / h) if push[2] < 0 else push[2]
                    _hold(matrix, right, row, ancestor, motion, point, point_end, i, 2, firm, firm * (end - push[2]))
            if stays:
                for d in range(2):
                    _hold(matrix, right, row, ancestor, motion, point, point_end, i, d, firm, 0.0)
        same = same and touch == old_touch[i]
        old_touch[i] = touch
        touching = touching or touch
    for i in range(n):
        low, high, rate = position[i] - limits[i, 0], limits[i, 1] - position[i], speed[first + i]
        touch = (low < HEIGHT and rate < slow) or (high < HEIGHT and -rate < slow)
        if touch:
            matrix[first + i, first + i] += firm
            inward = rate < 0 if low < HEIGHT else rate > 0
            if inward:
                right[first + i] -= firm * rate
        same = same and touch == old_touch[k + i]
        old_touch[k + i] = touch
        touching = touching or touch
    return touching, same


@njit(cache=True, inline="always")
def _reach(motion, point, i, j, d):
    """The velocity of point i along axis d that coordinate j gives."""
    a, b = (d + 1) % 3, (d + 2) % 3
    return motion[j, d] + motion[j, 3 + a] * point[i, b] - motion[j, 3 + b] * point[i, a]


@njit(cache=True)
def _hold(matrix, right, row, ancestor, motion, point, point_end, i, d, weight, push):
    """Add the inertia `weight` [kg] of point i along axis d, and the impulse `push` [N·s] on it."""
    j = point_end[i]
    while j >= 0:
        row[j] = _reach(motion, point, i, j, d)
        j = ancestor[j]
    j = point_end[i]
    while j >= 0:
        right[j] += push * row[j]
        k = j
        while k >= 0:
            matrix[j, k] += weight * row[j] * row[k]
            k = ancestor[k]
        j = ancestor[j]


@njit(cache=True)
def _pivot(matrix, factor, ancestor, right, change, residual, speed, friction, h, stick, dry):
    """The change of velocity and the dry friction, by block principal pivoting.

    `stick` is 0 for a stuck joint and the sign of its velocity for a sliding one. Blocks of joints are moved between
    the sets while that lowers the number of contradictions, else the last contradicting one alone, which is finite.
    """
    n, nv = len(stick), len(right)
    first = nv - n
    best, tries = n + 1, 4
    for _ in range(8 * n + 8):
        for i in range(nv):
            change[i] = 0.0
        for i in range(n):
            if friction[i] > 0 and stick[i] == 0:
                change[first + i] = -speed[first + i]
        _multiply(matrix, ancestor, change, residual)
        for i in range(nv):
            residual[i] = right[i] - residual[i]
        for i in range(nv):
            locked = i >= first and friction[i - first] > 0 and stick[i - first] == 0
            j = i
            while j >= 0:
                off = locked or (j >= first and friction[j - first] > 0 and stick[j - first] == 0)
                factor[i, j] = matrix[i, j] if not off else (1.0 if i == j else 0.0)
                j = ancestor[j]
            if locked:
                residual[i] = change[i]
            elif i >= first and friction[i - first] > 0:
                residual[i] -= h * stick[i - first] * friction[i - first]
        _factorise(factor, ancestor)
        _substitute(factor, ancestor, residual)
        for i in range(nv):
            change[i] = residual[i]
        _multiply(matrix, ancestor, change, residual)
        wrong, last = 0, -1
        for i in range(n):
            dry[i] = 0.0
            if friction[i] > 0:
                if stick[i] == 0:
                    dry[i] = (residual[first + i] - right[first + i]) / h
                    bad = abs(dry[i]) > friction[i] * (1 + 1e-9)
                else:
                    dry[i] = -stick[i] * friction[i]
                    bad = stick[i] * (speed[first + i] + change[first + i]) < -1e-12
                if bad:
                    wrong, last = wrong + 1, i
        if wrong == 0:
            break
        if wrong < best:
            best, tries = wrong, 4
        else:
            tries -= 1
        for i in range(n):
            if friction[i] > 0 and (tries >= 0 or i == last):
                if stick[i] == 0 and abs(dry[i]) > friction[i] * (1 + 1e-9):
                    stick[i] = -1 if dry[i] > 0 else 1
                elif stick[i] != 0 and stick[i] * (speed[first + i] + change[first + i]) < -1e-12:
                    stick[i] = 0
    for i in range(n):
        dry[i] = min(max(dry[i], -friction[i]), friction[i])


@njit(cache=True)
def _multiply(matrix, ancestor, x, out):
    """The product of a branch-sparse symmetric matrix, of which the lower triangle is used, and x."""
    for i in range(len(x)):
        out[i] = matrix[i, i] * x[i]
        j = ancestor[i]
        while j >= 0:
            out[i] += matrix[i, j] * x[j]
            out[j] += matrix[i, j] * x[i]
            j = ancestor[j]


@njit(cache=True)
def _factorise(matrix, ancestor):
    """L^T D L in place."""
    for k in range(len(ancestor) - 1, -1, -1):
        i = ancestor[k]
        while i >= 0:
            a = matrix[k, i] / matrix[k, k]
            j = i
            while j >= 0:
                matrix[i, j] -= a * matrix[k, j]
                j = ancestor[j]
            matrix[k, i] = a
            i = ancestor[i]


@njit(cache=True)
def _substitute(factor, ancestor, x):
    """Solve L^T D L x = b in place."""
    for i in range(len(x) - 1, -1, -1):
        j = ancestor[i]
        while j >= 0:
            x[j] -= factor[i, j] * x[i]
            j = ancestor[j]
    for i in range(len(x)):
        x[i] /= factor[i, i]
        j = ancestor[i]
        while j >= 0:
            x[i] -= factor[i, j] * x[j]
            j = ancestor[j]
