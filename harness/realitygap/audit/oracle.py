"""The same robot in Pinocchio: the judge that none of the compared engines is.

Built from the canonical `Model`, joint by joint, not from a URDF, so that whatever an adapter does to get the model
into its engine is part of what is judged.
"""

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
from realitygap_engines import GRAVITY, State
from realitygap_engines.model.robot import Array, Model, rotation_from_quaternion

from realitygap.files.errors import InputError

DOWN = np.array([0.0, 0.0, -GRAVITY])
ORIGIN = np.zeros(3)


def pinocchio() -> Any:
    """The module `pinocchio`.

    Raises:
        InputError: where it is not installed, with how to install it.
    """
    if importlib.util.find_spec("pinocchio") is None:
        raise InputError(
            "the audit needs Pinocchio as its judge, and it is not installed; install it with: pip install pin"
        )
    import pinocchio

    return pinocchio


class Oracle:
    """Rigid-body dynamics of a model in the coordinates of `Simulation.mass_matrix`: the base first, in world axes."""

    def __init__(self, model: Model, gravity: Array = DOWN) -> None:
        self._pin = pin = pinocchio()
        self._model, self._gravity = model, gravity
        self._tree = tree = pin.Model()
        root = tree.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "base") if model.floating else 0
        ids = [root]
        for joint in model.joints:
            kind = pin.JointModelPrismaticUnaligned if joint.prismatic else pin.JointModelRevoluteUnaligned
            ids.append(tree.addJoint(ids[joint.parent], kind(joint.axis), pin.SE3(joint.origin), joint.name))
        for link, i in zip(model.links, ids, strict=True):
            tree.appendBodyToJoint(i, pin.Inertia(link.mass, link.com, link.inertia), pin.SE3.Identity())
        self._data = tree.createData()
        self._base = 6 if model.floating else 0
        self._order = np.array([*range(self._base), *(tree.joints[i].idx_v for i in ids[1:])], dtype=np.int64)

    def inertia_and_bias(self, state: State) -> tuple[Array, Array]:
        """M (nv, nv) and c (nv,) of M·a + c = effort at a state."""
        pin, tree, o = self._pin, self._tree, self._base
        turn, rotation = np.eye(tree.nv), rotation_from_quaternion(state.base_quaternion)
        q, v, drift = np.zeros(tree.nq), np.zeros(tree.nv), np.zeros(tree.nv)
        joints = self._order[o:]
        q[joints + (1 if o else 0)] = state.position
        v[joints] = state.velocity
        if o:
            q[:3], q[3:7] = state.base_position, np.roll(state.base_quaternion, -1)
            turn[:3, :3] = turn[3:6, 3:6] = rotation.T
            v[:3], v[3:6] = rotation.T @ state.base_linear, rotation.T @ state.base_angular
            drift[:3] = -np.cross(v[3:6], v[:3])  # Pinocchio's base acceleration is that of the turning body axes
        tree.gravity.linear = self._gravity if o else rotation.T @ self._gravity
        upper = np.triu(pin.crba(tree, self._data, q))
        mass = upper + np.triu(upper, 1).T
        bias = turn.T @ (mass @ drift + pin.nonLinearEffects(tree, self._data, q, v))
        mass = turn.T @ mass @ turn
        return mass[np.ix_(self._order, self._order)], bias[self._order]

    def step(
        self,
        state: State,
        h: float,
        effort: Array,
        damping: Array | None = None,
        friction: Array | None = None,
        *,
        point: Array = ORIGIN,
    ) -> State:
        """The state after one step of the joint law of `realitygap_engines.engine`, with the model's armature.

        Every joint with friction must slide through the step in the direction in which it begins. `point` (3,) of the
        base link is the one whose linear velocity is stepped; another choice changes the result by order h².
        """
        n, o = len(self._model.joints), self._base
        damping = np.zeros(n) if damping is None else damping
        friction = np.zeros(n) if friction is None else friction
        mass, bias = self.inertia_and_bias(state)
        force = np.concatenate([np.zeros(o), effort - damping * state.velocity - friction * np.sign(state.velocity)])
        mass += np.diag(np.concatenate([np.zeros(o), self._model.armature + h * damping]))
        change = np.linalg.solve(mass, h * (force - bias)) if o + n else np.zeros(0)
        velocity = state.velocity + change[o:]
        out = State(state.position + h * velocity, velocity, state.base_position, state.base_quaternion)
        if o:
            out.base_angular = state.base_angular + change[3:6]
            out.base_quaternion = _turned(state.base_quaternion, h * out.base_angular)
            arm = rotation_from_quaternion(state.base_quaternion) @ point
            swung = rotation_from_quaternion(out.base_quaternion) @ point
            before, after = state.base_angular, out.base_angular
            centripetal = np.cross(before, np.cross(before, arm))
            out.base_linear = state.base_linear + change[:3] + np.cross(after, arm - swung) + h * centripetal
            out.base_position = state.base_position + h * out.base_linear
        return out


def _turned(quaternion: Array, rotation: Array) -> Array:
    """A quaternion w x y z after a further rotation vector [rad] in world axes."""
    half = 0.5 * rotation
    angle = float(np.linalg.norm(half))
    a = np.cos(angle)
    x, y, z = half * np.sinc(angle / np.pi)
    w, i, j, k = quaternion
    turned: Array = np.array(
        [
            a * w - x * i - y * j - z * k,
            a * i + x * w + y * k - z * j,
            a * j - x * k + y * w + z * i,
            a * k + x * j - y * i + z * w,
        ]
    )
    return turned / np.linalg.norm(turned)


def urdf_inertia(path: Path, model: Model, position: Array) -> tuple[float, Array]:
    """Mass [kg] and joint-space inertia (n, n) at joint positions (n,), as Pinocchio's own URDF reader has them.

    The base is held; its mass counts where the model's base floats.
    """
    pin = pinocchio()
    tree = pin.buildModelFromUrdf(str(path))
    starts = {tree.names[i]: tree.joints[i].idx_v for i in range(1, tree.njoints)}
    order = np.array([starts[name] for name in model.joint_names], dtype=np.int64)
    turned = np.zeros(tree.nv)
    turned[order] = position
    upper = np.triu(pin.crba(tree, tree.createData(), pin.integrate(tree, pin.neutral(tree), turned)))
    mass = upper + np.triu(upper, 1).T
    total = sum(inertia.mass for inertia in tree.inertias) if model.floating else sum(x.mass for x in tree.inertias[1:])
    return float(total), mass[np.ix_(order, order)]
