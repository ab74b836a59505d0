"""Steps of one simulation under its drives: compiled where the engine's step is a C function, else in Python."""

import time as clock
from collections.abc import Sequence
from itertools import chain, repeat

import numpy as np
from numpy.typing import NDArray
from realitygap_engines import Diverged, Simulation
from realitygap_engines.engine import Native
from realitygap_engines.law.compiled import compiled

from realitygap.robot.drive import LOG, Array
from realitygap.robot.drive_law import drive_effort
from realitygap.robot.effort_map import packed
from realitygap.robot.law.effort_map import add_mapped
from realitygap.robot.plant import Plant
from realitygap.simulate.compiled_steps import stepped

TOO_FAST = 1e5
"""A joint or base velocity beyond this [rad/s or m/s] is a blow-up."""
CHECK_EVERY = 250
"""Steps between looks for a blow-up, which is located exactly afterwards."""


class Held:
    """What is held of a simulated motion: some rows from step `first` on, one per state. Shapes (rows, ...)."""

    def __init__(self, first: int, n: int, rows: int) -> None:
        self.first = first
        self.q, self.w = np.empty((rows, n)), np.empty((rows, n))
        self.base = np.zeros((rows, 13))
        self.log, self.dry = np.zeros((rows, n), LOG), np.zeros((rows, n))

    def keep(self, row: int) -> None:
        """Let go of all before a row, which becomes the first, and of all but the one after it."""
        for values in (self.q, self.w, self.base, self.log, self.dry):
            values[:2] = values[row : row + 2].copy()
        self.first += row

    def check(self, joints: Sequence[str], h: float, last: int) -> None:
        """Make sure that no state up to a row is a blow-up.

        Raises:
            Diverged: at the first one that is.
        """
        end = last + 1
        row, joint = blown_up(self.q[:end], self.w[:end], self.base[:end])
        if row >= 0:
            where = joints[joint] if joint >= 0 else "base"
            raise Diverged((self.first + row) * h, where, "the state is not finite or faster than a robot can be")

    def sane(self, row: int) -> bool:
        """Whether a state is none."""
        end = row + 1
        return bool(blown_up(self.q[row:end], self.w[row:end], self.base[row:end])[0] < 0)


@compiled
def blown_up(q, w, base):  # type: ignore[no-untyped-def]
    """The first row that is a blow-up, and the joint that is, -1 for the base; -1 where none is. Shapes (rows, ...)."""
    for k in range(len(w)):
        for j in range(w.shape[1]):
            if not (abs(w[k, j]) < TOO_FAST and np.isfinite(q[k, j])):
                return k, j
        for j in range(base.shape[1]):
            if not abs(base[k, j]) < TOO_FAST:
                return k, -1
    return -1, -1


class Steps:
    """Takes the steps of one simulation.

    Args:
        simulation: opened with `plant.machine()`.
        plant: drives and effects.
        state: of the drives, changed by every step. Shape (n,), of `STATE`.
        joint_effort: whether the dry friction of every step is wanted, because efforts on the joint are.
    """

    def __init__(self, simulation: Simulation, plant: Plant, state: NDArray[np.void], joint_effort: bool) -> None:
        drive = plant.drive
        self.simulation, self.plant, self.state = simulation, plant, state
        self.h, self.inertia, self.maps = simulation.physics.timestep, plant.inertia(), packed(plant.maps)
        self.wants_dry = joint_effort or any(drive[name].any() for name in ("load", "load_static", "backlash"))
        self.wants_dry |= any("load" in one.variables for one in plant.maps)
        self.native = simulation.native()

    def take(self, held: Held, at: int, command: Array, volts: Array) -> tuple[int, float]:
        """Take steps from row `at` on, until their end or a blow-up.

        Args:
            held: gets their states and logs.
            at: the row of the state that they start from.
            command: of every row from the first one on; beyond its end it stays. Shape (rows, n).
            volts: recorded supply voltage [V] at every step. Shape (steps,).

        Returns:
            The row of the last state, and how long the steps took after the motion's first one, which may compile [s].
        """
        time = np.asarray((held.first + at + np.arange(len(volts))) * self.h, dtype=np.float64)
        given = self.plant.given(time)
        if self.native is None:
            return self._in_python(held, at, command, volts, given)
        return self._compiled(self.native, held, at, command, volts, given)

    def _compiled(
        self, native: Native, held: Held, at: int, command: Array, volts: Array, given: Array
    ) -> tuple[int, float]:
        pose, twist = native.base
        told = np.concatenate([command, command[-1:]])
        began, row, end = clock.perf_counter(), at, at + len(volts)
        while row < end:
            start = held.first + row
            last = row + 1 if start == 0 else min(row + CHECK_EVERY, end)
            stepped(
                native.functions, native.model, native.data, native.effort, native.damping, native.friction,
                native.position, native.velocity, pose, twist, native.dry,
                self.plant.drive, self.state, self.inertia, *self.maps, told[row : last + 1],
                volts[row - at : last - at], given[row - at : last - at], self.wants_dry, start, self.h,
                held.q[row : last + 1], held.w[row : last + 1], held.base[row : last + 1], held.dry[row : last + 1],
                held.log[row:last],
            )  # fmt: skip
            if pose.size:
                native.in_world(held.base[row + 1 : last + 1])
            row = last
            if not held.sane(row):
                break
            if start == 0:
                began = clock.perf_counter()
        return row, clock.perf_counter() - began

    def _in_python(self, held: Held, at: int, command: Array, volts: Array, given: Array) -> tuple[int, float]:
        q, w, base, log, dry = held.q, held.w, held.base, held.log, held.dry
        drive, state, inertia, h, (maps, numbers) = self.plant.drive, self.state, self.inertia, self.h, self.maps
        step, read, dry_friction = self.simulation.step, self.simulation.read, self.simulation.dry_friction
        pushed, mapped, wants_dry = bool(self.plant.efforts), bool(self.plant.maps), self.wants_dry
        beside, n, look = mapped or pushed, len(drive), held.first + at
        effort, damping, friction = np.zeros(n), np.zeros(n), np.zeros(n)
        # what a step ends with the next one begins with: every row is taken out of its array once
        upcoming = chain(command[at + 1 :], command[-1:])
        bases = base[at + 1 :] if self.plant.model.floating else repeat(base[0])
        drags = dry[at + 1 :] if wants_dry else repeat(dry[0])
        rows = zip(upcoming, volts.tolist(), log[at:], q[at + 1 :], w[at + 1 :], bases, drags, strict=False)
        c, qk, wk, dk = command[at], q[at], w[at], dry[at]
        began = clock.perf_counter()
        for k, (c1, v, lk, q1, w1, b1, d1) in enumerate(rows, held.first + at):
            t = k * h
            drive_effort(drive, state, c, c1, qk, wk, dk, inertia, v, t, h, effort, damping, friction, lk)
            if beside:
                if mapped:
                    add_mapped(maps, numbers, drive, state, c, wk, inertia, v, t, h, effort, damping, lk)
                if pushed:
                    effort += given[k - held.first - at]
            step(effort, damping, friction)
            read(q1, w1, b1)
            if wants_dry:
                d1[:] = dry_friction()
            if k == look:
                look += CHECK_EVERY
                if not held.sane(k + 1 - held.first):
                    break
                if k == 0:
                    began = clock.perf_counter()
            c, qk, wk, dk = c1, q1, w1, d1
        return k + 1 - held.first, clock.perf_counter() - began
