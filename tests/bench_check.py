"""Does `check` name mistakes as what they are, and keep quiet where physics is to blame?

    REALITYGAP_DATA=... python tests/bench_check.py [--mistakes] [--physics 200] [--real] [--seed 1]

Planted mistakes of every kind on robots of one, two and six joints, at every joint; real and bundled scenarios; and
planted physics: effects of random size at random joints of random robots, recorded with noise and quanta.
"""

import argparse
import sys
import tempfile
import time
from collections import Counter
from fnmatch import fnmatch
from pathlib import Path

import numpy as np
import yaml
from realitygap.check import Mistake, accepted, check
from realitygap.files.errors import InputError
from realitygap.robot.effects import EFFECTS
from realitygap.robot.effects.place import place, targets
from realitygap.robot.plant import Plant
from realitygap.scenario.file import load_scenario
from realitygap.scenario.schema import EffectSpec, Scenario
from realitygap_engines import Diverged

sys.path.insert(0, str(Path(__file__).parent / "check"))  # plain modules, not a package

from spoil import MISTAKES, Planted
from teams import Team, demo, generated, recorded

SCENARIOS = Path(__file__).parents[1] / "scenarios"
ROBOTS = {  # name: seed, joints, kind of servo
    "one joint, dc": (1, 1, "dc"),
    "one joint, pid": (2, 1, "pid"),
    "one slide": (3, 1, "cascade"),
    "six joints, dc": (4, 6, "dc"),
    "six joints, pid": (5, 6, "pid"),
}


def robots(folder: Path, seed: int) -> dict[str, Team]:
    """The robots that mistakes are made with: those of the tests by seed 1, others by another."""
    out = {"two joints, the demo": demo()}
    for name, (number, n, kind) in ROBOTS.items():
        own = number + 100 * (seed - 1)
        out[name] = recorded(generated(own, n, kind), folder / name.replace(" ", "_"), own)
    return out


def fits(planted: Planted, team: Team) -> bool:
    """Whether a mistake can happen to a robot."""
    slide = team.joints[0].startswith("slide")
    return len(team.joints) in planted.joints and (planted.slides or not slide)


def places(planted: Planted, team: Team) -> list[int]:
    """The joints at which a mistake is made."""
    return list(range(len(team.joints))) if planted.where in ("joint", "pair") else [0]


def found(planted: Planted, team: Team, j: int, folder: Path) -> tuple[bool, list[Mistake] | str]:
    """Whether a mistake that is made is named as what it is, there and nothing else; and what was said."""
    spoilt = team.copy()
    planted.spoil(spoilt, j)
    try:
        said = check(load_scenario(spoilt.write(folder)))
    except InputError as error:
        return False, str(error)
    other = team.joints[(j + 1) % len(team.joints)]
    wanted = {"joint": {team.joints[j]}, "pair": {team.joints[j], other}, "all": set(team.joints), "none": set()}
    named = {joint for m in said for joint in m.joints}
    there = planted.where == "any" or named == wanted[planted.where]
    return {m.kind for m in said} == {planted.kind} and there, said


def mistakes(only: str = "*", seed: int = 1) -> int:
    """A line per mistake and robot; how many were not named."""
    wrong = total = 0
    with tempfile.TemporaryDirectory() as name:
        teams = robots(Path(name), seed)
        for planted in [m for m in MISTAKES if any(fnmatch(m.name, p) for p in only.split("|"))]:
            cells = []
            for robot, team in teams.items():
                if not fits(planted, team):
                    continue
                done = [
                    found(planted, team, j, Path(name) / f"{planted.name}_{robot}_{j}".replace("/", "_"))
                    for j in places(planted, team)
                ]
                wrong += sum(not ok for ok, _ in done)
                total += len(done)
                cells.append(f"{robot} {sum(ok for ok, _ in done)}/{len(done)}")
                for ok, said in done:
                    if not ok:
                        told = said if isinstance(said, str) else [(m.kind, m.certainty, m.joints) for m in said]
                        sys.stdout.write(f"    {robot}: {told}\n")
            sys.stdout.write(f"{planted.name:42} {planted.kind:18} {'; '.join(cells)}\n")
            sys.stdout.flush()
    sys.stdout.write(f"named as what they are: {total - wrong} of {total} ({(total - wrong) / total:.1%})\n")
    return wrong


def physics_case(seed: int, folder: Path) -> tuple[str, Team] | None:
    """A robot with one to three effects of random size that its model lacks; None where it blows up."""
    rng = np.random.default_rng([7, seed])
    n, kind = [(1, "dc"), (1, "pid"), (1, "cascade"), (2, "dc"), (2, "pid"), (6, "dc"), (6, "pid")][seed % 7]
    floating = kind != "cascade" and n > 1 and rng.random() < 0.25
    off = rng.random() < 0.15
    told: list[str] = ["floating"] * floating + ["servos off for a while"] * off
    team = generated(int(rng.integers(1 << 30)), n, kind, floating=floating, effort=rng.random() < 0.7)

    def change(plant: Plant, rng: np.random.Generator) -> Plant:
        names = [str(x) for x in rng.permutation(list(EFFECTS))]
        wanted, k = int(rng.integers(1, 4)), 0
        for name in names:
            if k == wanted:
                break
            spec = effect_of(plant, name, rng)
            if spec is None:
                continue
            try:
                plant = place(plant, [spec])
            except InputError:
                continue
            told.append(f"{spec.effect}@{spec.target} { ({a: float(f'{b:.3g}') for a, b in spec.parameters.items()}) }")
            k += 1
        return plant

    try:
        made = recorded(team, folder, seed, change, off=off)
        return "; ".join(told), made
    except Diverged:
        return None


def effect_of(plant: Plant, name: str, rng: np.random.Generator) -> EffectSpec | None:
    """An effect at a random target: a third to five times its first size; a gain from a third to twice its own."""
    effect = EFFECTS[name]
    try:
        index = int(rng.choice(targets(plant, effect, "*")))
    except InputError:
        return None
    if effect.possible(plant, index) or (effect.sits_at == "base" and plant.model.floating):
        return None
    if effect.sits_at == "ground" and plant.ground is None:
        return None
    names = {"joint": plant.model.joint_names, "link": [x.name for x in plant.model.links]}
    where = names[effect.sits_at][index] if effect.sits_at in names else effect.sits_at
    own, first = effect.own(plant, index), effect.first_size(plant, index)
    size = float(10 ** rng.uniform(-0.5, 0.7))
    values = {}
    for p in effect.parameters:
        a, b = own.get(p.name, p.absent), first[p.name]
        if name == "controller_gain":
            assert a is not None
            value = a * float(10 ** rng.uniform(-0.5, 0.3))
        elif name == "command_delay":
            value = float(rng.uniform(0.01, 0.2))
        elif p.shape or a is None or not np.isfinite(a):
            value = b
        elif p.logarithmic and a == 0:
            value = b / min(size, 2.0)
        elif p.logarithmic:
            value = a * (b / a) ** min(size, 2.0)
        else:
            value = a + size * (b - a)
        values[p.name] = float(np.clip(value, p.low, p.high))
    return EffectSpec.model_validate({"effect": name, "target": where, **values})


def physics(count: int, seed: int) -> int:
    """How many of the planted physics cases are called mistakes."""
    alarms, done, number = 0, 0, 0
    kinds: Counter[str] = Counter()
    began = time.process_time()
    with tempfile.TemporaryDirectory() as name:
        while done < count:
            number += 1
            folder = Path(name) / str(number)
            made = physics_case(1000 * seed + number, folder)
            if made is None:
                continue
            done += 1
            told, team = made
            said = check(load_scenario(team.write(folder)))
            if said:
                alarms += 1
                kinds.update(m.kind for m in said)
                sys.stdout.write(f"case {1000 * seed + number}: {told}\n")
                for m in said:
                    sys.stdout.write(f"    {m.kind} {m.certainty} {m.joints}: {m.text}\n")
                sys.stdout.flush()
    sys.stdout.write(f"false alarms on planted physics: {alarms} of {count} {dict(kinds)}\n")
    sys.stdout.write(f"CPU time {time.process_time() - began:.0f} s\n")
    return alarms


def scenario_files() -> list[Path]:
    """Every scenario of the repository."""
    out = []
    for path in sorted(SCENARIOS.glob("*/*.yaml")):
        keys = set(yaml.safe_load(path.read_text()) or {})
        if {"name", "robot"} <= keys <= set(Scenario.model_fields):
            out.append(path)
    return out


def real() -> int:
    """How many mistakes are found in the scenarios of the repository, with the real recordings that they name."""
    alarms = 0
    for path in scenario_files():
        began = time.process_time()
        file = load_scenario(path)
        said = [m for m in check(file) if not accepted(file, m)]
        alarms += len(said)
        sys.stdout.write(
            f"{path.relative_to(SCENARIOS)}: {len(said)} mistakes, {time.process_time() - began:.1f} s CPU\n"
        )
        for m in said:
            sys.stdout.write(f"    {m.kind} {m.certainty} {m.joints}: {m.text}\n")
    return alarms


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mistakes", action="store_true")
    parser.add_argument("--only", default="*", help="patterns over the mistakes' names, with | between them")
    parser.add_argument("--physics", type=int, default=0)
    parser.add_argument("--real", action="store_true")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    if args.real:
        real()
    if args.mistakes:
        mistakes(args.only, args.seed)
    if args.physics:
        physics(args.physics, args.seed)


if __name__ == "__main__":
    main()
