"""The blind cases: planted truths in recordings of a foreign plant, as scenario folders that a team could have written.

    python tests/planted/cases.py --out DIR [--only single] [--robot pendulum] [--first 20] [--seed 1]

writes DIR/cases/NAME/{scenario.yaml, robot.urdf, recordings} and DIR/truth/NAME.json, which only the judge reads.
Whole-body cases (`--only humanoid`) are in `humanoid.py` and need the humanoid's URDF in REALITYGAP_DATA.
"""

import argparse
import json
import shutil
import sys
import zlib
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import motions
import numpy as np
import planted
import yaml
from catalogue import COUNTS, Case, catalogue
from foreign import Foreign, Motion, simulate
from imperfections import clock_error, imperfect
from motions import Command
from planted import Planted
from recorder import Recording, Sensing, clock, disturbance, record, reported_velocity, write_bag, write_csv
from robots import BUILDERS, Robot

VISIBLE = 4.0
"""A single effect moves the recordings by at least this, in root mean square over the noise."""
KINDS = [*COUNTS, "humanoid"]
Make = Callable[[Path], dict[str, Any]]


@dataclass
class Run:
    """One recorded motion."""

    motion: str
    use: str
    seed: int
    length: float
    repetitions: int = 1
    gain: float = 1.0
    load: float = 1.0
    sent: list[Command] = field(default_factory=list)


def plan(robot: Robot, effects: list[str], rng: np.random.Generator) -> list[Run]:
    """Train and held-out motions: three to five seconds each, one of them repeated."""
    seeds = [int(x) for x in rng.integers(1, 2**31, 8)]
    free = not robot.prismatic and len(robot.joints) == 1
    train = ["steps", "sines", "triangle"] + (["lift_and_drop"] if free and rng.random() < 0.6 else [])
    held = list(rng.permutation(["steps", "sines", "chirp", "sine", "triangle"])[:2])
    if set(held) <= {"chirp", "triangle"}:
        held[0] = "steps"
    runs = [Run(m, "train", seeds[i], float(rng.choice([4.0, 4.5, 5.0]))) for i, m in enumerate(train)]
    runs += [Run(str(m), "held_out", seeds[4 + i], float(rng.choice([4.0, 5.0]))) for i, m in enumerate(held)]
    runs[int(rng.integers(2))].repetitions = int(rng.choice([2, 3]))
    for run in runs:
        if run.motion == "lift_and_drop":
            run.repetitions = 2  # nothing holds a joint that swings freely: its noise is its own
    if not {"controller_gain"} & set(effects) and not robot.prismatic and rng.random() < 0.4:
        runs[-1].gain = runs[1].gain = float(rng.choice([0.5, 0.6]))
    loaded = "load_dependent_friction" in effects or rng.random() < 0.3
    if loaded and not set(planted.BODY) & set(effects) and not robot.prismatic:
        runs[0].load, runs[-1].load = 1.8, 1.4
    return runs


def _still(command: Command, robot: Robot) -> np.ndarray:
    return np.asarray(command.value[0])


def _perform(plant: Foreign, robot: Robot, run: Run, sent: Command, noise: np.ndarray | None) -> Motion:
    return simulate(plant, sent.time, sent.value, sent.enabled, _still(sent, robot), run.length, noise)


def _plant(
    robot: Robot,
    run: Run,
    truths: list[tuple[str, int, float, int]],
    outside: tuple[str, int, int] | None,
    nearly: int | None = None,
):
    """The plant of one run with what is planted, and the truths; draws are the same in every run.

    `nearly` is the seed of what keeps its laws nearly right; without it they are exact.
    """
    plant = robot.plant(run.gain, run.load)
    told = [planted.plant(e, plant, robot, j, size, np.random.default_rng(s)) for e, j, size, s in truths]
    other = None
    if outside:
        name, j, s = outside
        other = planted.OUTSIDE[name](plant, robot, j, np.random.default_rng(s))
    if nearly is not None:
        imperfect(plant, robot, nearly)
    robot.bristles(plant)
    return plant, told, other


def _measure(robot: Robot, runs: list[Run], sensing: Sensing) -> list[Motion]:
    """Simulate the perfect model; sets the robot's typical torque and speed."""
    n = len(robot.joints)
    robot.torque, robot.speed, robot.peak, robot.fastest = np.ones(n), np.ones(n), np.ones(n), np.ones(n)
    clean = []
    for run in runs:
        plant, _, _ = _plant(robot, run, [], None)
        clean.append(_perform(plant, robot, run, _command(robot, run, sensing), None))
    moving = [(m.effort, m.velocity) for m, r in zip(clean, runs, strict=True) if r.motion != "lift_and_drop"]
    effort, velocity = (np.concatenate(x) for x in zip(*moving, strict=True))
    robot.torque, robot.speed = np.sqrt(np.mean(effort**2, axis=0)), np.sqrt(np.mean(velocity**2, axis=0))
    robot.peak, robot.fastest = np.max(np.abs(effort), axis=0), np.max(np.abs(velocity), axis=0)
    return clean


def _command(robot: Robot, run: Run, sensing: Sensing) -> Command:
    return motions.command(run.motion, len(robot.joints), robot.reach, sensing.rate, run.length, run.seed)


def visibility(robot: Robot, plant: Foreign, motion: Motion, clean: Motion, sensing: Sensing) -> float:
    """How far an effect moves one recording: root mean square over the sensor's noise."""
    sigma = np.hypot(sensing.position_noise, 0.29) * sensing.quantum
    parts = [(motion.reading - clean.reading) / sigma]
    speed = reported_velocity(plant, motion)[::5] - clean.velocity[::5]
    parts.append(speed / (1.04 * sensing.velocity_noise * robot.speed))
    if sensing.effort:
        parts.append((motion.effort - clean.effort) / (sensing.effort_noise * robot.torque))
    return max(float(np.sqrt(np.mean(np.square(x), axis=0)).max()) for x in parts)


def generate(case: Case, out: Path, seed: int = 1) -> dict[str, Any]:
    """Write one case and its truth; returns the truth."""
    rng = np.random.default_rng([seed, zlib.crc32(case.name.encode())])
    nearly = zlib.crc32(f"{seed} {case.name}".encode()) if case.laws == "nearly" else None
    while True:
        robot = BUILDERS[case.robot](rng)
        sensing = replace(case.sensing, quantum=robot.quantum, clock=0.0 if nearly is None else clock_error(nearly))
        runs = plan(robot, [e for e, _ in case.effects], rng)
        clean = _measure(robot, runs, sensing)
        truths = _sized(case, robot, runs, clean, sensing, rng)
        j = int(rng.integers(len(robot.joints)))
        outside = (case.outside, j, int(rng.integers(2**31))) if case.outside else None
        plants = [_plant(robot, run, truths, outside, nearly) for run in runs]
        if truths is not None and _sane(robot, runs, plants, sensing):
            break
    folder = out / "cases" / case.name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    entries = _write_runs(robot, runs, [p for p, _, _ in plants], sensing, folder, rng)
    scenario = _scenario(case, robot, sensing, entries)
    (folder / "robot.urdf").write_text(robot.urdf())
    for load in {r.load for r in runs} - {1.0}:
        (folder / f"robot_load_{load:g}.urdf").write_text(robot.urdf(load))
    (folder / "scenario.yaml").write_text(yaml.safe_dump(scenario, sort_keys=False, allow_unicode=True))
    told: list[Planted] = plants[0][1]
    seen = []
    for t in truths:
        alone = _plant(robot, runs[0], [t], None)[0]
        motion = _perform(alone, robot, runs[0], _command(robot, runs[0], sensing), None)
        seen.append(round(visibility(robot, alone, motion, clean[0], sensing), 2))
    truth = {
        "case": case.name,
        "kind": case.kind,
        "robot": case.robot,
        "truth": [
            {**asdict(x), "size": t[2], "visibility": v, "twins": planted.twins(x, robot)}
            for x, t, v in zip(told, truths, seen, strict=True)
        ],
        "outside": plants[0][2],
        "tolerated": [["velocity_filter", j] for j in [*robot.joints, "*"]] if sensing.velocity == "difference" else [],
        "laws": _laws(robot, runs, nearly, clean, sensing),
        "sensing": asdict(sensing),
        "joints": robot.joints,
    }
    (out / "truth").mkdir(exist_ok=True)
    (out / "truth" / f"{case.name}.json").write_text(json.dumps(truth, indent=1, ensure_ascii=False) + "\n")
    return truth


def _laws(robot: Robot, runs: list[Run], nearly: int | None, clean: list[Motion], sensing: Sensing):
    """What keeps the laws nearly right, and how far it alone moves the recordings."""
    if nearly is None:
        return "exact"
    plant = _plant(robot, runs[0], [], None)[0]
    told = imperfect(plant, robot, nearly)
    robot.bristles(plant)
    motion = _perform(plant, robot, runs[0], _command(robot, runs[0], sensing), None)
    return {"visibility": round(visibility(robot, plant, motion, clean[0], sensing), 2), "joints": told}


def _sized(case: Case, robot: Robot, runs: list[Run], clean: list[Motion], sensing: Sensing, rng: np.random.Generator):
    """Where each effect sits and its size, made larger until the recordings show it."""
    truths = []
    for effect, size in case.effects:
        j = int(rng.integers(len(robot.joints)))
        s = int(rng.integers(2**31))
        full = size * (2.0 if case.family == "half" else 1.0)
        loud = replace(sensing, effort=True)
        for _ in range(5):
            seen = 0.0
            for run, base in zip(runs, clean, strict=True):
                plant, _, _ = _plant(robot, run, [(effect, j, full, s)], None)
                motion = _perform(plant, robot, run, _command(robot, run, sensing), None)
                seen = max(seen, visibility(robot, plant, motion, base, loud))
                if seen > VISIBLE:
                    break
            if seen > VISIBLE:
                break
            full *= 1.4
        truths.append((effect, j, full * (0.5 if case.family == "half" else 1.0), s))
    return truths


def _sane(robot: Robot, runs: list[Run], plants: list[Any], sensing: Sensing) -> bool:
    """Whether every motion stays within the joint's range."""
    for run, (plant, _, _) in zip(runs, plants, strict=True):
        motion = _perform(plant, robot, run, _command(robot, run, sensing), None)
        if not np.all(np.isfinite(motion.reading)) or np.abs(motion.reading).max() > 3.0:
            return False
    return True


def _write_runs(
    robot: Robot, runs: list[Run], plants: list[Foreign], sensing: Sensing, folder: Path, rng: np.random.Generator
) -> list[dict[str, Any]]:
    """Perform and write every run; returns the scenario's entries."""
    entries: list[dict[str, Any]] = []
    names: dict[str, int] = {}
    for run, plant in zip(runs, plants, strict=True):
        names[run.motion] = names.get(run.motion, 0) + 1
        for repetition in range(run.repetitions):
            stem = f"{run.motion}_{names[run.motion]}" + (f"_rep{repetition + 1}" if run.repetitions > 1 else "")
            entries.append(_entry(robot, run, stem))
            sent = clock(_command(robot, run, sensing), sensing, rng)
            noise = disturbance(robot, sensing, run.length + 1.6, rng)
            motion = _perform(plant, robot, run, sent, noise)
            taken: Recording = record(plant, robot, motion, sent, sensing, int(rng.integers(2**31)))
            if len(robot.joints) == 1:
                write_csv(taken, folder / f"{stem}.csv")
            else:
                write_bag(taken, robot.joints, folder / stem)
    return entries


def _entry(robot: Robot, run: Run, stem: str) -> dict[str, Any]:
    entry: dict[str, Any] = {"path": f"{stem}.csv" if len(robot.joints) == 1 else stem, "use": run.use}
    changed: dict[str, Any] = {}
    if run.gain != 1.0:
        key = "kp" if robot.servo["kind"] == "pid" else "gain"
        changed[f"servos.drive.{key}"] = float(f"{robot.servo[key] * run.gain:.9g}")
    if run.load != 1.0:
        changed["robot.urdf"] = f"robot_load_{run.load:g}.urdf"
    return entry | ({"with": changed} if changed else {})


def _scenario(case: Case, robot: Robot, sensing: Sensing, entries: list[dict[str, Any]]) -> dict[str, Any]:
    table = len(robot.joints) == 1
    servo = {"name": "drive", "joints": "*", **robot.servo}
    if robot.servo["kind"] == "dc":
        servo["friction"] = dict(robot.friction)
    recordings: dict[str, Any] = {} if table else {"state": "/joint_states"}
    recordings["effort"] = "motor" if sensing.effort else "none"
    recordings["runs"] = entries
    return {
        "name": case.name,
        "robot": {"urdf": "robot.urdf", "base": "fixed", "start": "recording"},
        "servos": [servo],
        "motion": {"recorded": "command" if table else "/joint_commands"},
        "ground": "none",
        "physics": {"step_rate": 1000},
        "recordings": recordings,
    }


def makers(kind: str, seed: int = 1, robots: list[str] | None = None) -> list[tuple[str, Make]]:
    """Names of the cases of one kind, and what writes each into a folder and returns its truth."""
    if kind == "humanoid":
        import humanoid  # needs MuJoCo and the humanoid's URDF

        return [(p.name, partial(humanoid.generate, p, seed=seed)) for p in humanoid.catalogue()]
    chosen = [c for c in catalogue(kind, seed) if not robots or c.robot in robots]
    return [(c.name, partial(generate, c, seed=seed)) for c in chosen]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", choices=KINDS, action="append")
    parser.add_argument("--robot", choices=list(BUILDERS), action="append")
    parser.add_argument("--first", type=int, help="this many of each kind")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    for kind in args.only or KINDS:
        for name, make in makers(kind, args.seed, args.robot)[: args.first]:
            truth = make(args.out)
            told = "; ".join(f"{t['effect']} at {t['target']} ({t['visibility']})" for t in truth["truth"])
            sys.stdout.write(f"{name}: {told or truth['outside'] or 'nothing'}\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
