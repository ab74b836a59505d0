"""What recordings of a motor tell: torque per ampere, friction, rotor inertia and speed per duty."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from realitygap.bench.estimate import Array, Estimate, jackknife
from realitygap.bench.motion import BenchMotion

MOVING = 0.1
"""Share of a recording's largest speed below which the direction of friction is not certain."""


@dataclass(frozen=True)
class CurrentFit:
    """Torque per ampere and friction from slow motion under several loads.

    Attributes:
        torque_constant: of the motor [N·m per recorded A].
        coulomb: half of the hysteresis at no load [N·m]; below zero it is the sensor's, not the motor's.
        load_dependent: coefficient of the transmitted torque, as in the effect `load_dependent_friction`.
        tilt: the bench's lean [rad].
        offset: of the current [A].
        residual: rms [A]; `residual_without`: the same with Coulomb friction alone.
        by_load: torque per ampere and half hysteresis [N·m] of every recording on its own.
    """

    torque_constant: Estimate
    coulomb: Estimate
    load_dependent: Estimate
    tilt: Estimate
    offset: Estimate
    residual: float
    residual_without: float
    by_load: dict[str, tuple[float, float]]


def moving(motion: BenchMotion, share: float = MOVING) -> BenchMotion:
    """The samples faster than a share of the largest speed."""
    return motion.rows(np.abs(motion.velocity) > share * np.abs(motion.velocity).max())


def solve_current(parts: Sequence[BenchMotion], armature: float, free: Sequence[bool] = (True,) * 5) -> Array:
    """Torque constant, coulomb, coefficient, tilt and offset of moving samples; those not free stay at zero."""
    chosen = np.array(free)
    start = np.array([_scale(parts), 0.0, 0.1, 0.0, 0.0])

    def full(x: Array) -> Array:
        out = np.where(chosen, start, 0.0)
        out[chosen] = x
        return out

    def misfit(x: Array) -> Array:
        return np.concatenate([_misfit(m, full(x), armature) for m in parts])

    return full(least_squares(misfit, start[chosen]).x)


def fit_current(motions: Sequence[BenchMotion], armature: float) -> CurrentFit:
    """Fit the current of slow sines; the interval comes from leaving out one load at a time.

    motor torque = L + armature·acceleration + (coulomb + coefficient·τ_t)·sign ω, with L the torque that the arm takes
    and the transmitted torque τ_t = ½·abs(τ_m − τ_l), here of load and load-dependent friction, so that
    τ_t = abs(L)/(1 ∓ coefficient/2), minus where the motor drives the load. Without the rotor inertia [kg·m²] the
    torque per ampere comes out too large: a sine's acceleration has the shape of the load.
    """
    kept = [moving(m) for m in motions]
    whole = solve_current(kept, armature)
    plain = solve_current(kept, armature, (True, True, False, True, True))
    alone = {m.name: solve_current([m], armature, (True, True, False, False, True)) for m in kept}
    constant, coulomb, coefficient, tilt, offset = jackknife(kept, lambda parts: solve_current(parts, armature))
    return CurrentFit(
        torque_constant=constant,
        coulomb=coulomb,
        load_dependent=coefficient,
        tilt=tilt,
        offset=offset,
        residual=_rms(np.concatenate([_misfit(m, whole, armature) for m in kept])),
        residual_without=_rms(np.concatenate([_misfit(m, plain, armature) for m in kept])),
        by_load={name: (float(x[0]), float(x[1])) for name, x in alone.items()},
    )


def _scale(parts: Sequence[BenchMotion]) -> float:
    """A first torque per ampere, from the ratio of spreads."""
    load = np.concatenate([_load(m, 0.0) for m in parts])
    return float(np.std(load) / np.std(np.concatenate([m.current for m in parts])))


def _load(motion: BenchMotion, tilt: float) -> Array:
    assert motion.pendulum is not None
    return motion.pendulum.torque(motion.position + tilt, motion.acceleration)


def _misfit(motion: BenchMotion, x: Array, armature: float) -> Array:
    constant, coulomb, coefficient, tilt, offset = x
    load, way = _load(motion, tilt), np.sign(motion.velocity)
    transmitted = np.abs(load) / (1 - coefficient / 2 * np.sign(load) * way)
    torque = load + armature * motion.acceleration + way * (coulomb + coefficient * transmitted)
    return np.asarray(torque / constant + offset - motion.current)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def fit_rotor(motion: BenchMotion, torque_constant: float) -> tuple[Estimate, float]:
    """Rotor inertia at the output [kg·m²] from fast motion, and the share of the motor torque left unexplained.

    torque_constant·current − L = armature·acceleration + (coulomb + coefficient·τ_t)·sign ω, linear; the friction terms
    are fitted along, so that they do not pass for inertia. The interval comes from leaving out a tenth at a time.
    """
    kept = moving(motion)

    def system(m: BenchMotion) -> tuple[Array, Array]:
        load, motor, way = _load(m, 0.0), torque_constant * m.current, np.sign(m.velocity)
        return np.column_stack([m.acceleration, way, way * np.abs(motor + load) / 2]), motor - load

    def fit(parts: Sequence[BenchMotion]) -> Array:
        systems = [system(m) for m in parts]
        solved: Array = np.linalg.lstsq(np.vstack([a for a, _ in systems]), np.concatenate([y for _, y in systems]))[0]
        return solved

    armature = jackknife(kept.blocks(10), fit)[0]
    A, y = system(kept)
    return armature, _rms(y - A @ fit([kept])) / _rms(torque_constant * kept.current)


def solve_drive(
    sines: Sequence[BenchMotion], chirps: Sequence[BenchMotion], share: float = MOVING
) -> tuple[float, float, float]:
    """Torque constant, load-dependent coefficient and armature (0 without chirps) that fit sines and chirps together.

    Each needs the other's result: the sines the rotor inertia, the chirps the torque per ampere. Every round of the
    exchange shrinks an error more than tenfold.
    """
    kept = [moving(m, share) for m in sines]
    armature = 0.0
    for _ in range(4 if chirps else 1):
        constant, _, coefficient, _, _ = solve_current(kept, armature)
        if chirps:
            armature = float(np.mean([fit_rotor(m, constant)[0].value for m in chirps]))
    return float(constant), float(coefficient), armature


@dataclass(frozen=True)
class DutyFit:
    """Speed per duty without gravity: ω = no_load_speed·(duty − coulomb·sign ω − restoring·q), between jumps in duty.

    `no_load_speed` [rad/s per duty], `coulomb` as a share of full duty, `restoring` [duty per rad]: a cable, or a bench
    that is not level.
    """

    no_load_speed: Estimate
    coulomb: Estimate
    restoring: Estimate


def fit_duty(motions: Sequence[BenchMotion], settle: float = 0.15) -> DutyFit:
    """Fit the speed under a given duty; samples within `settle` [s] of a jump in duty are left out.

    The duty is what was set and exact; the speed is the answer and carries the error, so it is regressed on the duty.
    """

    def fit(parts: Sequence[BenchMotion]) -> Array:
        rows, speed = [], []
        for m in parts:
            assert m.duty is not None
            rows.append(np.column_stack([m.duty, -np.sign(m.velocity), -m.position]))
            speed.append(m.velocity)
        no_load, dry, spring = np.linalg.lstsq(np.vstack(rows), np.concatenate(speed))[0]
        return np.array([no_load, dry / no_load, spring / no_load])

    return DutyFit(*jackknife([part for m in motions for part in steady(m, settle).blocks(5)], fit))


def steady(motion: BenchMotion, settle: float) -> BenchMotion:
    """The moving samples that are not just behind (or, by the smoothing, before) a jump in duty."""
    assert motion.duty is not None
    jumps = motion.time[np.flatnonzero(np.abs(np.diff(motion.duty)) > 0.02) + 1]
    quiet = np.ones(len(motion.time), dtype=bool)
    for jump in jumps:
        quiet &= (motion.time < jump - settle / 3) | (motion.time > jump + settle)
    return motion.rows(quiet & (np.abs(motion.velocity) > MOVING * np.abs(motion.velocity).max()))


def stall_current(motions: Sequence[BenchMotion], least_duty: float = 0.04) -> Estimate | None:
    """Current per full duty [A] of a motor that is held by a stop: supply over resistance; None where none was."""
    duty, current = [], []
    for m in motions:
        assert m.duty is not None
        held = (np.abs(m.velocity) < 0.02) & (np.abs(m.duty) > least_duty)
        duty.append(m.duty[held])
        current.append(m.current[held])
    u, i = np.concatenate(duty), np.concatenate(current)
    if len(u) < 100:
        return None
    parts = [(u[k], i[k]) for k in np.array_split(np.arange(len(u)), 10)]

    def fit(blocks: Sequence[tuple[Array, Array]]) -> Array:
        x, y = (np.concatenate([b[k] for b in blocks]) for k in (0, 1))
        return np.array([(x @ y) / (x @ x)])

    return jackknife(parts, fit)[0]
