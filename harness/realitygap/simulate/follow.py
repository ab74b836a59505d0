"""Motions that are followed: the effort that a measured motion takes, without integrating anything over time."""

import time as clock
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from realitygap_engines import Physics, State
from realitygap_engines.law.dynamics import Dynamics
from scipy.special import erf

from realitygap.files.errors import InputError
from realitygap.robot.drive_inverse import motor_efforts
from realitygap.robot.effort_map import packed
from realitygap.robot.law.effort_map import map_along
from realitygap.robot.plant import Plant
from realitygap.simulate.inertia import inertias, times
from realitygap.simulate.opened import opened
from realitygap.simulate.rollout import Rollout, sensed
from realitygap.simulate.smooth import Smoothed, smooth
from realitygap.trace.trace import Array, Trace

LEAST = 1e-3
"""The share of its torque constant that a hot motor keeps at least."""
OPEN = 1e-3
"""The share of dry friction that is open at least, however sure the sign of the velocity is."""


@dataclass(frozen=True)
class Followed:
    """A measured motion: readings (t, n) of the joints at times (t,), smoothed when that is first asked for.

    `supply` is times [s] on the same clock and voltages [V], where it was recorded.
    """

    time: Array
    position: Array
    supply: tuple[Array, Array] | None = None

    @cached_property
    def smoothed(self) -> Smoothed:
        """The motion with its derivatives, by `simulate.smooth`."""
        return smooth(self.time, self.position)

    def told(self, joints: list[str]) -> str:
        """A sentence on how the derivatives were got, and how well they are known."""
        found = self.smoothed
        moved = np.flatnonzero(found.bandwidth > 0)
        if not moved.size:
            return "followed: no joint moves"
        band, error = found.bandwidth[moved], np.sqrt(np.mean(found.error[2][:, moved] ** 2, axis=0))
        worst = int(np.argmax(error))
        bands = " to ".join(dict.fromkeys(f"{b:.3g}" for b in (band.min(), band.max())))
        return (
            f"followed: velocities and accelerations by a quintic smoothing spline of {bands} Hz; standard error of "
            f"the acceleration up to {error[worst]:.2g} rad/s² or m/s² ({joints[moved[worst]]})"
        )


def check_clear(plant: Plant, followed: Followed, start: State) -> None:
    """Make sure that no moving link of a fixed robot comes to the ground, where there is one.

    Raises:
        InputError: where one does, because what the ground does to it was not measured.
    """
    if plant.ground is None:
        return
    dynamics = Dynamics(plant.model)
    moving = dynamics.point_end >= 0
    base = np.concatenate([start.base_position, start.base_quaternion, np.zeros(6)])
    still = np.zeros(len(plant.model.joints))
    for time, position in zip(followed.time, followed.smoothed.value[0], strict=True):
        dynamics.update(position + plant.drive["offset"], still, base, np.zeros(3))
        if (dynamics.height[moving] < 0.0).any():
            raise InputError(
                f"ground: the robot touches it at {time:.2f} s; expected `ground: none`, as what it does to a motion "
                "that is followed was not measured"
            )


def check_maps(plant: Plant, supply: bool) -> None:
    """Make sure that what the efforts by table depend on is known where no servo follows a command.

    Raises:
        InputError: for one that depends on the position error, or on a supply that was not recorded.
    """
    for variable in [v for one in plant.maps for v in one.variables]:
        if variable == "error" or (variable == "supply" and not supply):
            what = "no command is followed" if variable == "error" else "no supply was recorded"
            raise InputError(
                f"effects: effort_map over the {variable} where the motion is followed: {what}; take it out"
            )


@dataclass(frozen=True)
class Taken:
    """What a measured motion takes of a plant at its stamps. Shapes (t, n), in N·m or N.

    Attributes:
        motion: the smoothed readings.
        load: what moving the links takes: gravity and inertia, without the rotors.
        motor: effort of the motors, before friction.
        joint: effort on the joints, after friction.
        left: by how much dry friction could be more or less than in `motor`, as a joint is nearly at rest.
        settings: what the engine really set.
    """

    motion: Smoothed
    load: Array
    motor: Array
    joint: Array
    left: Array
    settings: dict[str, object]


def taken(engine: str, plant: Plant, followed: Followed, start: State) -> Taken:
    """What a measured motion takes in one engine; arguments as of `follow`.

    Raises:
        Unsupported: where the engine cannot express the plant.
    """
    motion, n = followed.smoothed, len(plant.model.joints)
    reading, velocity, acceleration = motion.value
    position = reading + plant.drive["offset"]
    model = plant.machine().with_armature(np.zeros(n))
    with opened(engine, model, Physics()) as simulation:
        load = simulation.inverse_dynamics(start, position, velocity, acceleration)
        settings = dict(simulation.settings)
    driven = load - plant.given(motion.time)
    volts = np.zeros(len(motion.time)) if followed.supply is None else np.interp(motion.time, *followed.supply)
    map_along(*packed(plant.maps), motion.time - motion.time[0], reading, velocity, load, volts, driven)
    motor, joint, left = np.empty_like(load), np.empty_like(load), np.empty_like(load)
    motor_efforts(plant.drive, position, velocity, acceleration, motion.error[1], driven, motor, joint, left)
    return Taken(motion, load, motor, joint, left, settings)


def unsure(plant: Plant, found: Taken, start: State, *, of_joint: bool) -> Array:
    """The standard error of the effort that a motion takes, as its derivatives are known no better. Shape (t, n).

    Of a motor's effort dry friction is part, whose sign is known as well as that of the velocity: at rest not at all.
    """
    motion, drive = found.motion, plant.drive
    inertia = inertias(plant, start, motion.value[0]) + np.diag(drive["armature"])
    moving = times(inertia**2, motion.error[2] ** 2) + (drive["viscous"] * motion.error[1]) ** 2
    if of_joint:
        return np.asarray(np.sqrt(moving))
    error = motion.error[1]
    side = np.abs(erf(motion.value[1] / (np.sqrt(2.0) * np.where(error > 0.0, error, np.inf))))
    sure = np.minimum(side, 1.0 - OPEN)
    dry = found.left**2 * (1.0 + sure) / (1.0 - sure)  # bound²·(1 - side²), as left = bound·(1 - side)
    return np.asarray(np.sqrt(moving + dry))


def follow(
    engine: str, plant: Plant, followed: Followed, start: State, *, of_joint: bool, off: bool = False
) -> Rollout:
    """What a measured motion takes in one engine: positions and velocities as smoothed, efforts at the same stamps.

    Args:
        engine: whose inverse dynamics is used.
        plant: the robot with its drives; its base is fixed.
        followed: the measured motion.
        start: tells where the base stands.
        of_joint: whether the trace's effort is the torque on the joint (after friction) or of the motor.
        off: whether the effort is higher by its standard error: what in place of half the step makes the numerical
            floor.

    Raises:
        Unsupported: where the engine cannot express the plant.
    """
    began = clock.perf_counter()
    found = taken(engine, plant, followed, start)
    motion, (reading, velocity, _) = found.motion, found.motion.value
    error = unsure(plant, found, start, of_joint=of_joint) if off else 0.0
    told = 1.0 if of_joint else reported(plant, motion.time - motion.time[0])
    effort = ((found.joint if of_joint else found.motor) + error) * told
    seen = sensed(velocity, plant.velocity_lag, np.diff(motion.time, prepend=motion.time[0])) * plant.velocity_scale
    trace = Trace(motion.time, tuple(plant.model.joint_names), position=reading, velocity=seen, effort=effort)
    settings = found.settings | {
        "motion": "followed: inverse dynamics at the measured stamps, no integration over time",
        "smoother": "quintic smoothing spline, likeliest bandwidth",
        "bandwidth [Hz]": ", ".join(
            f"{j} {b:.2f}" for j, b in zip(plant.model.joint_names, motion.bandwidth, strict=True)
        ),
    }
    return Rollout(trace, len(motion.time), clock.perf_counter() - began, settings)


def reported(plant: Plant, time: Array) -> Array:
    """What an effort that is told from a current shows, over what the motor gives. Shape (t, n).

    The current is effort/torque constant, and the scenario's factor turns it back as if the constant were the factor.
    """
    drive = plant.drive
    known = (drive["current_factor"] > 0) & (drive["torque_constant"] > 0)
    ratio = np.where(known, drive["current_factor"] / np.where(known, drive["torque_constant"], 1.0), 1.0)
    left = np.maximum(1.0 - np.outer(time, np.where(known, drive["heating"], 0.0)), LEAST)
    return np.asarray(ratio / left)
