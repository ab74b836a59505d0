"""The step of an engine that gives accelerations and no step of its own: velocities first, positions from the new ones.

With a the acceleration of every coordinate at the start of the step, v' = v + h·a and q' = q + h·v' (semi-implicit
Euler), as the other engines step; the base turns by the rotation vector h·ω'. What is implicit in the joint law, the
stops and the ground are solved outside the engine (`law.joints`) and handed to it as generalized efforts, so that an
adapter is left with the machine itself: its acceleration, inertia matrix and bias.
"""
# mypy: allow-untyped-defs
# (the compiled function takes arrays and numbers only; its caller is typed)

from abc import abstractmethod
from math import isfinite

import numpy as np

from realitygap_engines.engine import Capability, Physics, Simulation, State
from realitygap_engines.errors import Diverged
from realitygap_engines.law.compiled import compiled
from realitygap_engines.law.joints import FIRM, JointLaw
from realitygap_engines.law.mimic import MIMIC_JOINTS
from realitygap_engines.law.runaway import RUNAWAY, diverged
from realitygap_engines.model.robot import Array, Model

EMULATED = {
    "armature": Capability("emulated", "law.joints, exact"),
    "joint_damping": Capability("emulated", "law.joints, exact and implicit"),
    "joint_friction": Capability("emulated", "law.joints; exact, without creep"),
    "joint_limits": Capability("emulated", f"law.limits: a stop of {FIRM:g} times the unit of inertia"),
    "lone_body": Capability("native", "as with joints"),
    "mimic_joints": MIMIC_JOINTS,
    "rigid_ground": Capability("emulated", "law.ground: points that do not go below the surface, Coulomb's cone"),
    "soft_ground": Capability("emulated", "law.ground: implicit spring and damper per point, Coulomb's cone"),
    "solver_iterations": Capability("no", "nothing is iterated in the engine; the ground is solved until it settles"),
}
"""What every such engine gets from here."""


class Stepped(Simulation):
    """A simulation whose engine says how the machine accelerates. See `Simulation`."""

    def __init__(self, model: Model, physics: Physics) -> None:
        self.model = model
        self.physics = physics
        n = len(model.joints)
        self._first = first = 6 if model.floating else 0
        self._law = JointLaw(
            model,
            physics,
            native_armature=False,
            native_damping=False,
            native_ground=False,
            native_limits=False,
        )
        self._position, self._velocity, self._base = np.zeros(n), np.zeros(n), np.zeros(13)
        self._force = np.zeros(first + n)
        self._base_force, self._joint_force = self._force[:first], self._force[first:]
        self._steps = 0
        self.settings = {
            "timestep": physics.timestep,
            "gravity": list(physics.gravity),
            "scheme": "semi-implicit Euler, by realitygap_engines.law.stepped",
            "solver iterations": "not applicable: nothing is iterated in the engine",
            "armature, damping, dry friction, limits": "emulated by realitygap_engines.law.joints",
            "ground": None if physics.ground is None else "emulated by realitygap_engines.law.ground",
        }

    @abstractmethod
    def _acceleration(self, force: Array) -> Array:
        """How every coordinate of `mass_matrix` accelerates at the present state under these efforts. Shape (nv,)."""

    def _mount(self, quaternion: Array) -> None:
        """Turn a fixed base to an orientation (4,)."""

    def reset(self, state: State) -> None:
        self._position[:], self._velocity[:] = state.position, state.velocity
        self._base[:3], self._base[3:7] = state.base_position, state.base_quaternion
        if self._first:
            self._base[7:10], self._base[10:] = state.base_linear, state.base_angular
        else:
            self._mount(self._base[3:7])
        self._law.reset()
        self._steps = 0

    def step(self, effort: Array, damping: Array, friction: Array) -> None:
        self._steps += 1
        force, law, q, w, base = self._force, self._law, self._position, self._velocity, self._base
        self._joint_force[:] = law.effort(q, w, base, effort, damping, friction)
        self._base_force[:] = law.wrench
        if not isfinite(force.dot(force)):
            raise self._diverged(self._joint_force, "effort is not finite")
        if not _advance(q, w, base, self._acceleration(force), self.physics.timestep) < RUNAWAY:
            raise self._diverged(w, "velocity runs away")

    def _diverged(self, values: Array, what: str) -> Diverged:
        return diverged(self.model, self._steps * self.physics.timestep, values, what)

    def read(self, position: Array, velocity: Array, base: Array) -> None:
        position[:] = self._position
        velocity[:] = self._velocity
        if self._first:
            base[:] = self._base

    def dry_friction(self) -> Array:
        return self._law.dry.copy()


@compiled
def _advance(position, velocity, base, acceleration, h):
    """Step the state in place; the largest speed, not a number where one is none."""
    n = len(position)
    first = len(acceleration) - n
    fastest = 0.0
    for i in range(n):
        velocity[i] += h * acceleration[first + i]
        position[i] += h * velocity[i]
        fastest = max(fastest, abs(velocity[i])) if velocity[i] == velocity[i] else np.nan
    if first == 0:
        return fastest
    for k in range(6):
        base[7 + k] += h * acceleration[k]
        fastest = max(fastest, abs(base[7 + k])) if base[7 + k] == base[7 + k] else np.nan
    for k in range(3):
        base[k] += h * base[7 + k]
    x, y, z = 0.5 * h * base[10], 0.5 * h * base[11], 0.5 * h * base[12]
    half = np.sqrt(x * x + y * y + z * z)
    share = np.sin(half) / half if half > 1e-8 else 1.0
    a, x, y, z = np.cos(half), share * x, share * y, share * z
    w, i, j, k = base[3], base[4], base[5], base[6]
    base[3] = a * w - x * i - y * j - z * k
    base[4] = a * i + x * w + y * k - z * j
    base[5] = a * j - x * k + y * w + z * i
    base[6] = a * k + x * j - y * i + z * w
    norm = np.sqrt(base[3] ** 2 + base[4] ** 2 + base[5] ** 2 + base[6] ** 2)
    for k in range(4):
        base[3 + k] /= norm
    return fastest
