"""Cases whose recordings leave more than one explanation: one effect, and motions that do not tell what it is.

The foreign plant also performs what is proposed for them, so that the loop from diagnosis to motion closes.
"""

import json
import shutil
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from cases import _entry, _scenario
from catalogue import Case
from motions import Command
from plants import VISIBLE, Hidden, Run, Truth, command, measure, perform, sane, sized
from recorder import Recording, Sensing, clock, disturbance, record, write_bag, write_csv
from robots import BUILDERS, Robot

LOAD, GAIN = 1.8, 0.5
"""What the team has at hand: a last link of so many times its mass, and a gain of so many times its own."""
REST = 1.6
"""Seconds of disturbance beside those of the motion: the plant settles first."""
TRIED = 8
"""Robots that are drawn until one shows an effect and stays within its range: what none of them shows is not a case."""


class NotShown(ValueError):
    """A robot cannot show an effect in a motion."""


@dataclass
class Ambiguous:
    """A case with what is needed to perform further motions.

    Attributes:
        folder: of the scenario.
        robot: as the team describes it.
        hidden: what it really is.
        sensing: the recorder.
        effect: that was planted.
        runs: entries of the scenario.
        seed: of the noise, together with a recording's name: it does not depend on what was recorded before.
    """

    folder: Path
    robot: Robot
    hidden: Hidden
    sensing: Sensing
    effect: str
    runs: list[dict[str, Any]]
    seed: int

    def perform(self, name: str, sent: Command, gain: float, load: float) -> dict[str, Any]:
        """The foreign plant performs commands; returns the entry of the recording."""
        run = Run(name, "train", 0, float(sent.time[-1]), gain=gain, load=load)
        return self._recorded(name, run, sent)

    def record(self, name: str, run: Run) -> dict[str, Any]:
        """The same with the motion that a run names."""
        return self._recorded(name, run, command(self.robot, run, self.sensing))

    def _recorded(self, name: str, run: Run, sent: Command) -> dict[str, Any]:
        random = np.random.default_rng([self.seed, zlib.crc32(name.encode())])
        plant = self.hidden.plant(self.robot, run)[0]
        real = clock(sent, self.sensing, random)
        motion = perform(plant, run, real, disturbance(self.robot, self.sensing, run.length + REST, random))
        taken = record(plant, self.robot, motion, real, self.sensing, int(random.integers(2**31)))
        return self._written(taken, run, name)

    def _written(self, taken: Recording, run: Run, name: str) -> dict[str, Any]:
        one = len(self.robot.joints) == 1
        if one:
            write_csv(taken, self.folder / f"{name}.csv")
        else:
            shutil.rmtree(self.folder / name, ignore_errors=True)
            write_bag(taken, self.robot.joints, self.folder / name)
        return _entry(self.robot, run, name)

    def scenario(self, more: Sequence[dict[str, Any]] = (), name: str = "scenario") -> Path:
        """The scenario with further recordings; what the team has at hand stands in it."""
        case = Case(self.folder.name, "ambiguous", self.robot.kind)
        content = _scenario(case, self.robot, self.sensing, [*self.runs, *more])
        key = "kp" if self.robot.servo["kind"] == "pid" else "gain"
        have: list[dict[str, Any]] = [{f"servos.drive.{key}": float(f"{self.robot.servo[key] * GAIN:.9g}")}]
        if not self.robot.prismatic:
            have.append({"robot.urdf": f"robot_load_{LOAD:g}.urdf"})
        reach = 1.15 * self.robot.reach
        content["propose"] = {
            "limits": {"*": {"position": [-reach, reach], "speed": self.robot.limits[1]}},
            "release": not self.robot.prismatic and len(self.robot.joints) == 1,
            "with": have,
        }
        path = self.folder / f"{name}.yaml"
        path.write_text(yaml.safe_dump(content, sort_keys=False, allow_unicode=True), encoding="utf-8")
        return path


def generate(
    robot: str, effect: str, motion: str, seed: int, out: Path, *, effort: bool, swing: float = 1.0
) -> Ambiguous:
    """Plant one effect and record one kind of motion, three times and once more to judge on.

    Args:
        robot: one of `BUILDERS`.
        effect: that is planted.
        motion: one of `motions.MOTIONS`.
        seed: of what is drawn.
        out: the folder in which the case gets its own.
        effort: whether the motor's effort is recorded.
        swing: how far the motion goes, as a share of the usual: small motions leave much open.

    Raises:
        NotShown: where none of the robots that are drawn shows the effect.
    """
    name = f"{robot}_{effect}_{motion}_{seed}"
    random = np.random.default_rng([seed, zlib.crc32(name.encode())])
    sensing = Sensing(effort=effort)
    for _ in range(TRIED):
        body = BUILDERS[robot](random)
        sensing = replace(sensing, quantum=body.quantum)
        train, held = (int(x) for x in random.integers(1, 2**31, 2))
        runs = [
            Run(motion, "train", train, 4.0, repetitions=3, swing=swing),
            Run(motion, "held_out", held, 4.0, swing=swing),
        ]
        clean = measure(body, runs, sensing)
        joint = int(random.integers(len(body.joints)))
        truth, shown = sized(
            Truth(effect, joint, 1.5, int(random.integers(2**31))), body, runs, clean, sensing, [VISIBLE] * len(runs)
        )
        hidden = Hidden((truth,))
        if shown and sane(body, runs, hidden, sensing):
            break
    else:
        raise NotShown(f"none of {TRIED} robots of kind {robot} shows {effect} in {motion} within its range")
    folder = out / name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    case = Ambiguous(folder, body, hidden, sensing, effect, [], seed)
    (folder / "robot.urdf").write_text(body.urdf(), encoding="utf-8")
    (folder / f"robot_load_{LOAD:g}.urdf").write_text(body.urdf(LOAD), encoding="utf-8")
    for run in runs:
        case.runs += [case.record(f"{run.use}_{k + 1}", run) for k in range(run.repetitions)]
    told = hidden.plant(body, runs[0])[1][0]
    (folder / "truth.json").write_text(
        json.dumps({"effect": effect, "target": told.target, "parameters": told.parameters}), encoding="utf-8"
    )
    case.scenario()
    return case
