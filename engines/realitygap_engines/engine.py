"""The contract between the harness and a physics engine.

An engine turns a `Model` and its `Physics` into a `Simulation`; a simulation advances by one step under
generalized efforts and is read back. Nothing here knows of recordings, servos or metrics.

The joint law is the same in every engine. Over one step of length h from joint velocity v to v',

    effort[j] - damping[j]*v'[j] + dry[j],     abs(dry[j]) <= friction[j]

acts on joint j, where `dry` opposes the motion and holds the joint (v' = 0) when it can. Damping is implicit, so
that it is stable at any size; armature is part of the model. An engine without one of these natively uses
`law.joints`, which solves the same law outside the engine.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from realitygap_engines.errors import Unsupported
from realitygap_engines.model.robot import Model

Array = NDArray[np.float64]
GRAVITY = 9.81
"""[m/s²]"""


@dataclass(frozen=True)
class Ground:
    """A horizontal plane at z = 0.

    `friction` is the coefficient of the *pair* robot-ground. `stiffness` [N/m] and `damping` [N·s/m] act per
    contact point; None is rigid ground.
    """

    friction: float = 0.8
    stiffness: float | None = None
    damping: float | None = None


@dataclass(frozen=True)
class Physics:
    """How to simulate: `timestep` [s], solver effort (None: the engine's default), ground and gravity [m/s²]."""

    timestep: float = 1e-3
    solver_iterations: int | None = None
    ground: Ground | None = None
    gravity: tuple[float, float, float] = (0.0, 0.0, -GRAVITY)


@dataclass
class State:
    """A full state of the model. Joints in the model's order; angles in rad.

    `base_position` (3,) [m] is the origin of the base link, `base_quaternion` (4,) w x y z its orientation,
    `base_linear` (3,) [m/s] the velocity of that origin and `base_angular` (3,) [rad/s] the angular velocity, both
    in world axes. Ignored for a fixed base except for position and quaternion at reset.
    """

    position: Array
    velocity: Array
    base_position: Array = field(default_factory=lambda: np.zeros(3))
    base_quaternion: Array = field(default_factory=lambda: np.array([1.0, 0.0, 0.0, 0.0]))
    base_linear: Array = field(default_factory=lambda: np.zeros(3))
    base_angular: Array = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True)
class Capability:
    """What an engine does about one piece of physics: `native`, `emulated` or `no`, and how, in words."""

    level: str
    how: str


@dataclass(frozen=True)
class Native:
    """A simulation's own memory and its step as a C function, for loops in compiled code.

    What `Simulation.step` and `read` do, done without Python: write `effort`, `damping` and `friction`, call the step,
    read `position` and `velocity`. The numbers are the same to the last bit.

    Attributes:
        functions: two C functions by ctypes: the step, of two addresses; and one that copies numbers, of an address to,
            an address from, and how many. In one tuple, because compiled code takes single ones for one another.
        model: the address of the engine's model.
        data: the address of its state.
        effort, damping, friction: of the joint law, written before a step. Shape (n,) each.
        position, velocity: of the joints. Shape (n,) each.
        base: pose and velocity of a floating base in the engine's own form; of none, empty. Shapes (p,), (v,).
        in_world: turns rows of them, Shape (t, 13), into what `Simulation.read` writes, in place.
        dry: holds the address of what dry friction gave in the last step, one number for every joint that has any, in
            their order. Shape (1,), of int.
    """

    functions: tuple[Any, Any]
    model: int
    data: int
    effort: Array
    damping: Array
    friction: Array
    position: Array
    velocity: Array
    base: tuple[Array, Array]
    in_world: Callable[[Array], None]
    dry: NDArray[np.int64]


class Simulation(ABC):
    """One open simulation. Created by `Engine.open`; closed with `close()` or as a context manager.

    Attributes:
        model: the machine being simulated.
        physics: the settings it was opened with.
        settings: what the adapter really set, by the engine's own names; written to `manifest.json`.
    """

    model: Model
    physics: Physics
    settings: dict[str, object]

    @abstractmethod
    def reset(self, state: State) -> None:
        """Set the full state, forget all history (warm starts, contact caches) and start the clock at 0."""

    @abstractmethod
    def step(self, effort: Array, damping: Array, friction: Array) -> None:
        """Advance one timestep under the joint law above. All Shape (n,), in the model's joint order.

        Raises:
            Diverged: where the engine itself notices a blow-up (the rollout checks the rest).
        """

    @abstractmethod
    def read(self, position: Array, velocity: Array, base: Array) -> None:
        """Write the joint positions and velocities into Shape (n,) arrays and the base into Shape (13,).

        The base is position (3), quaternion w x y z (4), linear velocity of the base link's origin (3) and angular
        velocity (3) in world axes; untouched for a fixed base.
        """

    def native(self) -> Native | None:
        """What compiled code needs to step this simulation; None where only Python can."""
        return None

    @abstractmethod
    def dry_friction(self) -> Array:
        """The dry friction effort of the last step, signed [N·m or N]; valid until the next one. Shape (n,)."""

    @abstractmethod
    def mass_matrix(self) -> Array:
        """The joint-space inertia at the present state. Shape (nv, nv).

        A floating base comes first, as the linear velocity of the base link's origin in world axes and the angular
        velocity in world axes, then the joints in the model's order. Includes armature only where that is native.
        """

    @abstractmethod
    def bias(self) -> Array:
        """Coriolis, centrifugal and gravity terms c of M·a + c = effort, in the coordinates of `mass_matrix`.

        Shape (nv,). Here the base acceleration is the time derivative of the base velocity in world axes.
        """

    def inverse_dynamics(self, start: State, position: Array, velocity: Array, acceleration: Array) -> Array:
        """The joint efforts M·a + c that a motion takes on a fixed base, without friction, limits and contact.

        An engine that has this natively overrides `_inverse`; by default it is made of `mass_matrix` and `bias`.

        Args:
            start: tells where the base stands.
            position: of the joints [rad or m]. Shape (t, n).
            velocity: their rates. Shape (t, n).
            acceleration: the rates of those. Shape (t, n).

        Returns:
            Efforts [N·m or N]. Shape (t, n). Afterwards the simulation's state is not defined: `reset` it.

        Raises:
            Unsupported: for a floating base, whose motion and contact forces would have to be known, and for a model
                with armature, which not every engine has.
        """
        if self.model.floating or self.model.armature.any():
            raise Unsupported(
                "inverse dynamics is of a fixed base without armature: what the ground does to a floating one is not "
                "known, and armature is the caller's to add"
            )
        return self._inverse(start, position, velocity, acceleration)

    def _inverse(self, start: State, position: Array, velocity: Array, acceleration: Array) -> Array:
        out = np.empty_like(position)
        for k, (q, v, a) in enumerate(zip(position, velocity, acceleration, strict=True)):
            self.reset(State(q, v, start.base_position, start.base_quaternion))
            out[k] = self.mass_matrix() @ a + self.bias()
        return out

    def close(self) -> None:
        """Free what the engine holds."""

    def __enter__(self) -> "Simulation":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Engine(ABC):
    """A physics engine: its name, version, what it can express, and how to open a model in it."""

    name: str

    @property
    @abstractmethod
    def version(self) -> str:
        """The installed version."""

    @abstractmethod
    def capabilities(self) -> dict[str, Capability]:
        """What the engine can and cannot express, by the names in `CAPABILITIES`."""

    @abstractmethod
    def open(self, model: Model, physics: Physics) -> Simulation:
        """A simulation of the model at its zero state.

        Raises:
            Unsupported: where the engine cannot express what the model or the physics ask for.
        """


CAPABILITIES = {
    "armature": "rotor inertia at the joint",
    "forward_dynamics": "joints that are met exactly, a step that is forward dynamics",
    "joint_damping": "implicit viscous joint damping",
    "joint_friction": "dry joint friction that holds at rest",
    "joint_limits": "position limits",
    "lone_body": "a body without joints whose step is forward dynamics",
    "mimic_joints": "joints that are coupled to others",
    "rigid_ground": "rigid contact with dry friction of the pair",
    "soft_ground": "contact stiffness and damping per point",
    "solver_iterations": "a number of solver iterations",
}
