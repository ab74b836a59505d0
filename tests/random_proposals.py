"""Random scenarios for the law that no proposed motion leaves a limit: robots, limits, conditions and rivals."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from realitygap.diagnose.candidates.starts import starts
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.changes import Change, changed
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.likelihood.floors import measure
from realitygap.diagnose.propose.excitation import BEFORE, pose_of
from realitygap.diagnose.propose.explanations import Open, Question
from realitygap.diagnose.propose.files import write_motion
from realitygap.diagnose.propose.limits import limits_of
from realitygap.diagnose.propose.proposal import Proposal
from realitygap.diagnose.propose.propose import design
from realitygap.diagnose.search.criterion import Criterion
from realitygap.files.errors import InputError
from realitygap.scenario.file import load_scenario
from realitygap.scenario.propose import ProposeSpec
from realitygap.simulate.experiment import experiments, simulate
from realitygap.simulate.footing import lost_footing
from realitygap_engines import Diverged, Failed, Unsupported
from robots import BUILDERS, Robot

ROBOTS = ("pendulum", "geared", "planar", "skew", "slide")
SECONDS = 4.0
"""Of a proposed motion: enough for two or three pieces."""
BASE = '<link name="base"/>'
RIVALS = 2
"""Effects that are drawn, beside none."""
LENGTH, RATE = 2.0, 100.0
"""Of the recording that a scenario needs [s], [Hz]."""


@dataclass(frozen=True)
class Left:
    """A motion that leaves a limit: when [s], in which engine, and under which rival."""

    seed: int
    engine: str
    rival: str
    time: float
    how: str


def on_a_foot(robot: Robot, random: np.random.Generator) -> str:
    """What the robot stands with: a box as its base, larger and heavier than it or smaller and lighter."""
    carried = sum(link.mass for link in robot.links)
    long = sum(link.length for link in robot.links)
    size = [long * random.uniform(0.3, 1.5), long * random.uniform(0.3, 1.5), 0.04]
    mass = carried * random.uniform(0.3, 4.0)
    x, y, z = (mass / 12 * (sum(s**2 for s in size) - own**2) for own in size)
    return (
        f'<link name="base"><inertial><mass value="{mass:.6g}"/><inertia ixx="{x:.6g}" ixy="0" ixz="0" '
        f'iyy="{y:.6g}" iyz="0" izz="{z:.6g}"/></inertial>'
        f'<collision><geometry><box size="{" ".join(f"{s:.6g}" for s in size)}"/></geometry></collision></link>'
    )


def scenario(random: np.random.Generator, folder: Path, standing: bool = False) -> Path:
    """A robot with drawn limits, poses and conditions, and a recording of its own model; on a foot, if `standing`."""
    kind = str(random.choice(ROBOTS))
    robot = BUILDERS[kind](random)
    base = on_a_foot(robot, random) if standing else BASE
    for name, load in (("robot", 1.0), ("load", 1.8)):
        (folder / f"{name}.urdf").write_text(robot.urdf(load).replace(BASE, base), encoding="utf-8")
    names, reach = robot.joints, robot.reach
    limits: dict[str, Any] = {}
    for name in names:
        own: dict[str, Any] = {}
        if random.random() < 0.7:
            own["position"] = [-reach * random.uniform(0.1, 1.4), reach * random.uniform(0.1, 1.4)]
        if random.random() < 0.7:
            own["speed"] = robot.limits[1] * random.uniform(0.05, 1.0)
        if random.random() < 0.5:
            own["effort"] = robot.limits[0] * random.uniform(0.3, 1.0)
        limits[name] = {k: [float(x) for x in v] if k == "position" else float(v) for k, v in own.items()}
    key = "kp" if robot.servo["kind"] == "pid" else "gain"
    have: list[dict[str, Any]] = []
    if random.random() < 0.3:
        have.append({f"servos.drive.{key}": float(robot.servo[key] * random.uniform(0.4, 1.3))})
    if not robot.prismatic and random.random() < 0.3:
        have.append({"robot.urdf": "load.urdf"})
    time = np.arange(0.0, LENGTH, 1.0 / RATE)
    swing = reach * random.uniform(0.05, 0.8, len(names))
    command = swing * np.sin(2 * np.pi * random.uniform(0.3, 1.2, len(names)) * time[:, None])
    content: dict[str, Any] = {
        "name": kind,
        "robot": {"urdf": "robot.urdf", "base": "floating" if standing else "fixed", "start": "recording"},
        "servos": [{"name": "drive", "joints": "*", **robot.servo}],
        "motion": {"recorded": "command"},
        "ground": "flat" if standing else "none",
        "physics": {"step_rate": 500},
        "recordings": {
            "columns": {what: {n: f"{what}_{n}" for n in names} for what in ("command", "position")},
            "runs": [{"path": "a.csv", "use": "train"}, {"path": "b.csv", "use": "held_out"}],
        },
        "propose": {"limits": limits, "release": bool(random.random() < 0.4), "with": have},
    }
    path = folder / "scenario.yaml"
    path.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    head = ",".join(["time", *(f"command_{n}" for n in names), *(f"position_{n}" for n in names)])
    position = command
    for _ in range(2):
        for name in ("a.csv", "b.csv"):
            noise = 1e-3 * reach * random.standard_normal(position.shape)
            rows = np.column_stack([time, command, position + noise])
            np.savetxt(folder / name, rows, fmt="%.6f", delimiter=",", header=head, comments="")
        first = next(e for e in experiments(load_scenario(path)) if e.name == "a")
        moved = simulate(first, "mujoco").trace.at(time).position
        assert moved is not None
        position = moved
    return path


def rivals(problem: Problem, random: np.random.Generator) -> list[tuple[Change, ...]]:
    """Explanations with one effect each, of any that is visible, from half to twice as large; and none."""
    everyone = suspects(problem)
    out: list[tuple[Change, ...]] = [()]
    for k in random.permutation(len(everyone))[:RIVALS]:
        options = starts(problem, everyone[int(k)])
        if options:
            start = options[int(random.integers(len(options)))]
            amounts = random.uniform(0.5, 2.0) * np.ones(len(start.tries))
            out.append((start.at(amounts.tolist()),))
    return out


def left(seed: int, folder: Path, engines: Sequence[str], standing: bool = False) -> tuple[int, list[Left]]:
    """How many motions are proposed for a random scenario, and which of them leave a limit as they are written.

    Args:
        seed: of the scenario.
        folder: for its files.
        engines: in which motions have to stay within the limits.
        standing: whether the robot stands on a foot, which it has to keep, too.
    """
    random = np.random.default_rng(seed)
    problem = build_problem(load_scenario(scenario(random, folder, standing)), "mujoco")
    spec = problem.file.scenario.propose or ProposeSpec()
    with Simulations(problem, 1) as simulations:
        criterion = Criterion(simulations, ())
        explanations = []
        for changes in rivals(problem, random):
            fixed = tuple(Change(c.suspect, c.values, ()) for c in changes)
            now = residual(simulations, fixed, criterion.train)
            if now is not None and np.isfinite(now).all():
                explanations.append(criterion.plain(Fit(fixed, now)))
        floors = measure(simulations, ())
    labels = [str(e.fit.changes[0].suspect) if e.fit.changes else "nothing" for e in explanations]
    targets = tuple(c.suspect for e in explanations for c in e.fit.changes)
    questions = tuple(Question(0, k, (labels[0], labels[k]), targets, 0.0) for k in range(1, len(explanations)))
    recorded = np.concatenate([c.value("position") for c in problem.cases])
    try:
        limits = limits_of(problem.plant.model, spec, recorded, problem.plant.reached)
    except InputError:
        return 0, []
    result = Proposal(problem, Open(tuple(explanations), questions), limits, pose_of(problem, spec.pose))
    if questions:
        design(result, spec, floors, engines, SECONDS, 1, lambda _: None, 1)
    out = []
    for proposed in result.proposed:
        write_motion(result, proposed.motion, folder)
        (played,) = experiments(load_scenario(folder / f"{proposed.motion.name}.yaml"))
        for engine in proposed.engines:
            for label, explanation in zip(labels, explanations, strict=True):
                plant = changed(played.plant, explanation.fit.changes, problem.plant)
                try:
                    trace = simulate(played.with_plant(plant), engine).trace
                except (Diverged, Unsupported, Failed) as error:
                    out.append(Left(seed, engine, label, float("nan"), str(error)))
                    continue
                over = {what: float(far.max()) for what, far in limits.over(trace).items()}
                trace = trace.between(BEFORE if standing else 0.0, np.inf)  # it settles on its foot first
                lost = lost_footing(plant.loaded(), trace) if standing else trace.time[:0]
                if max(over.values()) > 0.0 or len(lost):
                    first = limits.first(trace)
                    out.append(Left(seed, engine, label, first or 0.0, f"{over}, off its foot {lost[:1]} s"))
    return len(result.proposed), out
