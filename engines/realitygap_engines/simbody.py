"""Simbody, from the wheel of OpenSim, which is built on it: generalized coordinates, recursive order-n algorithms.

How it solves: accelerations by Simbody's articulated-body recursion under its own gravity and the efforts it is handed.
Simbody's integrators choose their steps themselves (OpenSim's `Manager`), so that the step is the harness's
(`law.stepped`). Its contact models are forces of Hertz's springs at the state before the step, and their friction gives
way in proportion to the slip. The best of them at 1 ms, Hunt and Crossley's at 1e8 Pa, lets a block that should stay on
a slope creep at 2.8e-3 m/s and a ball that drops from 0.1 m sink in by 1.8 mm; the ground of `law.ground` 1.7e-7 m/s
and 1.2e-7 m (`tests/bench_simbody_ground.py`). So the ground, and all of the joint law, come from `law.joints`.
Where it lies by default: OpenSim logs to the console and into `opensim.log` in the working folder, takes no name with
a slash or a space, turns a pin about z and a slider along x only, and gives a floating base Euler angles, whose rates
are singular (its accelerations are not, and nothing else is taken from it here).
"""

from functools import cached_property
from importlib.metadata import version
from math import atan2, cos, hypot, sin

import numpy as np
import opensim

from realitygap_engines.engine import Capability, Engine, Physics, Simulation, State
from realitygap_engines.law.mimic import coupled
from realitygap_engines.law.stepped import EMULATED, Stepped
from realitygap_engines.model.robot import Array, Model, frame_along, rotation_from_quaternion

LEVEL = np.array([1.0, 0.0, 0.0, 0.0])


class SimbodySimulation(Stepped):
    """One OpenSim model and its state. See `Simulation`."""

    def __init__(self, model: Model, physics: Physics) -> None:
        super().__init__(model, physics)
        self._zero = _vector(np.zeros(len(self._force)))
        self._build(LEVEL)
        self.settings["base coordinates"] = "body-fixed x-y-z angles, for the pose only" if model.floating else "none"
        n = len(model.joints)
        self.reset(State(np.zeros(n), np.zeros(n)))

    def _build(self, mounted: Array) -> None:
        """The model anew, for a fixed base of this orientation: it is Simbody's ground then, and gravity turns."""
        self._mounted = mounted.copy()
        self._model, joints = _tree(self.model, rotation_from_quaternion(mounted).T @ self.physics.gravity)
        self._state = state = self._model.initSystem()
        self._matter = self._model.getMatterSubsystem()
        state.setQ(opensim.Vector(state.getNQ(), 0.0))
        q, u = [], []
        for joint in joints:  # where it is in the state, as the state shows
            coordinate = joint.get_coordinates(0)
            for mark in (1.0, 0.0):
                coordinate.setValue(state, mark, False)
                coordinate.setSpeedValue(state, mark)
                if mark:
                    q.append(int(state.getQ().to_numpy().argmax()))
                    u.append(int(state.getU().to_numpy().argmax()))
        self._q, self._u = np.array(q, dtype=np.int64), np.array(u, dtype=np.int64)
        # Simbody counts rotation first
        self._order = np.concatenate([[3, 4, 5, 0, 1, 2] if self._first else [], self._u]).astype(np.int64)
        self._coordinates, self._speeds = np.zeros(state.getNQ()), np.zeros(state.getNU())
        self._acceleration_of = opensim.Vector(state.getNU(), 0.0), opensim.VectorOfSpatialVec()

    def _mount(self, quaternion: Array) -> None:
        if (quaternion != self._mounted).any():
            self._build(quaternion)

    def _realize(self) -> None:
        """Take the present state over, up to Simbody's stage Dynamics."""
        self._coordinates[self._q] = self._position
        self._speeds[self._u] = self._velocity
        if self._first:
            w, x, y, z = self._base[3:7].tolist()
            self._coordinates[:3] = _angles(w, x, y, z)
            self._coordinates[3:6] = self._base[:3]
            self._speeds[:3], self._speeds[3:6] = self._base[10:], self._base[7:10]
        self._state.setQ(_vector(self._coordinates))
        self._state.setU(_vector(self._speeds))
        self._model.realizeDynamics(self._state)

    def _acceleration(self, force: Array) -> Array:
        self._realize()
        found, of_bodies = self._acceleration_of
        given = np.empty_like(force)
        given[self._order] = force
        self._matter.calcAccelerationIgnoringConstraints(
            self._state, _vector(given), self._model.getGravityBodyForces(self._state), found, of_bodies
        )
        acceleration: Array = found.to_numpy()[self._order]
        return acceleration

    def mass_matrix(self) -> Array:
        self._realize()
        found = opensim.Matrix()
        self._matter.calcM(self._state, found)
        matrix: Array = found.to_numpy()[np.ix_(self._order, self._order)]
        return matrix

    def bias(self) -> Array:
        return self._effort(self._zero)

    def _effort(self, acceleration: "opensim.Vector") -> Array:
        """What an acceleration, in Simbody's order, takes at the present state."""
        self._realize()
        found = opensim.Vector()
        self._matter.calcResidualForceIgnoringConstraints(
            self._state, self._zero, self._model.getGravityBodyForces(self._state), acceleration, found
        )
        effort: Array = found.to_numpy()[self._order]
        return effort

    def _inverse(self, start: State, position: Array, velocity: Array, acceleration: Array) -> Array:
        self.reset(start)
        out, row = np.empty_like(position), np.zeros(position.shape[1])
        for k in range(len(position)):
            self._position[:], self._velocity[:], row[self._order] = position[k], velocity[k], acceleration[k]
            out[k] = self._effort(_vector(row))
        return out

    def close(self) -> None:
        self._model = self._state = self._matter = None


def _vector(values: Array) -> "opensim.Vector":
    return opensim.Vector.createFromMat(values)


def _angles(w: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Rotations about the body's x, y and z axes, in that order, that make up a unit quaternion.

    The last is taken after the first, so that together they are right where the middle one is a quarter turn.
    """
    first = atan2(2 * (w * x - y * z), 1 - 2 * (x * x + y * y))
    a, b, c = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    s, t = sin(first), cos(first)
    last = atan2(
        t * 2 * (x * y + w * z) + s * 2 * (x * z - w * y),
        t * (1 - 2 * (x * x + z * z)) + s * 2 * (y * z + w * x),
    )
    return first, atan2(c, hypot(a, b)), last


def _tree(model: Model, gravity: Array) -> "tuple[opensim.Model, list[opensim.Joint]]":
    """The robot in OpenSim, and the joints that are the model's."""
    tree = opensim.Model()
    tree.setName("robot")
    tree.setGravity(opensim.Vec3(*gravity.tolist()))
    bodies = [tree.getGround()]
    if model.floating:
        bodies = [_body(tree, model, 0)]
        at = opensim.Vec3(0.0)
        tree.addJoint(opensim.FreeJoint("base", tree.getGround(), at, at, bodies[0], at, at))
    joints = []
    for i, joint in enumerate(model.joints):
        body = _body(tree, model, i + 1)
        turn = frame_along(joint.axis)
        if joint.prismatic:
            turn = np.roll(turn, 1, axis=1)
        kind = opensim.SliderJoint if joint.prismatic else opensim.PinJoint
        made = kind(
            f"joint{i}",
            bodies[joint.parent],
            opensim.Vec3(*joint.origin[:3, 3].tolist()),
            _orientation(joint.origin[:3, :3] @ turn),
            body,
            opensim.Vec3(0.0),
            _orientation(turn),
        )
        tree.addJoint(made)
        bodies.append(body)
        joints.append(made)
    return tree, joints


def _body(tree: "opensim.Model", model: Model, i: int) -> "opensim.Body":
    link, m = model.links[i], model.links[i].inertia
    inertia = opensim.Inertia(m[0, 0], m[1, 1], m[2, 2], m[0, 1], m[0, 2], m[1, 2])
    body = opensim.Body(f"link{i}", link.mass, opensim.Vec3(*link.com.tolist()), inertia)
    tree.addBody(body)
    return body


def _orientation(rotation: Array) -> "opensim.Vec3":
    """OpenSim's body-fixed x-y-z angles of a rotation matrix."""
    first = atan2(-rotation[1, 2], rotation[2, 2])
    s, t = sin(first), cos(first)
    last = atan2(t * rotation[1, 0] + s * rotation[2, 0], t * rotation[1, 1] + s * rotation[2, 1])
    return opensim.Vec3(first, atan2(rotation[0, 2], hypot(rotation[0, 0], rotation[0, 1])), last)


class SimbodyEngine(Engine):
    """Simbody. See `Engine`."""

    name = "simbody"

    @cached_property
    def version(self) -> str:
        return version("opensim")

    def capabilities(self) -> dict[str, Capability]:
        return {
            "forward_dynamics": Capability("native", "generalized coordinates, articulated bodies; law.stepped steps"),
            **EMULATED,
        }

    def open(self, model: Model, physics: Physics) -> Simulation:
        return coupled(SimbodySimulation(model, physics))


ENGINE = SimbodyEngine()
__all__ = ["ENGINE", "SimbodyEngine", "SimbodySimulation"]
