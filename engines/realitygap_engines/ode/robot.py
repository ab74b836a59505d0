"""A model as bodies, joints and motors in an ODE world, and as the numbers that ODE holds of it.

Every body sits in its link's centre of mass with the link's axes; a fixed base is a kinematic body. A joint is a
hinge or slider from parent to child, made at q = 0, with two motors along its axis: `rotor` and `brake`.
"""

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, pi, tau

import numpy as np

from realitygap_engines.engine import State
from realitygap_engines.errors import Unsupported
from realitygap_engines.model.robot import (
    Array,
    Link,
    Model,
    link_poses,
    quaternion_from_rotation,
    rotation_from_quaternion,
)
from realitygap_engines.ode import library as ode_library
from realitygap_engines.ode.bodies import Axis, Body, inertia_and_bias
from realitygap_engines.ode.library import HI_STOP, LO_STOP, Feedback, Mass, real_array, view

ode = ode_library.open_library()

MotorCalls = tuple[Callable[..., int], Callable[..., None], Callable[..., None]]
ANGULAR: MotorCalls = (ode.dJointCreateAMotor, ode.dJointSetAMotorNumAxes, ode.dJointSetAMotorAxis)
LINEAR: MotorCalls = (ode.dJointCreateLMotor, ode.dJointSetLMotorNumAxes, ode.dJointSetLMotorAxis)
"""What makes a motor, gives it a number of axes, and sets one of them."""


@dataclass(frozen=True)
class OdeLink:
    """A body, and views of where ODE keeps its state; `rotation` is in rows of four."""

    body: int
    com: Array
    position: Array
    quaternion: Array
    rotation: Array
    linear: Array
    angular: Array


@dataclass(frozen=True)
class OdeJoint:
    """A hinge or slider with its motors and the calls that fit its kind.

    `rate` is None for a slider: ODE's own leaves out that the parent turns.
    """

    joint: int
    rotor: int
    brake: int
    load: Feedback
    position: Callable[[int], float]
    rate: Callable[[int], float] | None
    push: Callable[[int, float], None]
    set_motor: Callable[[int, int, float], None]


class OdeRobot:
    """The robot of one world.

    Attributes:
        links: one per link of the model.
        joints: one per joint of the model.
        limited: names of the joints whose limits ODE enforces.

    Raises:
        Unsupported: for a body without mass or inertia.
    """

    def __init__(self, world: int, model: Model) -> None:
        self._model = model
        zero = np.zeros(len(model.joints))
        self.links = [_link(world, link, i > 0 or model.floating) for i, link in enumerate(model.links)]
        poses = link_poses(model, zero)
        self._place(poses, np.zeros((len(poses), 3)), np.zeros((len(poses), 3)))
        self.joints: list[OdeJoint] = []
        self.limited: list[str] = []
        for i, (joint, pose) in enumerate(zip(model.joints, poses[1:], strict=True)):
            child, parent = self.links[i + 1].body, self.links[joint.parent].body
            made = (_slider if joint.prismatic else _hinge)(
                world, child, parent, pose[:3, :3] @ joint.axis, pose[:3, 3]
            )
            self.joints.append(made)
            lower, upper = joint.lower, joint.upper
            if not joint.prismatic:  # ODE knows a hinge's angle within half a turn, and drops a stop beyond
                lower, upper = (lower if lower > -pi else -inf), (upper if upper < pi else inf)
            set_stop = ode.dJointSetSliderParam if joint.prismatic else ode.dJointSetHingeParam
            if isfinite(lower) or isfinite(upper):
                set_stop(made.joint, LO_STOP, lower)
                set_stop(made.joint, HI_STOP, upper)
                self.limited.append(joint.name)

    def reset(self, state: State) -> None:
        """Put all bodies where the joints have them, with their velocities."""
        model = self._model
        base = np.eye(4)
        base[:3, :3], base[:3, 3] = rotation_from_quaternion(state.base_quaternion), state.base_position
        poses = link_poses(model, state.position, base)
        linear, angular = np.zeros((len(poses), 3)), np.zeros((len(poses), 3))  # of the links' origins
        if model.floating:
            linear[0], angular[0] = state.base_linear, state.base_angular
        for i, joint in enumerate(model.joints):
            arm = poses[i + 1][:3, 3] - poses[joint.parent][:3, 3]
            rate = poses[i + 1][:3, :3] @ joint.axis * state.velocity[i]
            linear[i + 1] = linear[joint.parent] + np.cross(angular[joint.parent], arm)
            angular[i + 1] = angular[joint.parent]
            (linear if joint.prismatic else angular)[i + 1] += rate
        self._place(poses, linear, angular)

    def _place(self, poses: Array, linear: Array, angular: Array) -> None:
        for link, pose, v, w in zip(self.links, poses, linear, angular, strict=True):
            arm = pose[:3, :3] @ link.com
            ode.dBodySetPosition(link.body, *(pose[:3, 3] + arm))
            ode.dBodySetQuaternion(link.body, real_array(*quaternion_from_rotation(pose[:3, :3])))
            ode.dBodySetLinearVel(link.body, *(v + np.cross(w, arm)))
            ode.dBodySetAngularVel(link.body, *w)
            ode.dBodySetForce(link.body, 0.0, 0.0, 0.0)
            ode.dBodySetTorque(link.body, 0.0, 0.0, 0.0)

    def read_joints(self, position: Array, velocity: Array) -> float:
        """Write the joints' positions and velocities; positions within half a turn of those that are there.

        Returns the largest speed, infinite where one is not a number.
        """
        fastest = 0.0
        for i, (joint, before) in enumerate(zip(self.joints, position.tolist(), strict=True)):
            found = joint.position(joint.joint)
            if not self._model.joints[i].prismatic:
                found += tau * round((before - found) / tau) if isfinite(before - found) else 0.0
            position[i] = found
            velocity[i] = rate = joint.rate(joint.joint) if joint.rate is not None else self._sliding(i)
            if not -fastest <= rate <= fastest:
                fastest = abs(rate) if rate == rate else inf
        return fastest

    def _sliding(self, i: int) -> float:
        """The velocity of a slider [m/s]: of the child against the point of the parent that it passes."""
        child, parent, axis = self.links[i + 1], self.links[self._model.joints[i].parent], real_array(0, 0, 0, 0)
        ode.dJointGetSliderAxis(self.joints[i].joint, axis)
        carried = parent.linear + np.cross(parent.angular, child.position - parent.position)
        return float((child.linear - carried) @ axis[:3])

    def read_base(self, base: Array) -> None:
        """Write the row of `Simulation.read`."""
        root = self.links[0]
        (x, y, z), (a, b, c) = _turned(root.rotation, root.com), root.angular.tolist()
        base[:3] = root.position
        base[:3] -= (x, y, z)
        base[3:7] = root.quaternion
        base[7:10] = root.linear
        base[7:10] -= (b * z - c * y, c * x - a * z, a * y - b * x)
        base[10:] = a, b, c

    def braking(self, bounds: Sequence[float]) -> Array:
        """What the brakes did in the last step [N·m or N], of those with a bound. Shape (n,)."""
        out = np.zeros(len(self.joints))
        for i, bound in enumerate(bounds):
            if bound == 0.0:
                continue
            made, joint = self.joints[i], self._model.joints[i]
            axis = real_array(0, 0, 0, 0)
            (ode.dJointGetSliderAxis if joint.prismatic else ode.dJointGetHingeAxis)(made.joint, axis)
            load = made.load.force1 if joint.prismatic else made.load.torque1
            out[i] = sum(a * b for a, b in zip(axis[:3], load[:3], strict=True))
        return out

    def held(self) -> Model:
        """The machine as ODE holds it now, on a fixed base: every link's frame in its joint, with the body's axes."""
        found, axes = self._bodies()
        turns = [link.rotation.reshape(3, 4)[:, :3] for link in self.links]
        origins = [found[0].com, *(axis.anchor for axis in axes)]
        links, joints = [], []
        for k, (link, body, turn) in enumerate(zip(self._model.links, found, turns, strict=True)):
            com, inertia = turn.T @ (body.com - origins[k]), turn.T @ body.inertia @ turn
            links.append(replace(link, mass=body.mass, com=com, inertia=inertia))
        for i, (joint, axis) in enumerate(zip(self._model.joints, axes, strict=True)):
            up, origin = turns[axis.parent], np.eye(4)
            origin[:3, :3] = up.T @ turns[i + 1]
            origin[:3, 3] = up.T @ (origins[i + 1] - origins[axis.parent])
            joints.append(replace(joint, origin=origin, axis=turns[i + 1].T @ axis.direction))
        return replace(self._model, links=tuple(links), joints=tuple(joints))

    def inertia_and_bias(self, speed: Array, gravity: Array) -> tuple[Array, Array]:
        """M without armature, and c, from the poses, masses and axes that ODE holds. Shapes (nv, nv) and (nv,)."""
        found, axes = self._bodies()
        root = self.links[0]
        origin = root.position - _turned(root.rotation, root.com) if self._model.floating else None
        return inertia_and_bias(found, axes, origin, speed, gravity)

    def _bodies(self) -> tuple[list[Body], list[Axis]]:
        """The bodies and axes that ODE holds, in world axes."""
        found, axes = [], []
        for link in self.links:
            mass, turn = Mass(), link.rotation.reshape(3, 4)[:, :3]
            ode.dBodyGetMass(link.body, ctypes.byref(mass))
            inertia = np.array(mass.inertia).reshape(3, 4)[:, :3]
            found.append(Body(mass.mass, link.position.copy(), turn @ inertia @ turn.T))
        for i, (made, joint) in enumerate(zip(self.joints, self._model.joints, strict=True)):
            direction, anchor = real_array(0, 0, 0, 0), real_array(*found[i + 1].com, 0)
            if joint.prismatic:
                ode.dJointGetSliderAxis(made.joint, direction)
            else:
                ode.dJointGetHingeAxis(made.joint, direction)
                ode.dJointGetHingeAnchor(made.joint, anchor)
            axes.append(Axis(joint.prismatic, joint.parent, np.array(anchor[:3]), np.array(direction[:3])))
        return found, axes


def _turned(rotation: Array, vector: Array) -> tuple[float, float, float]:
    """A link's vector in world axes; plain floats, because three elements are too few for numpy."""
    a, b, c, _, d, e, f, _, g, h, i, _ = rotation.tolist()
    x, y, z = vector.tolist()
    return a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z


def _link(world: int, link: Link, moves: bool) -> OdeLink:
    body = ode.dBodyCreate(world)
    rows = np.zeros((3, 4))
    rows[:, :3] = link.inertia
    if moves:
        if link.mass <= 0 or np.linalg.eigvalsh(link.inertia)[0] <= 0:  # ODE would end the process
            raise Unsupported(
                f"ode needs a mass and three moments of inertia above zero, and link {link.name} has {link.mass:g} kg "
                f"and {', '.join(f'{x:g}' for x in np.linalg.eigvalsh(link.inertia))} kg·m²; give it an inertia"
            )
        ode.dBodySetMass(body, ctypes.byref(Mass(link.mass, real_array(0, 0, 0, 0), real_array(*rows.ravel()))))
    else:
        ode.dBodySetKinematic(body)
    ode.dBodySetGyroscopicMode(body, 1)
    ode.dBodySetFiniteRotationMode(body, 1)
    return OdeLink(
        body,
        np.array(link.com, dtype=float),
        view(ode.dBodyGetPosition(body), 3),
        view(ode.dBodyGetQuaternion(body), 4),
        view(ode.dBodyGetRotation(body), 12),
        view(ode.dBodyGetLinearVel(body), 3),
        view(ode.dBodyGetAngularVel(body), 3),
    )


def _hinge(world: int, child: int, parent: int, axis: Array, anchor: Array) -> OdeJoint:
    joint = ode.dJointCreateHinge(world, None)
    ode.dJointAttach(joint, child, parent)
    ode.dJointSetHingeAnchor(joint, *anchor)
    ode.dJointSetHingeAxis(joint, *axis)
    rotor, brake = (_motor(ANGULAR, world, child, parent, axis) for _ in range(2))
    return OdeJoint(
        joint,
        rotor,
        brake,
        _feedback(brake),
        ode.dJointGetHingeAngle,
        ode.dJointGetHingeAngleRate,
        ode.dJointAddHingeTorque,
        ode.dJointSetAMotorParam,
    )


def _slider(world: int, child: int, parent: int, axis: Array, _: Array) -> OdeJoint:
    joint = ode.dJointCreateSlider(world, None)
    ode.dJointAttach(joint, child, parent)
    ode.dJointSetSliderAxis(joint, *axis)
    rotor, brake = (_motor(LINEAR, world, child, parent, axis) for _ in range(2))
    return OdeJoint(
        joint,
        rotor,
        brake,
        _feedback(brake),
        ode.dJointGetSliderPosition,
        None,
        ode.dJointAddSliderForce,
        ode.dJointSetLMotorParam,
    )


def _motor(kind: MotorCalls, world: int, child: int, parent: int, axis: Array) -> int:
    """A motor about or along an axis that the parent carries."""
    create, set_axes, set_axis = kind
    motor: int = create(world, None)
    ode.dJointAttach(motor, child, parent)
    set_axes(motor, 1)
    set_axis(motor, 0, 1, *axis)
    return motor


def _feedback(motor: int) -> Feedback:
    """Where ODE writes what the motor does to the child."""
    load = Feedback()
    ode.dJointSetFeedback(motor, ctypes.byref(load))
    return load
