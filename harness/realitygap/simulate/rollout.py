"""The time loop: servos and effects drive one simulation through one motion."""

import time as clock
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import chain, repeat

import numpy as np
from numpy.typing import NDArray
from realitygap_engines import Diverged, Simulation, State

from realitygap.robot.drive import LOG, STATE, Array
from realitygap.robot.drive_law import arrive, drive_effort
from realitygap.robot.effort_map import packed
from realitygap.robot.law.effort_map import add_mapped
from realitygap.robot.plant import Plant
from realitygap.simulate.commands import Commands
from realitygap.simulate.profile import told
from realitygap.trace.trace import Trace

TOO_FAST = 1e5
"""A joint or base velocity beyond this [rad/s or m/s] is a blow-up."""
CHECK_EVERY = 250
"""Steps between looks for a blow-up, which is located exactly afterwards."""


@dataclass
class Rollout:
    """One simulated motion: the trace on every step, and what it cost: `wall` [s] from the first step on."""

    trace: Trace
    steps: int
    wall: float
    settings: dict[str, object] = field(default_factory=dict)


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
    """Simulate from `start` for `duration` [s].

    Args:
        simulation: opened with `plant.machine()`.
        plant: drives, sensors and delays.
        commands: what the servos are told, on the simulation's clock.
        start: the state at time 0.
        duration: how long [s].
        supply: times [s] and recorded voltages [V], for servos whose supply was recorded.
        joint_effort: whether the trace's effort is the torque on the joint (after friction) or of the motor.
        integral: what PID servos have gathered at time 0 [N·m or N], shape (n,); None is nothing.

    Raises:
        Diverged: at the first step whose state is not finite or too fast.
    """
    h = simulation.physics.timestep
    n = len(plant.model.joints)
    steps = max(round(duration / h), 1)
    q, w = np.empty((steps + 1, n)), np.empty((steps + 1, n))
    base = np.zeros((steps + 1, 13))
    log, dry = np.zeros((steps + 1, n), LOG), np.zeros((steps + 1, n))
    command = told(commands, plant.drive, steps, h, plant.delay)
    volts = np.zeros(steps) if supply is None else np.interp(np.arange(steps) * h, *supply)
    effort, damping, friction = np.zeros(n), np.zeros(n), np.zeros(n)
    drive, state = plant.drive, np.zeros(n, STATE)
    wants_dry = joint_effort or any(drive[name].any() for name in ("load", "load_static", "backlash"))
    wants_dry |= any("load" in one.variables for one in plant.maps)
    inertia = plant.inertia()
    mapped, (maps, numbers) = bool(plant.maps), packed(plant.maps)

    simulation.reset(start)
    simulation.read(q[0], w[0], base[0])
    state["velocity"] = w[0]
    state["integral"] = 0.0 if integral is None else integral
    began = clock.perf_counter()
    # what a step ends with the next one begins with: every row is taken out of its array once
    upcoming = chain(command[1:], command[-1:])
    bases = base[1:] if plant.model.floating else repeat(base[0])
    drags = dry[1:] if wants_dry else repeat(dry[0])
    rows = zip(upcoming, volts.tolist(), log, q[1:], w[1:], bases, drags, strict=False)
    c, qk, wk, dk = command[0], q[0], w[0], dry[0]
    step, read, dry_friction, efforts = simulation.step, simulation.read, simulation.dry_friction, plant.efforts
    beside, look = mapped or bool(efforts), 0
    try:
        for k, (c1, v, lk, q1, w1, b1, d1) in enumerate(rows):
            t = k * h
            drive_effort(drive, state, c, c1, qk, wk, dk, inertia, v, t, h, effort, damping, friction, lk)
            if beside:
                if mapped:
                    add_mapped(maps, numbers, drive, state, c, wk, inertia, v, t, h, effort, damping, lk)
                for law in efforts:
                    effort += law(t, qk, wk)
            step(effort, damping, friction)
            read(q1, w1, b1)
            if wants_dry:
                d1[:] = dry_friction()
            if k == look:
                look += CHECK_EVERY
                if not _sane(w1, b1):
                    break
                if k == 0:
                    began = clock.perf_counter()  # anew, because the first step may compile
            c, qk, wk, dk = c1, q1, w1, d1
    except Diverged as error:
        raise Diverged(error.time, error.joint, error.what) from None
    wall = clock.perf_counter() - began
    _raise_if_diverged(plant.model.joint_names, q, w, base, h, min(k + 1, steps))
    arrive(drive, state, q[steps], w[steps], dry[steps], h, log[steps])
    trace = _trace(plant, h, w, base, log, dry if joint_effort else None, command)
    return Rollout(trace, steps, wall, simulation.settings)


def _sane(w: Array, base: Array) -> bool:
    return bool(np.abs(w).max(initial=0.0) < TOO_FAST and np.abs(base).max() < TOO_FAST)


def _raise_if_diverged(joints: Sequence[str], q: Array, w: Array, base: Array, h: float, done: int) -> None:
    bad = ~((np.abs(w[: done + 1]) < TOO_FAST) & np.isfinite(q[: done + 1]))
    bad_base = ~(np.abs(base[: done + 1]) < TOO_FAST).all(axis=1)
    first = np.flatnonzero(bad.any(axis=1) | bad_base)
    if first.size:
        k = int(first[0])
        joint = joints[int(np.argmax(bad[k]))] if bad[k].any() else "base"
        raise Diverged(k * h, joint, "the state is not finite or faster than a robot can be")


def _trace(
    plant: Plant, h: float, w: Array, base: Array, log: NDArray[np.void], dry: Array | None, command: Array
) -> Trace:
    """Signals at the times of the positions: velocities sit half a step before, so neighbours are averaged."""
    drive, steps = plant.drive, command.shape[0]
    rotor = 0.5 * (log["rotor"][:-1] + log["rotor"][1:])
    middle = np.where(drive["stiffness"] > 0, rotor, 0.5 * (w[:-1] + w[1:]))  # of the encoder
    effort = log["motor"][:-1] - log["emf"][:-1] * rotor
    if dry is not None:
        separate = (drive["stiffness"] > 0) | (drive["backlash"] > 0)
        turned = drive["friction_periods"] * log["encoder"][:-1] + drive["friction_phase"]
        lean = drive["lean"] * (1 + drive["friction_ripple"] * np.sin(turned))
        effort = np.where(separate, log["transmitted"][1:], effort + dry[1:] + lean - drive["viscous"] * middle)
    velocity = sensed(middle, plant.velocity_lag, h) * plant.velocity_scale
    floating = plant.model.floating
    b = base[:steps]
    return Trace(
        time=np.arange(steps, dtype=np.float64) * h,
        joints=tuple(plant.model.joint_names),
        position=log["encoder"][:steps] - drive["offset"],
        velocity=velocity,
        effort=effort,
        command=command,
        base_position=b[:, :3] if floating else None,
        base_quaternion=b[:, 3:7] if floating else None,
        base_linear=b[:, 7:10] if floating else None,
        base_angular=b[:, 10:13] if floating else None,
    )


def sensed(velocity: Array, lag: Array, h: float | Array) -> Array:
    """The velocity after each joint's first-order low-pass of time `lag` [s], exact for a velocity held over a step.

    `h` is the time since the sample before [s], one for all or Shape (t,).
    """
    if not lag.any():
        return velocity
    out, steps = velocity.copy(), np.broadcast_to(h, len(velocity))
    for j in np.flatnonzero(lag > 0):
        keep = np.exp(-steps / lag[j])
        state = velocity[0, j]
        for k in range(len(velocity)):
            state = keep[k] * state + (1 - keep[k]) * velocity[k, j]
            out[k, j] = state
    return out
