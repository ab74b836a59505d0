"""Exudyn: a kinematic tree in minimal coordinates, of which Exudyn makes the inertia matrix and the generalized forces.

How it solves: composite rigid bodies and recursive Newton-Euler of its `ObjectKinematicTree`, assembled by its explicit
solver; the accelerations follow by solving with that matrix (Exudyn factorises it the same way, but inside a solver
that sets out anew for every step). Its contact is a penalty between spheres, triangles and markers of bodies in
redundant coordinates, not of a kinematic tree's points on a plane, so that the ground, and all of the joint law, come
from `law.joints`. The step is the harness's (`law.stepped`).
Where it lies by default: a kinematic tree has no free base, only chains of joints about x, y and z, whose angles get
singular. The base is three slides and three hinges here that are at zero in every step: the tree is written down in the
frame in which the base is at that moment, which moves on uniformly, and what turning axes add to the rates of three
hinges is taken off again. Gravity, which is uniform, is added to the base's acceleration. It speaks on the console,
and warns of settings that were renamed.
"""

# mypy: allow-untyped-defs
# (the compiled function takes arrays; its caller is typed)

from functools import cached_property
from importlib.metadata import version

import exudyn
import numpy as np
from exudyn.itemInterface import NodeGenericODE2, ObjectKinematicTree

from realitygap_engines.engine import Capability, Engine, Physics, Simulation, State
from realitygap_engines.law.compiled import compiled
from realitygap_engines.law.mimic import coupled
from realitygap_engines.law.stepped import EMULATED, Stepped
from realitygap_engines.model.robot import Array, Model, frame_along, rotation_from_quaternion

SLIDES = (exudyn.JointType.PrismaticX, exudyn.JointType.PrismaticY, exudyn.JointType.PrismaticZ)
HINGES = (exudyn.JointType.RevoluteX, exudyn.JointType.RevoluteY, exudyn.JointType.RevoluteZ)


class ExudynSimulation(Stepped):
    """One kinematic tree and the solver that evaluates it. See `Simulation`."""

    def __init__(self, model: Model, physics: Physics) -> None:
        super().__init__(model, physics)
        n, first = len(model.joints), self._first
        self._container = exudyn.SystemContainer()
        self._system = system = self._container.AddSystem()
        self._tree = _add_tree(system, model)
        system.Assemble()
        settings = exudyn.SimulationSettings()
        settings.timeIntegration.verboseMode = settings.timeIntegration.verboseModeFile = 0
        settings.timeIntegration.solverType = exudyn.DynamicSolverType.ExplicitEuler
        settings.solution.file.write = False
        self._solver = exudyn.MainSolverExplicit()
        self._solver.InitializeSolver(system, settings)
        self._data = system.systemData
        # a fixed base has no coordinates, and its gravity turns instead
        self._gravity = np.array(physics.gravity) if first else np.zeros(3)
        self._coordinates, self._rates = np.zeros(first + n), np.zeros(first + n)
        self._joints = slice(first, None)
        self._turn = np.eye(first + n)
        self.settings["base coordinates"] = "three slides and hinges, at zero in every step" if first else "none"
        self.reset(State(np.zeros(n), np.zeros(n)))

    def _mount(self, quaternion: Array) -> None:
        gravity = rotation_from_quaternion(quaternion).T @ np.array(self.physics.gravity)
        self._system.SetObjectParameter(self._tree, "gravity", gravity.tolist())

    def _realize(self) -> tuple[Array, Array]:
        """Inertia matrix (nv, nv) and generalized forces (nv,) at the present state, in the frame of the base."""
        self._coordinates[self._joints], self._rates[self._joints] = self._position, self._velocity
        if self._first:
            _face(self._base, self._turn, self._rates)
        self._data.SetODE2Coordinates(self._coordinates)
        self._data.SetODE2Coordinates_t(self._rates)
        self._solver.ComputeMassMatrix(self._system)
        self._solver.ComputeODE2RHS(self._system)
        return self._solver.GetSystemMassMatrix(), self._solver.GetSystemResidual()

    def _acceleration(self, force: Array) -> Array:
        matrix, right = self._realize()
        if not self._first:
            return np.asarray(np.linalg.solve(matrix, right + force))
        found = np.linalg.solve(matrix, right + force @ self._turn)
        acceleration: Array = self._turn @ (found + self._drift())
        acceleration[:3] += self._gravity
        return acceleration

    def _drift(self) -> Array:
        """What the turning axes of the base's hinges add to the accelerations of its angles. Shape (nv,)."""
        out = np.zeros_like(self._rates)
        if self._first:
            a, b, c = self._rates[3:6]
            out[3:6] = b * c, -a * c, a * b
        return out

    def mass_matrix(self) -> Array:
        matrix, _ = self._realize()
        return np.asarray(self._turn @ matrix @ self._turn.T)

    def bias(self) -> Array:
        matrix, right = self._realize()
        fall = self._drift()
        if self._first:
            fall[:3] += self._gravity @ self._turn[:3, :3]
        return np.asarray(-self._turn @ (matrix @ fall + right))

    def _inverse(self, start: State, position: Array, velocity: Array, acceleration: Array) -> Array:
        self.reset(start)
        out = np.empty_like(position)
        for k in range(len(position)):
            self._position[:], self._velocity[:] = position[k], velocity[k]
            matrix, right = self._realize()
            out[k] = matrix @ acceleration[k] - right
        return out

    def close(self) -> None:
        self._container.Reset()


@compiled
def _face(base, turn, rates):
    """Write the base's orientation to `turn` (nv, nv) and its velocity in its own axes to `rates` (nv,)."""
    w, x, y, z = base[3], base[4], base[5], base[6]
    turn[0, 0], turn[0, 1], turn[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    turn[1, 0], turn[1, 1], turn[1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    turn[2, 0], turn[2, 1], turn[2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    for i in range(3):
        for j in range(3):
            turn[3 + i, 3 + j] = turn[i, j]
        rates[i] = turn[0, i] * base[7] + turn[1, i] * base[8] + turn[2, i] * base[9]
        rates[3 + i] = turn[0, i] * base[10] + turn[1, i] * base[11] + turn[2, i] * base[12]


def _add_tree(system: "exudyn.MainSystem", model: Model) -> "exudyn.ObjectIndex":
    """The robot as a kinematic tree; every link's frame is its joint's, with the axis along z."""
    first = 6 if model.floating else 0
    turns = [np.eye(3)] + [frame_along(joint.axis) for joint in model.joints]
    base, bare = [model.links[0]] if first else [], max(first - 1, 0)  # five of the base's joints move nothing
    links = [*base, *model.links[1:]]
    own = turns[0 if first else 1 :]
    size = first + len(model.joints)
    node = system.AddNode(
        NodeGenericODE2(
            referenceCoordinates=[0.0] * size,
            initialCoordinates=[0.0] * size,
            initialCoordinates_t=[0.0] * size,
            numberOfODE2Coordinates=size,
        )
    )
    return system.AddObject(
        ObjectKinematicTree(
            nodeNumber=node,
            gravity=[0.0, 0.0, 0.0],
            jointTypes=[*(SLIDES + HINGES)[:first], *((SLIDES if j.prismatic else HINGES)[2] for j in model.joints)],
            linkParents=[*range(-1, first - 1), *(first - 1 + joint.parent for joint in model.joints)],
            jointTransformations=exudyn.Matrix3DList(
                [np.eye(3)] * first
                + [turns[j.parent].T @ j.origin[:3, :3] @ turn for j, turn in zip(model.joints, turns[1:], strict=True)]
            ),
            jointOffsets=exudyn.Vector3DList(
                [np.zeros(3)] * first + [turns[j.parent].T @ j.origin[:3, 3] for j in model.joints]
            ),
            linkInertiasCOM=exudyn.Matrix3DList(
                [np.zeros((3, 3))] * bare + [t.T @ link.inertia @ t for link, t in zip(links, own, strict=True)]
            ),
            linkCOMs=exudyn.Vector3DList(
                [np.zeros(3)] * bare + [t.T @ link.com for link, t in zip(links, own, strict=True)]
            ),
            linkMasses=[0.0] * bare + [link.mass for link in links],
        )
    )


class ExudynEngine(Engine):
    """Exudyn. See `Engine`."""

    name = "exudyn"

    @cached_property
    def version(self) -> str:
        return version("exudyn")

    def capabilities(self) -> dict[str, Capability]:
        return {
            "forward_dynamics": Capability(
                "native", "minimal coordinates: Exudyn's inertia matrix and forces; solved and stepped in law.stepped"
            ),
            **EMULATED,
        }

    def open(self, model: Model, physics: Physics) -> Simulation:
        return coupled(ExudynSimulation(model, physics))


ENGINE = ExudynEngine()
__all__ = ["ENGINE", "ExudynEngine", "ExudynSimulation"]
