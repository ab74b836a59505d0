"""Keyframe animations: goals in degrees with a duration and a pause, as robot teams keep them."""

import json
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field
from realitygap_engines.model.robot import Model

from realitygap.files.errors import InputError
from realitygap.files.found import kind_of
from realitygap.files.plain_file import read_written
from realitygap.files.validation import validate
from realitygap.scenario.section import Finite, NotNegative
from realitygap.simulate.commands import Commands

TICK = 0.01
"""Spacing of the commands that an animation is turned into [s]."""
LEEWAY = np.deg2rad(2.0)
"""A goal may lie this far outside a limit: the Wolfgang's own cheering does, by 1°, and the stop holds it."""


class Keyframe(BaseModel):
    """Goals [°] by joint, reached after `duration` [s] and held for `pause` [s].

    A joint whose `torque` is 0 has its servo off in that time.
    """

    model_config = ConfigDict(extra="ignore")
    goals: dict[str, Finite]
    duration: NotNegative
    pause: NotNegative = 0.0
    torque: dict[str, Finite] = {}
    name: str = ""


class Animation(BaseModel):
    """An animation file; keys that a player does not need (author, ...) are ignored."""

    model_config = ConfigDict(extra="ignore")
    name: str = ""
    keyframes: Annotated[list[Keyframe], Field(min_length=1)]


def read_animation(path: Path) -> Animation:
    """The animation in a JSON file.

    Raises:
        InputError: for a file that is not one.
    """
    try:
        raw = json.loads(read_written(path))
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); expected an animation file") from None
    except RecursionError:
        raise InputError(f"{path}: is nested too deeply; expected an object with keyframes") from None
    except ValueError as error:
        raise InputError(f"{path}: is not valid JSON ({error}); expected an animation with keyframes") from None
    if not isinstance(raw, dict):
        raise InputError(f"{path}: holds {kind_of(raw)}, expected an object with keyframes")
    return validate(path, Animation, raw)


def first_goals(path: Path, animation: Animation, model: Model) -> np.ndarray:
    """The joint angles [rad] of the first keyframe; joints that it leaves out are at zero. Shape (n,)."""
    return _goals(path, animation.keyframes[0], model, np.zeros(len(model.joints)))


def play(path: Path, animation: Animation, model: Model, start: np.ndarray) -> tuple[Commands, float]:
    """The commands of an animation that starts at joint angles (n,) [rad], and how long it takes [s].

    Between keyframes the goals move linearly; a joint that a keyframe leaves out holds its goal.

    Raises:
        InputError: for a goal of an unknown joint or outside its limits.
    """
    times, values, off = [0.0], [np.asarray(start, dtype=float)], [np.zeros(len(start), dtype=bool)]
    for keyframe in animation.keyframes:
        goals, limp = _goals(path, keyframe, model, values[-1]), _limp(path, keyframe, model)
        if (limp != off[-1]).any():  # a servo is off from the end of the keyframe before on
            times.append(times[-1])
            values.append(values[-1])
            off.append(limp)
        times.append(times[-1] + max(keyframe.duration, TICK))
        values.append(goals)
        off.append(limp)
        if keyframe.pause > 0:
            times.append(times[-1] + keyframe.pause)
            values.append(goals)
            off.append(limp)
    told = np.where(np.array(off), np.nan, np.array(values))
    return Commands(np.array(times), told, held=False), times[-1]


def _limp(path: Path, keyframe: Keyframe, model: Model) -> np.ndarray:
    """Which servos are off. Shape (n,)."""
    names = model.joint_names
    unknown = [name for name in keyframe.torque if name not in names]
    if unknown:
        raise InputError(
            f"{path}: keyframe {keyframe.name!r} has a torque of {unknown[0]}; the robot has {', '.join(names)}"
        )
    return np.array([keyframe.torque.get(name, 1.0) == 0.0 for name in names])


def _goals(path: Path, keyframe: Keyframe, model: Model, before: np.ndarray) -> np.ndarray:
    names = model.joint_names
    out = before.copy()
    for name, degrees in keyframe.goals.items():
        if name not in names:
            raise InputError(f"{path}: keyframe {keyframe.name!r} moves {name}; the robot has {', '.join(names)}")
        joint = model.joints[names.index(name)]
        angle = np.deg2rad(degrees)
        if not joint.lower - LEEWAY <= angle <= joint.upper + LEEWAY:
            raise InputError(
                f"{path}: keyframe {keyframe.name!r} puts {name} at {degrees:g}°, outside its limits "
                f"{np.rad2deg(joint.lower):.1f}° to {np.rad2deg(joint.upper):.1f}°"
            )
        out[names.index(name)] = angle
    return out
