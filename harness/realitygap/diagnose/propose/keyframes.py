"""A proposed motion as the keyframes of an animation: few of them, between which straight lines are the motion."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from realitygap_engines.model.robot import Model

from realitygap.diagnose.propose.excitation import BEFORE, Excitation
from realitygap.robot.drive import Array
from realitygap.scenario.schema import Motion
from realitygap.simulate.experiment import AFTER, Experiment
from realitygap.simulate.motion import TICK, Animation, first_goals, play

EXACT = 2e-4
"""How far straight lines between keyframes may be from the motion [rad or m]: a tenth of a small servo's quantum."""


def corners(time: Array, value: Array, marks: Array) -> list[int]:
    """The samples between which straight lines follow a motion (Ramer 1972; Douglas & Peucker 1973).

    Args:
        time: Shape (t,).
        value: Shape (t, n).
        marks: numbers of samples that have to be among them.
    """
    kept = {0, len(time) - 1, *marks.tolist()}
    todo = sorted(kept)
    spans = list(pairwise(todo))
    while spans:
        a, b = spans.pop()
        if b - a < 2:
            continue
        share = ((time[a : b + 1] - time[a]) / (time[b] - time[a]))[:, None]
        far = np.abs(value[a : b + 1] - (value[a] + share * (value[b] - value[a]))).max(axis=1)
        worst = a + int(np.argmax(far))
        if far[worst - a] > EXACT:
            kept.add(worst)
            spans += [(a, worst), (worst, b)]
    return sorted(kept)


def waypoints(motion: Excitation, apart: float = 0.0) -> tuple[Array, Array, Array]:
    """Times (k,) [s], positions (k, n) and whether servos are on (k, n) up to there, at least `apart` [s] apart."""
    value = motion.path
    every = max(int(np.ceil(apart / motion.period - 1e-6)), 1)
    rows = np.unique([*range(0, len(value) - every, every), len(value) - 1])
    time, value, on = motion.time[rows], value[rows], np.isfinite(motion.value)[rows]
    switched = np.flatnonzero((on[1:] != on[:-1]).any(axis=1))
    chosen = corners(time, value, np.unique(np.concatenate([switched, switched + 1])))
    return time[chosen], value[chosen], on[chosen]


def standing(model: Model) -> float:
    """How long a robot stands in the pose before its keyframes move [s]: one on its feet settles on them first."""
    return BEFORE if model.floating else 0.0


def animation(motion: Excitation, model: Model) -> dict[str, Any]:
    """The content of an animation file: goals in degrees, durations, servos that are off.

    A player takes at least a tick from one keyframe to the next, so that a step takes one, too.
    """
    joints = model.joint_names
    time, value, on = waypoints(motion, TICK)
    goals = np.rad2deg(value)  # also of prismatic joints: a player takes degrees
    frames = []
    for k in range(len(time)):
        frame: dict[str, Any] = {
            "name": f"{k}",
            "duration": round(float(time[k] - time[k - 1]), 6) if k else 0.0,
            "pause": 0.0 if k else standing(model),
            "goals": {name: round(float(v), 5) for name, v in zip(joints, goals[k], strict=True)},
        }
        if not on[k].all():
            frame["torque"] = {name: int(good) for name, good in zip(joints, on[k], strict=True)}
        frames.append(frame)
    return {"name": motion.name, "keyframes": frames}


def played(motion: Excitation, designed: Experiment) -> Experiment:
    """The simulation of a motion as its animation is played, on the motion's clock: it begins a tick before, and before
    that a robot on its feet stands.

    The commands are not those that were designed: a step takes a tick, goals are rounded, and a servo that samples them
    slowly samples others, a tick apart.
    """
    path, model = Path(f"{motion.name}.json"), designed.plant.model
    content = Animation.model_validate(animation(motion, model))
    commands, length = play(path, content, model, first_goals(path, content, model))
    scenario = designed.scenario
    robot = scenario.robot.model_copy(update={"start": "keyframe"})
    return replace(
        designed,
        scenario=scenario.model_copy(update={"robot": robot, "motion": Motion(keyframes=path.name)}),
        recording=None,
        commands=commands,
        begin=-TICK - standing(model),
        duration=length + AFTER,
    )
