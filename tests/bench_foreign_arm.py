"""An arm whose laws are of another form than ours, followed, with what `diagnose` names (synthetic recordings).

    REALITYGAP_DATA=... python tests/bench_foreign_arm.py [--seed 1] [--heavier 1] [--load 0] [--onset 1]

The links are those of a UR10e, `--heavier` times as heavy, and 3 % off. Friction grows from rest as a hyperbolic
tangent of the speed, then less than with it, by side, with angle and load, and falls while the arm warms up; rotors are
as heavy as those of such gears, and the model knows of none; torque constants are 3 % off, and there is noise. The
motions are those of `bench_followed_arm`. What was planted is printed beside what is named.
"""

import argparse
import os
import re
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from bench_followed_arm import COULOMB, JOINTS, MOTIONS, NOISE, VISCOUS, read, write
from named import named
from realitygap.robot.effects.place import place
from realitygap.robot.plant import Plant, build_plant
from realitygap.scenario.file import load_scenario
from realitygap.scenario.schema import EffectSpec
from realitygap.trace.trace import Array

RATE, QUANTUM = 250.0, 1e-4
NUMBER = r'((?:<mass value|i[xyz]{2}|effort)=")([^"]+)'


@dataclass
class Truth:
    """What the machine is like, by joint."""

    dry: Array
    viscous: Array
    rotor: Array
    uneven: Array
    offset: Array
    load: Array
    ripple: Array
    periods: Array
    phase: Array
    onset: Array
    constant: Array

    @classmethod
    def drawn(cls, rng: np.random.Generator, heavier: float, onset: float) -> "Truth":
        """A machine, whose friction needs so many times the usual speed to grow."""
        dry = np.array(COULOMB) * heavier * rng.uniform(0.7, 1.3, 6)
        return cls(
            dry=dry,
            viscous=np.array(VISCOUS) * heavier * rng.uniform(0.5, 1.3, 6),
            rotor=1.5 * heavier * rng.uniform(0.6, 1.4, 6),
            uneven=rng.uniform(-0.08, 0.08, 6),
            offset=dry * rng.uniform(-0.05, 0.05, 6),
            load=rng.uniform(0.0, 0.03, 6),
            ripple=rng.uniform(0.03, 0.08, 6),
            periods=rng.choice([2.0, 4.0], 6),
            phase=rng.uniform(0.0, 6.0, 6),
            onset=onset * rng.uniform(0.01, 0.03, 6),
            constant=1.0 + rng.uniform(-0.03, 0.03, 6),
        )

    def friction(self, time: Array, angle: Array, speed: Array, effort: Array) -> Array:
        """Shape (t, 6) [N·m]."""
        side = np.tanh(speed / self.onset)
        dry = side * (self.dry * (1.0 + self.uneven * side) + self.load * np.abs(effort))
        dry = dry * (1.0 + self.ripple * np.sin(self.periods * angle + self.phase))
        whole = dry + self.viscous * np.sign(speed) * np.abs(speed) ** 0.85 + self.offset
        return np.asarray(whole * (1.0 - 0.08 * (1.0 - np.exp(-time / 30.0)))[:, None])


def machine(folder: Path, rng: np.random.Generator, truth: Truth, load: float) -> Plant:
    """The arm with its rotors, masses and load, driven stiffly, without friction."""
    base = build_plant(load_scenario(folder / "plant.yaml"))
    planted = [
        EffectSpec(effect="rotor_inertia", target=j, armature=a) for j, a in zip(JOINTS, truth.rotor, strict=True)
    ]
    for link in [link for link in base.model.links if link.mass > 0.0][1:]:
        planted.append(EffectSpec(effect="link_mass", target=link.name, mass=link.mass * rng.uniform(0.97, 1.03)))
    if load:
        planted.append(EffectSpec(effect="payload", target="wrist_3_link", mass=load, x=0.02, y=0.03, z=0.08))
    return place(base, planted)


def record(folder: Path, plant: Plant, truth: Truth, seed: int, heavier: float) -> None:
    """The motions as tables."""
    for name, motion, number in MOTIONS:
        rng = np.random.default_rng([number, seed])
        seen = read(plant, motion, rng, RATE)
        assert seen.position is not None
        assert seen.velocity is not None
        assert seen.effort is not None
        rubbed = seen.effort + truth.friction(seen.time, seen.position, seen.velocity, seen.effort)
        effort = truth.constant * rubbed + 0.7 * heavier * NOISE * rng.normal(size=rubbed.shape)
        write(folder / f"{name}.csv", seen, QUANTUM, effort)


def main() -> None:
    """What was planted, and what is named."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--heavier", type=float, default=1.0)
    parser.add_argument("--load", type=float, default=0.0, help="kg")
    parser.add_argument("--onset", type=float, default=1.0, help="how much more slowly friction grows")
    options = parser.parse_args()
    data = Path(os.environ["REALITYGAP_DATA"])
    rng = np.random.default_rng(options.seed)
    truth = Truth.drawn(rng, options.heavier, options.onset)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        text = (data / "ur10e" / "ur10e.urdf").read_text(encoding="utf-8")
        heavy = re.sub(NUMBER, lambda m: f"{m[1]}{float(m[2]) * options.heavier!r}", text)
        (folder / "arm.urdf").write_text(heavy, encoding="utf-8")
        arm = "name: arm\nrobot: {urdf: arm.urdf, base: fixed}\n"
        gains = f"kp: {3000 * options.heavier:g}, kd: {150 * options.heavier:g}, armature: 0"
        servo = f"servos: [{{joints: '*', kind: pid, {gains}}}]\nmotion: {{recorded: command}}\n"
        (folder / "plant.yaml").write_text(arm + servo, encoding="utf-8")
        record(folder, machine(folder, rng, truth, options.load), truth, options.seed, options.heavier)
        uses = ("train", "train", "held_out")
        runs = "".join(f"    - {{path: {m[0]}.csv, use: {u}}}\n" for m, u in zip(MOTIONS, uses, strict=True))
        followed = f"motion: {{followed: true}}\nrecordings:\n  virtual: true\n  effort: motor\n  runs:\n{runs}"
        (folder / "scenario.yaml").write_text(arm + followed, encoding="utf-8")
        for what in ("dry", "viscous", "rotor"):
            sys.stdout.write(f"planted {what}: {np.round(getattr(truth, what), 2)}\n")
        sys.stdout.write(named(folder / "scenario.yaml"))


if __name__ == "__main__":
    main()
