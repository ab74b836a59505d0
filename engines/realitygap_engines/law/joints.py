"""The joint law of `engine`, for engines that lack armature, implicit damping or dry friction.

With the machine's inertia M and bias c (`law.dynamics`), armature A, damping D and step h, the law asks for the
end-of-step velocity v' of

    (M + A + h D) (v' - v) = h (effort - D v + dry - c) + ground,     abs(dry) <= friction,

and an engine that lacks A, D and dry comes out there when it is handed effort + dry - D v' - A (v' - v)/h.

*Ballast.* A planted foot has an inertia of 4.5e-4 kg·m² against an armature of 0.027: in an engine that does not know
of the armature the ground moves it 60 times too easily, and no torque that was chosen before the contact was solved can
mend that. So the engine gets a model (`JointLaw.model`) with rotary inertia E on its outermost links, as much as the
armature of the joints before them, and is handed E (v' - v)/h more, on the base too (`JointLaw.wrench`): what differs
from the law is A - E then, which is small where contact is felt. An engine opts in with `ballast=True`; without
ground there is none.

*Ground.* It has to be foreseen (`law.ground`): what presses, sticks and slides decides how much a torque moves a
joint. An engine without soft ground, or without any, gets it from here, as forces; then nothing is left to be foreseen.
So it is with the stops at the joints' limits (`law.limits`).

*Momentum.* Where the engine moved otherwise than foreseen (an impact, a foot that leaves the ground, sliding), what
A + h D - E should have had of it is handed over in the next step, and on soft ground a stuck joint that was moved goes
back. So an error lasts for one step and does not add up.

Which joints are stuck is solved exactly (`law.friction`).
"""
# mypy: allow-untyped-defs
# (the compiled functions take arrays and numbers only; their callers are typed)

from dataclasses import replace

import numpy as np

from realitygap_engines.engine import Ground, Physics
from realitygap_engines.law.compiled import compiled
from realitygap_engines.law.dynamics import Dynamics
from realitygap_engines.law.friction import stick_slip
from realitygap_engines.law.ground import FAST, TOUCH, begin, press, push, settle
from realitygap_engines.law.limits import RISE, foresee, settle_stops, stop
from realitygap_engines.model.robot import Array, Model

FIRM = 1e4
"""Inertia of a point that stays, in units of the robot's mass [kg] and, for limits, of as many kg·m²."""
GUESSES, PASSES = 4, 80
"""Passes over the ground at most, where it is the engine's and only foreseen, and where it is this law's."""
CAREFUL, KEPT = 10, 40
"""The passes after which points turn one at a time, and after which what brakes them is kept."""
RETURN = 0.2
"""What a stuck joint undoes in a step of how far it was moved, on soft ground. On rigid ground stuck joints and points
close loops, in which any aim but rest asks for any force."""
SETTLED = 1e-8
"""Change of an impulse on a point, of the largest, below which no further pass is made."""


class JointLaw:
    """The joint law of one simulation, outside the engine.

    Attributes:
        model: what the engine has to simulate: the model, with ballast on some links and without armature unless that
            is native.
        dry: the dry friction of the last step, signed [N·m or N]. Shape (n,).
        wrench: force [N] at the origin of the base link and torque [N·m], world axes, that the engine has to apply to
            a floating base in this step. Shape (6,), (0,) for a fixed base.
        ballasted: whether any link has ballast; `wrench` stays zero otherwise.
    """

    def __init__(
        self,
        model: Model,
        physics: Physics,
        *,
        native_armature: bool,
        native_damping: bool,
        native_ground: bool = True,
        native_limits: bool = True,
        ballast: bool = False,
    ) -> None:
        """Set up the law for one model.

        Args:
            model: the machine.
            physics: the settings of the simulation.
            native_armature: the engine itself adds the model's armature.
            native_damping: the engine itself adds the step's damping.
            native_ground: the engine itself has the ground; otherwise it has none, and applies `wrench`.
            native_limits: the engine itself has stops at the joints' limits.
            ballast: the engine simulates `model` of this object, not the one given, and applies `wrench`.
        """
        n, ground = len(model.joints), physics.ground
        self._dynamics = d = Dynamics(model)
        first = len(d.bias) - n
        self._gravity = np.asarray(physics.gravity, dtype=float)
        self._lacks_armature = not native_armature and bool(model.armature.any())
        self._lacks_damping = not native_damping

        weight = np.zeros(n + 1)
        if ballast and self._lacks_armature and ground is not None:
            weight = _ballast(model)
        links = [replace(k, inertia=k.inertia + w * np.eye(3)) for k, w in zip(model.links, weight, strict=True)]
        self.model = replace(model, links=tuple(links)) if weight.any() else model
        if not native_armature:
            self.model = self.model.with_armature(np.zeros(n))
        self.ballasted = bool(weight.any())
        carrier = np.flatnonzero(weight)
        self._ballast = (carrier, weight[carrier], first - 1 + carrier)

        h, fall = physics.timestep, float(np.linalg.norm(self._gravity)) * physics.timestep
        self._carries_ground = not native_ground and ground is not None
        self._limits = np.array([[j.lower, j.upper] for j in model.joints]).reshape(n, 2)
        self._carries_stops = not native_limits and bool(np.isfinite(self._limits).any())
        carried = (self._carries_ground, self._carries_stops)
        self._settings = np.array([h, self._lacks_armature, self._lacks_damping, *carried, FIRM])
        soil = ground or Ground()
        stiffness, soil_damping = np.inf if soil.stiffness is None else soil.stiffness, soil.damping or 0.0
        # what is slower than half of what a free fall gains in a step is at rest
        reach, rise = (FAST * h, RISE) if self._carries_ground else (TOUCH, 0.0)
        self._soil = np.array([h, stiffness, soil_damping, soil.friction, FIRM * model.mass, 0.5 * fall, reach, rise])
        points = len(d.height) if ground is not None else 0
        self._near = np.zeros(points, dtype=np.int64)
        self._points = np.zeros((points, 8))
        self._rows = np.zeros((points, 3, first + n))
        self._armature = np.append(np.zeros(first), model.armature)
        self._stick, self._side = np.zeros((2, n), dtype=np.int64)
        self._anchor = np.zeros((3, n))
        self._known = np.zeros(1, dtype=np.bool_)
        self._work = np.zeros((6, first + n))
        self._matrices = np.zeros((2, first + n, first + n))
        self.dry = np.zeros(n)
        self._given = np.zeros(first + n)
        self.wrench, self._out = self._given[:first], self._given[first:]

    def reset(self) -> None:
        """Forget the previous step."""
        self.dry[:] = 0.0
        self._given[:] = 0.0
        self._stick[:] = self._side[:] = 0
        self._points[:] = 0.0
        self._known[0] = False

    def effort(
        self, position: Array, velocity: Array, base: Array, effort: Array, damping: Array, friction: Array
    ) -> Array:
        """The joint effort to hand to the engine for this step (and `wrench`); valid until the next call. Shape (n,).

        Args:
            position: of the joints at the start of the step. Shape (n,), as are velocity, effort, damping, friction.
            velocity: of the joints at the start of the step.
            base: the row of `Simulation.read`; for a fixed base its pose and zero velocity. Shape (13,).
            effort: as in `Simulation.step`.
            damping: as in `Simulation.step`.
            friction: as in `Simulation.step`.
        """
        carries = self._carries_ground or self._carries_stops
        needed = self._lacks_armature or carries or np.count_nonzero(friction)
        if not (needed or (self._lacks_damping and np.count_nonzero(damping))):
            if self._known[0]:
                self.reset()
            return effort
        d = self._dynamics
        d.update(position, velocity, base, self._gravity)
        _solve(
            position, velocity, base, effort, damping, friction,
            d.inertia, d.bias, d.ancestor, d.motion, d.swing, d.point, d.height, d.point_end,
            self._armature, self._limits, self._settings, *self._ballast,
            self._soil, self._near, self._rows, self._points,
            self._known, self._stick, self._side, *self._anchor, self.dry, self._given, self._work, self._matrices,
        )  # fmt: skip
        return self._out

    def ballast(self, position: Array, velocity: Array, base: Array) -> tuple[Array, Array]:
        """The ballast's part in the engine's inertia matrix and bias. Shapes (nv, nv) and (nv,)."""
        d = self._dynamics
        d.update(position, velocity, base, self._gravity)
        nv = len(d.bias)
        matrix, bias = np.zeros((nv, nv)), np.zeros(nv)
        for k, weight, end in zip(*self._ballast, strict=True):
            _swing(d.motion, d.ancestor, end, weight, np.zeros(nv), d.swing[k], 1.0, bias)
            for i in range(nv):
                _swing(d.motion, d.ancestor, end, weight, np.eye(nv)[i], d.swing[k], 0.0, matrix[i])
        return matrix, bias


def _ballast(model: Model) -> Array:
    """Rotary inertia of each link [kg·m²], so that all beyond a joint carry its armature at least. Shape (n + 1,).

    It is isotropic, because engines refuse or drop an inertia that no body has.
    """
    out = np.zeros(len(model.links))
    beyond = np.zeros(len(model.links))
    for i in range(len(model.joints), 0, -1):
        joint = model.joints[i - 1]
        if not joint.prismatic:
            out[i] = max(0.0, joint.armature - beyond[i])
        beyond[joint.parent] += beyond[i] + out[i]
    return out


@compiled
def _solve(
    position, velocity, base, effort, damping, friction,
    inertia, bias, ancestor, motion, swing, point, height, point_end,
    armature, limits, settings, carrier, ballast, carrier_end,
    soil, near, rows, points,
    known, stick, side, anchor, aim, stopped, dry, given, work, matrices,
):  # fmt: skip
    n, nv = len(position), len(bias)
    first = nv - n
    h, lacks_armature, lacks_damping, carries_ground = settings[0], settings[1], settings[2], settings[3]
    carries_stops, firm = settings[4], settings[5]
    foreseen, speed, change, right, free = work[0], work[1], work[2], work[3], work[4]
    matrix, factor = matrices[0], matrices[1]
    for i in range(first):
        speed[i] = base[7 + i]
        given[i] = 0.0
    for i in range(n):
        speed[first + i] = velocity[i]
        given[first + i] = effort[i]

    if known[0]:  # hand over the momentum that the last step missed
        for i in range(nv):
            change[i] = (foreseen[i] - speed[i]) / h
        for i in range(n):
            lack = lacks_armature * armature[first + i] + lacks_damping * h * damping[i]
            if lack > 0:
                given[first + i] += lack * change[first + i]
        for i in range(len(carrier)):
            _swing(motion, ancestor, carrier_end[i], -ballast[i], change, swing[carrier[i]], 0.0, given)

    for i in range(n):  # a stuck joint goes back to where it stuck
        if not known[0] or stick[i] != 0 or friction[i] == 0:
            anchor[i] = position[i]
        aim[i] = RETURN * (anchor[i] - position[i]) / h if soil[1] < np.inf else 0.0

    count = begin(speed, height, soil, ancestor, motion, point, point_end, near, rows, points) if len(points) else 0
    for turn in range(PASSES if carries_ground > 0 or carries_stops > 0 else GUESSES):
        for i in range(nv):
            j = i
            while j >= 0:
                matrix[i, j] = inertia[i, j]
                j = ancestor[j]
            matrix[i, i] += armature[i]
            right[i] = h * (given[i] - bias[i])
        for i in range(n):
            matrix[first + i, first + i] += h * damping[i]
            right[first + i] -= h * damping[i] * velocity[i]
        if carries_stops > 0:
            stop(position, velocity, limits, h, firm, side, matrix, right)
        else:
            foresee(position, velocity, limits, firm, matrix, right)
        press(speed, height, soil, ancestor, point_end, near, count, rows, points, matrix, right)
        stick_slip(matrix, factor, ancestor, right, change, free, speed, friction, h, aim, stick, dry)
        moved = 0.0
        if count > 0:
            slow = turn > CAREFUL, turn > KEPT
            moved = settle(speed, change, height, soil, ancestor, point_end, near, count, rows, points, *slow)
        if carries_stops > 0 and settle_stops(position, velocity, change, limits, h, firm, side, stopped):
            moved = np.inf
        if moved < SETTLED:
            break

    for i in range(nv):
        foreseen[i] = speed[i] + change[i]
        change[i] /= h
    for i in range(n):
        j = first + i
        if friction[i] > 0:
            given[j] += dry[i]
        if damping[i] != 0 and lacks_damping > 0:
            given[j] -= damping[i] * foreseen[j]
        if armature[j] != 0 and lacks_armature > 0:
            given[j] -= armature[j] * change[j]
        if side[i] != 0:
            given[j] += stopped[i] / h
    for i in range(len(carrier)):
        _swing(motion, ancestor, carrier_end[i], ballast[i], change, swing[carrier[i]], 1.0, given)
    if carries_ground > 0:
        push(ancestor, point_end, near, count, rows, points, h, given)
    known[0] = True


@compiled
def _swing(motion, ancestor, end, weight, acceleration, swing, share, out):
    """Add the effort that a link's rotary inertia `weight` asks for; `swing` is its angular acceleration at rest."""
    a, b, c = share * swing[0], share * swing[1], share * swing[2]
    j = end
    while j >= 0:
        a += motion[j, 3] * acceleration[j]
        b += motion[j, 4] * acceleration[j]
        c += motion[j, 5] * acceleration[j]
        j = ancestor[j]
    j = end
    while j >= 0:
        out[j] += weight * (a * motion[j, 3] + b * motion[j, 4] + c * motion[j, 5])
        j = ancestor[j]
