"""A state in the middle of a motion, as readings tell it: where a simulation may start again from what was measured."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from realitygap_engines import State
from realitygap_engines.model.robot import link_poses, lowest_point, rotation_from_quaternion
from scipy.spatial.transform import Rotation

from realitygap.robot.drive import Array
from realitygap.robot.plant import Plant
from realitygap.simulate.flight import rotation_of
from realitygap.simulate.start import start_state


@dataclass(frozen=True)
class Moving:
    """Position, velocity and acceleration at one time, and the standard errors of the first two. Shape (k,) each."""

    position: Array
    velocity: Array
    acceleration: Array
    position_error: Array
    velocity_error: Array

    def nudged(self, random: np.random.Generator) -> Moving:
        """Another one that the readings allow as well."""
        return replace(
            self,
            position=self.position + self.position_error * random.standard_normal(len(self.position)),
            velocity=self.velocity + self.velocity_error * random.standard_normal(len(self.velocity)),
        )


@dataclass(frozen=True)
class Midway:
    """A measured state.

    Attributes:
        joints: the readings of joints [rad or m]. Shape (n,).
        place: the base's origin in world axes [m], shape (3,); None for a fixed base.
        turn: how the base turns, world axes [rad]: its position is a small rotation from `quaternion`. Shape (3,); None
            for a fixed base.
        quaternion: of the base, w x y z. Shape (4,).
    """

    joints: Moving
    place: Moving | None = None
    turn: Moving | None = None
    quaternion: Array | None = None

    def nudged(self, random: np.random.Generator) -> Midway:
        """Another state that the readings allow as well."""
        place, turn = (None if m is None else m.nudged(random) for m in (self.place, self.turn))
        return replace(self, joints=self.joints.nudged(random), place=place, turn=turn)

    @property
    def errors(self) -> dict[str, tuple[Array, Array]]:
        """Standard errors of where it is and of how fast it goes, by signal of a trace; a quaternion's are half an
        angle's.
        """
        out = {"position": (self.joints.position_error, self.joints.velocity_error)}
        if self.place is not None and self.turn is not None:
            angle, rate = (np.sqrt(np.mean(e**2)) for e in (self.turn.position_error, self.turn.velocity_error))
            out["base_position"] = self.place.position_error, self.place.velocity_error
            out["base_quaternion"] = np.full(4, 0.5 * angle), np.full(4, 0.5 * rate)
        return out

    def state(self, plant: Plant, timestep: float) -> State:
        """The state for a simulation with this step [s], whose velocities sit half a step before its positions."""

        def early(moving: Moving) -> Array:
            return np.asarray(moving.velocity - 0.5 * timestep * moving.acceleration)

        position = self.joints.position + plant.drive["offset"]
        if self.place is None or self.turn is None or self.quaternion is None:
            state = start_state(plant, position)
        else:
            turned = Rotation.from_rotvec(self.turn.position) * rotation_of(self.quaternion)
            state = start_state(
                plant,
                position,
                base_position=self.place.position,
                base_quaternion=np.roll(turned.as_quat(), 1),
                base_linear=early(self.place),
                base_angular=early(self.turn),
            )
        state.velocity = early(self.joints)
        if plant.model.floating and plant.ground is not None and plant.ground.stiffness is None:
            pose = np.eye(4)  # a reading below rigid ground is the sensor's
            pose[:3, :3] = rotation_from_quaternion(state.base_quaternion)
            pose[:3, 3] = state.base_position
            state.base_position[2] -= min(lowest_point(plant.model, link_poses(plant.model, position, pose)), 0.0)
        return state
