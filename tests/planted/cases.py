"""The cases of the suite: planted truths in recordings of a foreign plant, as scenario folders that a team would write.

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
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import planted
import yaml
from catalogue import COUNTS, Case, catalogue
from foreign import Foreign, Motion
from imperfections import besides, clock_error, imperfect
from plants import Hidden, Run, Truth, command, limits, measure, moved, perform, sane, sized, visibility
from recorder import Recording, Sensing, clock, disturbance, record, write_bag, write_csv
from robots import BUILDERS, Robot

KINDS = [*COUNTS, "humanoid"]
Make = Callable[[Path], dict[str, Any]]


def plan(robot: Robot, effects: list[str], rng: np.random.Generator) -> list[Run]:
    """Train and held-out motions: three to five seconds each, one of them repeated."""
    seeds = [int(x) for x in rng.integers(1, 2**31, 8)]
    free = not robot.prismatic and len(robot.joints) == 1
    dropped = free and (rng.random() < 0.6 or "motor_braking" in effects)
    train = ["steps", "sines", "triangle"] + (["lift_and_drop"] if dropped else [])
    held = list(rng.permutation(["steps", "sines", "chirp", "sine", "triangle"])[:2])
    if set(held) <= {"chirp", "triangle"}:
        held[0] = "steps"
    if "motor_braking" in effects:
        held[1] = "lift_and_drop"
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


def generate(case: Case, out: Path, seed: int = 1) -> dict[str, Any]:
    """Write one case and its truth; returns the truth."""
    rng = np.random.default_rng([seed, zlib.crc32(case.name.encode())])
    nearly = zlib.crc32(f"{seed} {case.name}".encode()) if case.laws == "nearly" else None
    effects = [e for e, _ in case.effects]
    while True:
        robot = BUILDERS[case.robot](rng)
        if "friction_ripple" in effects and not robot.friction["coulomb"]:
            continue  # nothing would ripple
        sensing = replace(case.sensing, quantum=robot.quantum, clock=0.0 if nearly is None else clock_error(nearly))
        runs = plan(robot, effects, rng)
        clean = measure(robot, runs, sensing)
        truths = _truths(case, robot, runs, clean, sensing, nearly, rng)
        j = int(rng.integers(len(robot.joints)))
        outside = (case.outside, j, int(rng.integers(2**31))) if case.outside else None
        hidden = Hidden(tuple(truths), outside, nearly)
        if sane(robot, runs, hidden, sensing):
            break
    folder = out / "cases" / case.name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    plants = [hidden.plant(robot, run)[0] for run in runs]
    entries = _write_runs(robot, runs, plants, sensing, folder, rng)
    scenario = _scenario(case, robot, sensing, entries)
    (folder / "robot.urdf").write_text(robot.urdf())
    for load in {r.load for r in runs} - {1.0}:
        (folder / f"robot_load_{load:g}.urdf").write_text(robot.urdf(load))
    (folder / "scenario.yaml").write_text(yaml.safe_dump(scenario, sort_keys=False, allow_unicode=True))
    _, told, other = hidden.plant(robot, runs[0])

    def seen(alone: Hidden) -> float:
        """In the first motion, or the first that shows it."""
        most = 0.0
        for run, base in zip(runs, clean, strict=True):
            most = max(most, visibility(robot, *moved(robot, run, alone, sensing), base, sensing))
            if most > 1.0:
                break
        return round(most, 2)

    uneven = [] if nearly is None else imperfect(robot.plant(), robot, nearly)
    truth = {
        "case": case.name,
        "kind": case.kind,
        "robot": case.robot,
        "truth": [
            {**asdict(x), "size": t.size, "visibility": seen(Hidden((t,))), "twins": planted.twins(x, robot)}
            | ({} if nearly is None else {"twins": planted.twins(x, robot) + _as_it_is(x, robot)})
            for x, t in zip(told, truths, strict=True)
        ],
        "outside": other,
        "tolerated": [["velocity_filter", j] for j in [*robot.joints, "*"]] if sensing.velocity == "difference" else [],
        "laws": "exact" if nearly is None else {"visibility": seen(Hidden(nearly=nearly)), "joints": uneven},
        "besides": [] if nearly is None else besides(uneven),
        "sensing": asdict(sensing),
        "joints": robot.joints,
    }
    (out / "truth").mkdir(exist_ok=True)
    (out / "truth" / f"{case.name}.json").write_text(json.dumps(truth, indent=1, ensure_ascii=False) + "\n")
    return truth


def _as_it_is(truth: planted.Planted, robot: Robot) -> list[list[str]]:
    """Dry friction of a machine whose friction differs by direction is named no worse in the richer form."""
    joints = robot.joints if truth.target == "*" else [truth.target]
    return [["direction_friction", j] for j in joints] if truth.effect == "coulomb_friction" else []


def _truths(
    case: Case,
    robot: Robot,
    runs: list[Run],
    clean: list[Motion],
    sensing: Sensing,
    nearly: int | None,
    rng: np.random.Generator,
) -> list[Truth]:
    """Where each effect sits and its size, made larger until the recordings show it."""
    least = limits(robot, runs, clean, sensing, nearly)
    n, truths = len(robot.joints), []
    for effect, size in case.effects:
        full = size * (2.0 if case.family == "half" else 1.0)
        if case.family != "several":
            places: list[int | None] = [int(rng.integers(n))]
        else:
            places = [None] if effect in case.shared and n > 1 else list(range(n))
        for place in places:
            truth, shown = sized(
                Truth(effect, place, full, int(rng.integers(2**31))), robot, runs, clean, sensing, least
            )
            if case.family == "half":
                truth = replace(truth, size=0.5 * truth.size)
            if shown or case.family != "several":  # a vertical joint does not feel an offset
                truths.append(truth)
    return truths


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
            sent = clock(command(robot, run, sensing), sensing, rng)
            noise = disturbance(robot, sensing, run.length + 1.6, rng)
            motion = perform(plant, run, sent, noise)
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
