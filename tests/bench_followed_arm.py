"""Six joints of an arm that is followed, with planted friction and then a planted load (synthetic recordings).

    REALITYGAP_DATA=... python tests/bench_followed_arm.py

A UR10e's URDF is driven along sines and from point to point in DART, with dry friction that is 4 % uneven in direction,
and read by two kinds of encoders: of 1 mrad at 100 Hz, and of 0.1 mrad at 500 Hz. What `diagnose` names in MuJoCo
stands beside what was planted, and how large the error of the true model is in its floors: 1 where floors are honest.
"""

import sys
import tempfile
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import realitygap_engines as engines
from named import named
from realitygap.diagnose.data.problem import build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.likelihood.floors import measure
from realitygap.robot.effects.place import place
from realitygap.robot.plant import Plant, build_plant
from realitygap.scenario.file import load_scenario
from realitygap.scenario.schema import EffectSpec
from realitygap.simulate.commands import Commands
from realitygap.simulate.rollout import rollout
from realitygap.simulate.start import start_state
from realitygap.trace.trace import Array, Trace
from realitygap_engines import Physics

URDF = '"${REALITYGAP_DATA}/ur10e/ur10e.urdf"'
JOINTS = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint")
COULOMB, VISCOUS = (12.0, 14.0, 8.0, 3.0, 3.0, 2.5), (18.0, 20.0, 10.0, 3.0, 2.5, 2.5)
UNEVEN, ARMATURE = 0.04, 1.5
STEP, LENGTH = 5e-4, 16.0
HOME, REACH = np.array([0.0, -1.4, 1.2, -1.4, -1.5, 0.0]), np.array([0.8, 0.4, 0.6, 0.7, 0.7, 0.9])
NOISE = np.array([0.6, 0.6, 0.45, 0.3, 0.3, 0.3])  # N·m
ENCODERS = {"1 mrad at 100 Hz": (100.0, 1e-3, 1.5), "0.1 mrad at 500 Hz": (500.0, 1e-4, 0.8)}
"""Rate [Hz], quantum [rad], and the load that is planted [kg]."""


Motion = Callable[[np.random.Generator, Array], Array]
"""The goals of six joints over times (t,), drawn. Shape (t, 6)."""


def sines(rng: np.random.Generator, time: Array) -> Array:
    """Two sines at every joint, from rest."""
    rise = np.clip(time / 1.5, 0.0, 1.0) ** 2 * (3.0 - 2.0 * np.clip(time / 1.5, 0.0, 1.0))
    out = np.tile(HOME, (len(time), 1))
    for k in range(len(JOINTS)):
        for share, f, phase in zip((0.6, 0.4), rng.uniform(0.1, 0.35, 2), rng.uniform(0, 6, 2), strict=True):
            out[:, k] += REACH[k] * rise * share * np.sin(2 * np.pi * f * time + phase)
    return out


def points(rng: np.random.Generator, time: Array) -> Array:
    """Seven moves of constant acceleration, speed and deceleration, with rests between them."""
    goals = [HOME, *(HOME + REACH * rng.uniform(-1, 1, len(JOINTS)) for _ in range(6)), HOME]
    out, part, ramp = np.tile(HOME, (len(time), 1)), LENGTH / 8, 0.25
    for i, (a, b) in enumerate(pairwise(goals)):
        t = np.clip((time - i * part) / (0.75 * part), 0.0, 1.0)
        slow = 2 * ramp * (1 - ramp)
        s = np.select(
            [t < ramp, t < 1 - ramp], [t**2 / slow, (t - ramp / 2) / (1 - ramp)], default=1 - (1 - t) ** 2 / slow
        )
        out[time >= i * part] = (a + np.outer(s, b - a))[time >= i * part]
    return out


MOTIONS = (("sines", sines, 1), ("points", points, 2), ("more_points", points, 5))


def record(folder: Path, load: float, rate: float, quantum: float) -> None:
    """The three motions as tables, with friction, and with a load where there is one."""
    file = load_scenario(folder / "plant.yaml")
    planted = [
        EffectSpec(effect="direction_friction", target=j, forward=c * (1 + UNEVEN), backward=c * (1 - UNEVEN))
        for j, c in zip(JOINTS, COULOMB, strict=True)
    ]
    planted += [
        EffectSpec(effect="viscous_friction", target=j, coefficient=v) for j, v in zip(JOINTS, VISCOUS, strict=True)
    ]
    if load:
        planted.append(EffectSpec(effect="payload", target="wrist_3_link", mass=load, x=0.02, y=0.03, z=0.08))
    plant = place(build_plant(file), planted)
    for name, motion, seed in MOTIONS:
        rng = np.random.default_rng([seed, bool(load)])
        seen = read(plant, motion, rng, rate)
        assert seen.effort is not None
        write(folder / f"{name}.csv", seen, quantum, seen.effort + NOISE * rng.normal(size=seen.effort.shape))


def read(plant: Plant, motion: Motion, rng: np.random.Generator, rate: float) -> Trace:
    """A motion in DART, at stamps that are late by up to a tenth of their distance."""
    time = np.arange(0.0, LENGTH, STEP)
    goals = motion(rng, time)
    with engines.load("dart").open(plant.machine(), Physics(STEP)) as simulation:
        start = start_state(plant, goals[0])
        trace = rollout(simulation, plant, Commands(time, goals), start, float(time[-1])).trace
    late = rng.uniform(0.0, 0.1 / rate, round((LENGTH - 0.1) * rate))
    return trace.at(np.arange(0.05, LENGTH - 0.05, 1 / rate) + late)


def write(path: Path, seen: Trace, quantum: float, effort: Array) -> None:
    """A table of positions, to a quantum [rad], and efforts [N·m], (t, 6)."""
    assert seen.position is not None
    table = np.column_stack([seen.time, np.round(seen.position / quantum) * quantum, effort])
    header = ",".join(["time", *(f"{s}_{j}" for s in ("position", "effort") for j in JOINTS)])
    np.savetxt(path, table, fmt="%.7g", delimiter=",", header=header, comments="")


def scenario(folder: Path, *, friction: float | None) -> Path:
    """The scenario that follows the motions: rotors are known, friction to a share of what it is, or not at all."""
    effects = [{"effect": "rotor_inertia", "target": "*", "armature": ARMATURE}]
    if friction is not None:
        for j, c, v in zip(JOINTS, COULOMB, VISCOUS, strict=True):
            uneven = {"forward": c * (1 + friction), "backward": c * (1 - friction)}
            effects.append({"effect": "direction_friction", "target": j, **uneven})
            effects.append({"effect": "viscous_friction", "target": j, "coefficient": v})
    lines = "\n".join(f"  - {e}" for e in effects).replace("'*'", '"*"').replace("'", "")
    runs = "\n".join(
        f"    - {{path: {name}.csv, use: {'held_out' if k == 2 else 'train'}}}"
        for k, (name, _, _) in enumerate(MOTIONS)
    )
    path = folder / "scenario.yaml"
    path.write_text(
        f"name: arm\nrobot: {{urdf: {URDF}, base: fixed}}\nmotion: {{followed: true}}\neffects:\n{lines}\n"
        f"recordings:\n  effort: motor\n  runs:\n{runs}\n"
    )
    return path


def honest(path: Path) -> float:
    """The error of the model in a scenario in its floors, root mean square over all samples."""
    problem, squares = build_problem(load_scenario(path), "mujoco"), []
    with Simulations(problem, 1) as simulations:
        floors = measure(simulations, [])
        for i, case in enumerate(problem.cases):
            (found,) = simulations.of([], [i])
            assert found is not None
            squares.append(((found["effort"] - case.value("effort")) / floors.sigma(i, "effort")) ** 2)
    return float(np.sqrt(np.mean(np.concatenate(squares))))


def main() -> None:
    """A paragraph per encoder and what is missing."""
    for encoder, (rate, quantum, load) in ENCODERS.items():
        for mass in (0.0, load):
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                servo = f"servos: [{{joints: '*', kind: pid, kp: 3000, kd: 150, armature: {ARMATURE}}}]"
                (folder / "plant.yaml").write_text(
                    f"name: arm\nrobot: {{urdf: {URDF}, base: fixed}}\n{servo}\nmotion: {{recorded: command}}\n"
                )
                record(folder, mass, rate, quantum)
                own = honest(scenario(folder, friction=UNEVEN)) if not mass else float("nan")
                what = f"a load of {mass} kg" if mass else f"friction (the true model is off by {own:.2f} floors)"
                names = named(scenario(folder, friction=0.0 if mass else None))
                sys.stdout.write(f"{encoder}, {what}: {names}")
                sys.stdout.flush()


if __name__ == "__main__":
    main()
