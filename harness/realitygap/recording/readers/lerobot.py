"""LeRobot data sets (v2.0, v2.1 and v3.0): one episode of a folder with `meta/info.json`. Videos are not read."""

from pathlib import Path

import numpy as np
import pyarrow as pa

from realitygap.files.errors import InputError
from realitygap.recording.lack import Lack
from realitygap.recording.readers.lerobot_folder import DataFolder, EpisodeRows, open_folder
from realitygap.recording.readers.lerobot_units import scale_of
from realitygap.recording.readers.rows import Rows, last_of_each, out_of_order, repeats
from realitygap.recording.streams import Request, Samples, Streams
from realitygap.scenario.schema import LEFT_OUT
from realitygap.trace.trace import Array

FEATURES = {
    "position": "observation.state",
    "velocity": "observation.velocity",
    "effort": "observation.effort",
    "command": "action",
}
"""What LeRobot calls the signals."""
SUFFIXES = (".pos", ".vel", ".eff")
"""What LeRobot writes behind a joint's name in them."""


def read(path: Path, request: Request) -> Streams:
    """The streams of one episode, all on the clock of its rows.

    Raises:
        InputError: for an episode, feature or joint that is not there, normalized units without their range, or a file
            that is missing or broken.
    """
    if "units" in request.recordings.columns.model_fields_set:
        raise InputError(
            f"{request.file}: recordings.columns.units: are those of tables; expected dataset: {{units: …}}"
        )
    if request.recordings.joints:
        raise InputError(
            f"{request.file}: recordings.joints: are names of bags and tables; expected dataset: {{joints: …}}"
        )
    folder = open_folder(path)
    episode = folder.episode(request.recordings.episode, f"{request.file}: recordings: episode")
    names = {signal: name for signal in FEATURES if (name := _feature(folder, request, signal)) is not None}
    table = folder.rows(episode, ["timestamp", "frame_index", *dict.fromkeys(names.values())])
    time, keep, notes, dropped = _times(table, folder, episode)
    values = {s: _values(folder, episode, table, request, s, name)[keep] for s, name in names.items()}

    def samples(*signals: str) -> Samples | None:
        found = {s: values[s] for s in signals if s in values}
        return Samples(f"{path}: episode {episode.number}", time, found, request.joints) if found else None

    command = samples("command")
    if command is not None:
        command = Samples(command.source, time, {request.command_signal: values["command"]}, request.joints)
    state = samples("position", "velocity", "effort")
    files = (path / "meta" / "info.json", episode.file)
    return Streams(state, command, notes=tuple(notes), dropped=tuple(dropped), episode=episode.number, files=files)


def _feature(folder: DataFolder, request: Request, signal: str) -> str | None:
    """The feature that holds a signal; None where the scenario does not ask for it and it is not there."""
    columns, motion = request.recordings.columns, request.motion
    stated = getattr(columns, signal) if signal in columns.model_fields_set else None
    key = f"recordings.columns.{signal}"
    if signal == "effort":
        if request.effort_factor is None:
            return None
        if request.effort_topic is not None:
            stated, key = request.effort_topic, "recordings.effort.topic"
    if signal == "command" and stated is None and motion is not None and motion.recorded is not None:
        stated, key = motion.recorded, "motion.recorded"
    if isinstance(stated, dict):
        raise InputError(f"{request.file}: {key}: found a mapping, expected a feature of {folder.path} with all joints")
    if signal == "velocity" and stated == LEFT_OUT:
        return None
    name = stated or FEATURES[signal]
    if name in folder.features:
        return name
    if stated is None and signal in ("velocity", "command"):
        return None
    raise InputError(f"{request.file}: {key}: {folder.path} has no feature {name}; it has {', '.join(folder.features)}")


def _times(table: pa.Table, folder: DataFolder, episode: EpisodeRows) -> tuple[Array, Rows, list[str], list[Lack]]:
    """The times [s] of the rows, the rows in their order, what they were taken from, and what was dropped."""
    notes, dropped = list[str](), list[Lack]()
    if "timestamp" in table.column_names:
        time = _numbers(table, "timestamp", episode)[:, 0]
    elif "frame_index" in table.column_names:
        time = _numbers(table, "frame_index", episode)[:, 0] / folder.fps
        notes.append(f"there is no timestamp; times are the frames at {folder.fps:g} per s")
    else:
        raise InputError(f"{episode.file}: has neither timestamp nor frame_index; expected a time for every row")
    if not np.isfinite(time).all():
        raise InputError(f"{episode.file}: a timestamp of episode {episode.number} is not finite, expected s")
    order = np.argsort(time, kind="stable")
    keep = order[last_of_each(time[order])]
    if disorder := out_of_order(time):
        dropped.append(disorder)
    if len(keep) < len(time):
        dropped.append(repeats(len(keep), len(time)))
    return time[keep], keep, notes, dropped


def _values(
    folder: DataFolder, episode: EpisodeRows, table: pa.Table, request: Request, signal: str, name: str
) -> Array:
    """A signal in SI units, one column per joint."""
    whole = _numbers(table, name, episode)
    labels = folder.features[name]
    if whole.shape[1] != len(labels):
        raise InputError(f"{episode.file}: {name} holds {whole.shape[1]} values, expected {len(labels)} as in meta/")
    dataset = request.recordings.dataset
    quantity = request.command_signal if signal == "command" else signal
    columns = []
    for joint in request.joints:
        own = dataset.joints.get(joint, joint)
        index = next((i for i, label in enumerate(labels) if own in (label, short(label))), None)
        if index is None:
            raise InputError(
                f"{request.file}: recordings.dataset.joints: {name} of {folder.path} has no joint {own}; it has "
                f"{', '.join(map(short, labels))}; expected {{{joint}: ITS NAME THERE}}"
            )
        value = whole[:, index]
        if quantity != "effort":
            scale = scale_of(dataset, request.file, joint, short(labels[index]))
            value = scale.slope * value + (0.0 if quantity == "velocity" else scale.offset)
        columns.append(value)
    return np.column_stack(columns) if columns else np.empty((len(whole), 0))


def _numbers(table: pa.Table, name: str, episode: EpisodeRows) -> Array:
    """A column as floats, (t, k)."""
    if name not in table.column_names:
        raise InputError(f"{episode.file}: has no column {name}; it has {', '.join(table.column_names)}")
    try:
        rows = np.array(table.column(name).to_pylist(), dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{episode.file}: {name} does not hold the same count of numbers in every row") from None
    return rows.reshape(len(rows), -1)


def short(label: str) -> str:
    """A joint's name without what LeRobot writes behind it."""
    return next((label.removesuffix(s) for s in SUFFIXES if label.endswith(s)), label)
