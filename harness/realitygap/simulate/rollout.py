"""The time loop: servos and effects drive one simulation through one motion."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from realitygap_engines import Diverged, Simulation, State

from realitygap.robot.drive import STATE, Array
from realitygap.robot.drive_law import arrive
from realitygap.robot.plant import Plant
from realitygap.simulate.commands import Commands
from realitygap.simulate.profile import Told
from realitygap.simulate.start import resting_twist
from realitygap.simulate.steps import Held, Steps
from realitygap.trace.first_order import first_order
from realitygap.trace.trace import Trace


@dataclass
class Rollout:
    """One simulated motion: the trace on every step, and what it cost: `wall` [s] from the first step on."""

    trace: Trace
    steps: int
    wall: float
    settings: dict[str, object] = field(default_factory=dict)


@dataclass
class Stretch:
    """A stretch of a simulated motion on every step, and how long the steps took that ended in it: `wall` [s]."""

    trace: Trace
    wall: float


def rollout(
    simulation: Simulation,
    plant: Plant,
    commands: Commands,
    start: State,
    duration: float,
    *,
    supply: tuple[Array, Array] | None = None,
    joint_effort: bool = False,
    integral: Array | None = None,
) -> Rollout:
    """Simulate from `start` for `duration` [s]; as `rolled`, in one part."""
    steps = steps_of(duration, simulation.physics.timestep)
    (part,) = rolled(
        simulation, plant, commands, start, steps, steps, supply=supply, joint_effort=joint_effort, integral=integral
    )
    return Rollout(part.trace, steps, part.wall, simulation.settings)


def steps_of(duration: float, h: float) -> int:
    """How many steps of length h [s] a duration takes."""
    return max(round(duration / h), 1)


def rolled(
    simulation: Simulation,
    plant: Plant,
    commands: Commands,
    start: State,
    steps: int,
    most: int,
    *,
    supply: tuple[Array, Array] | None = None,
    joint_effort: bool = False,
    integral: Array | None = None,
) -> Iterator[Stretch]:
    """Simulate from `start` for some steps, stretch after stretch, so that a long motion is never held as a whole.

    Args:
        simulation: opened with `plant.machine()`.
        plant: drives, sensors and delays.
        commands: what the servos are told, on the simulation's clock.
        start: the state at time 0.
        steps: how many.
        most: how many are held at a time.
        supply: times [s] and recorded voltages [V], for servos whose supply was recorded.
        joint_effort: whether the trace's effort is the torque on the joint (after friction) or of the motor.
        integral: what PID servos have gathered at time 0 [N·m or N], shape (n,); None is nothing.

    Raises:
        Diverged: at the first step whose state is not finite or too fast.
    """
    h = simulation.physics.timestep
    n = len(plant.model.joints)
    most = max(most, 2)  # of every stretch the last state is told with the next one
    told = Told(commands, plant.drive, steps + 1, h, plant.delay)  # a controller looks at the next step, too
    drive, state = plant.drive, np.zeros(n, STATE)

    held = Held(0, n, min(most, steps) + 2)
    simulation.reset(start)
    simulation.read(held.q[0], held.w[0], held.base[0])
    state["velocity"] = held.w[0]
    state["integral"] = 0.0 if integral is None else integral
    if not held.w[0].any():
        state["rotor"] = resting_twist(plant, commands, held.q[0])
        state["side"] = np.where(drive["stiffness"] > 0.0, 0, np.sign(state["rotor"]))
    taken = Steps(simulation, plant, state, joint_effort)
    done, at = 0, 0  # steps so far, and the row of the newest state
    lagged: Array | None = None
    while done < steps:
        todo = min(most, steps - done)
        command = told.over(held.first, at + todo + 1)
        times = np.arange(done, done + todo) * h
        volts = np.zeros(todo) if supply is None else np.interp(times, *supply)
        try:
            last, wall = taken.take(held, at, command, volts)
        except Diverged as error:
            raise Diverged(error.time, error.joint, error.what) from None
        held.check(plant.model.joint_names, h, last)
        done, at = done + todo, at + todo
        # what a row tells takes the next row's log, so that the last two rows are told with the next stretch
        if done == steps:
            arrive(drive, state, held.q[at], held.w[at], held.dry[at], h, held.log[at])
        trace, lagged = _trace(plant, h, held, at if done == steps else at - 1, command, lagged, joint_effort)
        yield Stretch(trace, wall)
        if done < steps:
            held.keep(at - 1)
            at = 1


def _trace(
    plant: Plant, h: float, held: Held, rows: int, command: Array, lagged: Array | None, of_joint: bool
) -> tuple[Trace, Array | None]:
    """The signals of the first rows, and the last velocity that the sensor told.

    They are at the times of the positions: velocities sit half a step before, so neighbours are averaged.
    """
    drive, log, w = plant.drive, held.log[: rows + 1], held.w[: rows + 1]
    rotor = 0.5 * (log["rotor"][:-1] + log["rotor"][1:])
    middle = np.where(drive["stiffness"] > 0, rotor, 0.5 * (w[:-1] + w[1:]))  # of the encoder
    effort = log["motor"][:-1] - log["emf"][:-1] * rotor
    if of_joint:
        separate = (drive["stiffness"] > 0) | (drive["backlash"] > 0)
        friction = held.dry[1 : rows + 1] + log["lean"][:-1] - log["drag"][:-1] * middle
        effort = np.where(separate, log["transmitted"][1:], effort + friction)
    if drive["hysteresis"].any():
        effort = effort - drive["hysteresis"] * np.tanh(middle / drive["hysteresis_onset"])
    told = sensed(middle, plant.velocity_lag, h, lagged)
    floating = plant.model.floating
    b = held.base[:rows].copy() if floating else held.base[:0]
    trace = Trace(
        time=np.arange(held.first, held.first + rows, dtype=np.float64) * h,
        joints=tuple(plant.model.joint_names),
        position=log["encoder"][:rows] - drive["offset"],
        velocity=told * plant.velocity_scale,
        effort=effort,
        command=command[:rows],
        base_position=b[:, :3] if floating else None,
        base_quaternion=b[:, 3:7] if floating else None,
        base_linear=b[:, 7:10] if floating else None,
        base_angular=b[:, 10:13] if floating else None,
    )
    return trace, told[-1] if rows else lagged


def sensed(velocity: Array, lag: Array, h: float | Array, before: Array | None = None) -> Array:
    """The velocity after each joint's first-order low-pass of time `lag` [s], exact for a velocity held over a step.

    `h` is the time since the sample before [s], one for all or Shape (t,); `before` what the low-pass told there, shape
    (n,), None where there was none.
    """
    if not lag.any() or not len(velocity):
        return velocity
    out = velocity.copy()
    first = velocity[0] if before is None else before
    for j in np.flatnonzero(lag > 0):
        keep = np.exp(-np.asarray(h) / lag[j])
        out[:, j] = first_order((1 - keep) * velocity[:, j], keep, float(first[j]))
    return out
