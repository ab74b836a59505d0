"""Joints that are coupled to others, in any engine: the force in the coupling, found outside and handed to the engine.

With T the velocities that each free joint (and the base) gives to all joints, the joint law on the coupled machine is
Tᵀ(M + A + h·D)·T·Δz = h·Tᵀ(effort − D·v + dry − c), which is solved exactly, dry friction included; a free joint bears
the friction of those that mimic it, multiplied. What the uncoupled engine needs on top of the effort to move so is the
coupling's force: then engine and coupling agree, as far as its step is forward dynamics. Ground and stops push
unforeseen, and a coupling would give way to them for a step: on the ground there are no mimic joints.
"""

import numpy as np

from realitygap_engines.engine import Capability, Simulation, State
from realitygap_engines.errors import Unsupported
from realitygap_engines.law.dynamics import Dynamics
from realitygap_engines.law.friction import stick_slip
from realitygap_engines.model.robot import Array, Model

MIMIC_JOINTS = Capability("emulated", "law.mimic: the force in the coupling; not on the ground")
CLOSING = 0.1
"""Share of an error of the coupling that a step takes back: a start that does not fit is no blow."""


def coupled(simulation: Simulation) -> Simulation:
    """The simulation with the mimic joints of its model coupled; itself where there are none.

    Raises:
        Unsupported: for mimic joints on the ground.
    """
    if all(joint.mimic is None for joint in simulation.model.joints):
        return simulation
    if simulation.physics.ground is not None:
        simulation.close()
        raise Unsupported(
            "mimic joints on the ground are not supported: what it does to them is not foreseen; hold them "
            "(robot: {hold: ...}) or expect ground: none"
        )
    return Coupled(simulation)


def coupling(model: Model) -> tuple[Array, Array]:
    """Matrix (n, n) and offset (n,) of all joints' positions from those of the free ones; columns of mimics are 0."""
    n, names = len(model.joints), model.joint_names
    matrix, offset = np.eye(n), np.zeros(n)
    for i, joint in enumerate(model.joints):
        if joint.mimic is not None:
            matrix[i, i] = 0.0
            matrix[i, names.index(joint.mimic.joint)] = joint.mimic.multiplier
            offset[i] = joint.mimic.offset
    return matrix, offset


class Coupled(Simulation):
    """A simulation whose mimic joints follow. See `Simulation`."""

    def __init__(self, inner: Simulation) -> None:
        self._inner = inner
        self.model, self.physics = inner.model, inner.physics
        self.settings = {**inner.settings, "mimic joints": "emulated by realitygap_engines.law.mimic"}
        n = len(self.model.joints)
        self._dynamics = Dynamics(self.model)
        self._first = first = len(self._dynamics.bias) - n
        joints, self._offset = coupling(self.model)
        self._joints = joints
        self._free = np.array([j.mimic is None for j in self.model.joints])
        spread = np.eye(first + n)
        spread[first:, first:] = joints
        self._spread = spread[:, np.append(np.ones(first, dtype=bool), self._free)]
        self._armature = np.append(np.zeros(first), self.model.armature)
        self._gravity = np.asarray(self.physics.gravity, dtype=float)
        self._q, self._w, self._base, self._dry = np.zeros(n), np.zeros(n), np.zeros(13), np.zeros(n)
        self._stick = np.zeros(int(self._free.sum()), dtype=np.int64)

    def reset(self, state: State) -> None:
        """The state with mimic joints where the others have them."""
        position, velocity = self._joints @ state.position + self._offset, self._joints @ state.velocity
        self._inner.reset(
            State(position, velocity, state.base_position, state.base_quaternion, state.base_linear, state.base_angular)
        )
        self._base[:3], self._base[3:7] = state.base_position, state.base_quaternion
        self._stick[:] = 0
        self._dry[:] = 0.0

    def step(self, effort: Array, damping: Array, friction: Array) -> None:
        h, first, spread, d = self.physics.timestep, self._first, self._spread, self._dynamics
        self._inner.read(self._q, self._w, self._base)
        d.update(self._q, self._w, self._base, self._gravity)
        moved = np.append(np.zeros(first), damping)
        speed = np.append(self._base[7:] if first else np.zeros(0), self._w)
        matrix = d.inertia + np.diag(self._armature + h * moved)
        right = h * (np.append(np.zeros(first), effort) - moved * speed - d.bias)
        free = np.append(np.ones(first, dtype=bool), self._free)
        own = speed[free]
        error = self._joints @ self._q + self._offset - self._q
        ahead = spread @ own - speed + np.append(np.zeros(first), CLOSING * error / h)
        bound = np.abs(self._joints[:, self._free]).T @ friction
        size, count = len(own), int(self._free.sum())
        change, residual, dry = np.zeros(size), np.zeros(size), np.zeros(count)
        stick_slip(
            spread.T @ matrix @ spread,
            np.zeros((size, size)),
            np.arange(-1, size - 1),
            spread.T @ (right - matrix @ ahead),
            change,
            residual,
            own,
            bound,
            h,
            np.zeros(count),
            self._stick,
            dry,
        )
        share = np.divide(dry, bound, out=np.zeros(count), where=bound > 0)
        self._dry = friction * (np.sign(self._joints[:, self._free]) @ share)
        needed = (matrix @ (spread @ change + ahead) - right) / h
        self._inner.step(effort + needed[first:], damping, np.zeros_like(friction))

    def read(self, position: Array, velocity: Array, base: Array) -> None:
        self._inner.read(position, velocity, base)

    def dry_friction(self) -> Array:
        return self._dry

    def mass_matrix(self) -> Array:
        return self._inner.mass_matrix()

    def bias(self) -> Array:
        return self._inner.bias()

    def _inverse(self, start: State, position: Array, velocity: Array, acceleration: Array) -> Array:
        """What a free joint takes is with all that mimics it; a mimic takes nothing itself."""
        q, v, a = position @ self._joints.T + self._offset, velocity @ self._joints.T, acceleration @ self._joints.T
        return np.asarray(self._inner.inverse_dynamics(start, q, v, a) @ self._joints)

    def close(self) -> None:
        self._inner.close()
