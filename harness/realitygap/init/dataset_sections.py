"""The first scenario of a LeRobot data set: every episode is a run."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from realitygap_engines.model.robot import Joint, Model

from realitygap.files.errors import InputError
from realitygap.init.names import words
from realitygap.init.sections import Motion, Sections, no_motion, quoted, relative
from realitygap.recording.commands import held_at
from realitygap.recording.readers.lerobot import FEATURES, short
from realitygap.recording.readers.lerobot_folder import DataFolder, EpisodeRows, open_folder
from realitygap.trace.trace import Array

PART = 12.0
"""How much of an episode a first look simulates at most [s]."""
LOOK = 360.0
"""How much of all episodes together [s]: three quarters of a minute of one core for a six-joint arm in MuJoCo."""
LEAST = 2.0
"""How much of an episode shows anything [s]."""
GRID = 0.1
"""On which the command's motion is summed [s]."""
BEYOND = 15.0
"""How far beyond a limit of the URDF an angle may be read [°]: calibrations and models differ."""


def dataset_sections(paths: list[Path], model: Model, urdf: Path, out: Path) -> Sections:
    """Motion, recordings and runs of data sets that are built like the first one.

    Raises:
        InputError: for a data set without positions, or without one of the robot's joints.
    """
    folders = [open_folder(path) for path in paths]
    first = folders[0]
    for folder in folders:
        if FEATURES["position"] not in folder.features:
            raise InputError(
                f"{folder.path}: has no feature {FEATURES['position']}; it has {', '.join(folder.features)}; expected "
                "a data set with the measured joint positions"
            )
    joints, said = _joints(first, model, urdf)
    count = sum(len(folder.episodes) for folder in folders)
    length = min(PART, max(LEAST, LOOK / count))
    command = FEATURES["command"] in first.features
    runs, values = [], []
    for folder in folders:
        for episode in folder.episodes:
            time, moved, position = _looked_at(folder, episode, list(joints.values()), command=command)
            values.append(position)
            runs.append(_run(folder, episode, out, _most(time, moved, length)))
    units, why = _units(np.vstack(values), [joint for joint in model.joints if joint.name in joints])
    named = {joint: name for joint, name in joints.items() if joint != name}
    lines = ["  dataset:", *units]
    if named:
        inner = ", ".join(f"{quoted(j)}: {quoted(n)}" for j, n in named.items())
        lines.append(f"    joints: {{{inner}}}  # GUESS: {said}")
    told = [f"{why}: a calibration file or the data set's author can tell"]
    told += _unused(first)
    if length < PART or any("part:" in run for run in runs):
        told.append(
            f"of every episode the {length:g} s with the most motion are simulated (`part`), which makes a first look "
            "short: remove `part` to take all of it"
        )
    motion = Motion({"recorded": FEATURES["command"]}) if command else no_motion("FEATURE")
    if not command:
        told.append(f"{FEATURES['command']} is missing: nothing drives the joints")
    left = tuple(joint for joint in model.joint_names if joint not in joints)
    return Sections(motion, lines, runs, robot=first.robot, told=told, held=left)


def _joints(folder: DataFolder, model: Model, urdf: Path) -> tuple[dict[str, str], str]:
    """The data set's name of every joint, or of those that mimic no other, and how it was found."""
    labels = [short(label) for label in folder.features[FEATURES["position"]]]
    free = [joint for joint in model.joint_names if joint not in model.mimics]
    for joints in (model.joint_names, free):
        if (found := _called(labels, joints)) is not None:
            return found
    raise InputError(
        f"{folder.path}: {FEATURES['position']} has {', '.join(labels)}, which are not the joints of {urdf}: "
        f"{', '.join(model.joint_names)}; expected the same names, or as many"
    )


def _called(labels: Sequence[str], joints: Sequence[str]) -> tuple[dict[str, str], str] | None:
    """What labels call every joint, and how that was found: by name, by words in the name, or by order."""
    if all(joint in labels for joint in joints):
        return {joint: joint for joint in joints}, "by name"
    found = {}
    for joint in joints:
        own = set(words(joint))
        alike = [label for label in labels if own <= set(words(label)) or set(words(label)) <= own]
        if len(alike) == 1:
            found[joint] = alike[0]
    if len(set(found.values())) == len(joints):
        return found, "by the words in their names"
    if len(labels) == len(joints):
        return dict(zip(joints, labels, strict=True)), "by their order, which need not be the same"
    return None


def _looked_at(
    folder: DataFolder, episode: EpisodeRows, names: Sequence[str], *, command: bool
) -> tuple[Array, Array, Array]:
    """Times (t,) [s], what moves (t, n) and the positions (t, n), in the data set's units."""
    state = FEATURES["position"]
    moving = FEATURES["command"] if command else state
    table = folder.rows(episode, [*dict.fromkeys(("timestamp", "frame_index", moving, state))])
    key, unit = ("timestamp", 1.0) if "timestamp" in table.column_names else ("frame_index", folder.fps)
    time = np.array(table.column(key).to_pylist(), dtype=float).reshape(-1) / unit
    order = np.argsort(time, kind="stable")

    def values(feature: str) -> Array:
        labels = [short(label) for label in folder.features[feature]]
        rows = np.array(table.column(feature).to_pylist(), dtype=float).reshape(len(time), -1)
        return np.asarray(rows[order][:, [labels.index(name) for name in names if name in labels]])

    return time[order] - time[order][0], values(moving), values(state)


def _most(time: Array, moved: Array, length: float) -> tuple[float, float] | None:
    """The stretch of this length [s] in which the values move most; None for an episode that is hardly longer."""
    if time[-1] <= length + 1.0:
        return None
    grid = np.arange(0.0, time[-1], GRID)
    path = np.abs(np.diff(held_at(time, moved, grid), axis=0)).sum(axis=1)
    sums = np.concatenate([[0.0], np.cumsum(np.nan_to_num(path))])
    steps = round(length / GRID)
    start = round(float(grid[np.argmax(sums[steps:] - sums[:-steps])]), 1)
    return start, round(start + length, 1)


def _run(folder: DataFolder, episode: EpisodeRows, out: Path, part: tuple[float, float] | None) -> str:
    tasks = [task for other in folder.episodes for task in other.tasks]
    named = [task for task in episode.tasks if tasks.count(task) == 1 and len(words(task)) <= 4]
    which = quoted(named[0]) if named else str(episode.number)
    span = f", part: [{part[0]:g}, {part[1]:g}]" if part else ""
    note = f"  # {', '.join(episode.tasks)}" if episode.tasks and not named else ""
    return f"    - {{path: {quoted(relative(folder.path, out))}, episode: {which}{span}}}{' '.join(note.splitlines())}"


def _units(values: Array, joints: Sequence[Joint]) -> tuple[list[str], str]:
    """The lines of units, and what was guessed of them: degrees where they fit the URDF's limits, else normalized."""
    limits = np.array([[joint.lower, joint.upper] for joint in joints])
    low, high = np.nanmin(values, axis=0), np.nanmax(values, axis=0)
    if max(abs(low).max(), abs(high).max()) <= np.abs(np.where(np.isfinite(limits), limits, np.pi)).max():
        return ["    units: radians  # GUESS: no value is larger than the URDF's limits"], "positions taken as radians"
    degrees = np.degrees(limits)
    fits = (low >= degrees[:, 0] - BEYOND) & (high <= degrees[:, 1] + BEYOND)
    if fits.all() or max(abs(low).max(), abs(high).max()) > 101.0:
        why = "they fit the URDF's limits" if fits.all() else "some are beyond 100"
        return [f"    units: degrees  # GUESS: {why}"], "positions taken as degrees"
    lines = ["    units: normalized  # GUESS: in degrees they would be beyond the URDF's limits"]
    lines.append("    range:  # GUESS: that the ends of the units are the URDF's limits; a calibration file says it")
    for joint, (lower, upper) in zip(joints, limits, strict=True):
        if np.isfinite([lower, upper]).all():
            lines.append(f"      {quoted(joint.name)}: [{lower:g}, {upper:g}]")
        else:
            lines.append(f"      {quoted(joint.name)}: [{-np.pi:.5f}, {np.pi:.5f}]  # GUESS: the URDF has no limits")
    return lines, "positions taken as normalized units"


def _unused(folder: DataFolder) -> list[str]:
    own = {"timestamp", "frame_index", "episode_index", "index", "task_index"}
    used = {FEATURES[s] for s in ("position", "velocity", "command")}
    spare = [name for name in folder.features if name not in own | used]
    told = [f"not used: {', '.join(spare)}"] if spare else []
    if FEATURES["effort"] in spare:
        told.append(
            f"{FEATURES['effort']} has no unit in the data set, and servos often report a magnitude without sign; "
            "recordings.effort takes it where its meaning is known"
        )
    if FEATURES["velocity"] not in folder.features:
        told.append(f"{FEATURES['velocity']} is missing: velocities are not compared")
    return told
