"""Synthetic LeRobot data sets in both layouts: two joints that swing, another motion in every episode."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from realitygap.robot.drive import Array

JOINTS = ("elbow", "gripper")
PERIOD = 0.02
LAYOUTS = {
    "v2.1": "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet",
    "v3.0": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
}
TASKS = ("lift", "lower")
COUNT = 60


def motion(episode: int, count: int = COUNT) -> tuple[Array, Array, Array]:
    """Position, command and velocity of both joints [rad], (t, 2) each."""
    time = np.arange(count)[:, None] * PERIOD
    pace = np.array([3.0, 5.0]) * (1 + episode)
    return 0.3 * np.sin(pace * time), 0.3 * np.sin(pace * (time + 0.05)), 0.3 * pace * np.cos(pace * time)


def data_set(
    path: Path,
    version: str = "v3.0",
    tasks: Sequence[str] = TASKS,
    scale: float = 180 / np.pi,
    offset: float = 0.0,
    names: str | None = "{}.pos",
    velocity: bool = True,
) -> Path:
    """A data set whose values are scale·angle + offset."""
    signals = {"observation.state": 0, "action": 1} | ({"observation.velocity": 2} if velocity else {})
    frames, episodes = [], []
    for k, task in enumerate(tasks):
        values = motion(k)
        columns = {f: list((scale * values[i] + offset * (i < 2)).astype(np.float32)) for f, i in signals.items()}
        count = range(COUNT)
        times = np.arange(COUNT, dtype=np.float32) * np.float32(PERIOD)
        frames.append(pd.DataFrame({**columns, "timestamp": times, "frame_index": count, "episode_index": k}))
        episodes.append({"episode_index": k, "tasks": [task], "length": COUNT})
    labels = None if names is None else [names.format(j) for j in JOINTS]
    features: dict[str, dict[str, Any]] = {f: {"dtype": "float32", "shape": [2], "names": labels} for f in signals}
    features["observation.images.top"] = {"dtype": "video", "shape": [3, 4, 3], "names": None}
    info = {"codebase_version": version, "fps": 50, "chunks_size": 1000, "features": features, "robot_type": "arm"}
    write(path / "meta" / "info.json", json.dumps(info | {"data_path": LAYOUTS[version]}))
    if version == "v3.0":
        table(pd.concat(frames), path / "data/chunk-000/file-000.parquet")
        rows = pd.DataFrame(episodes).assign(**{"data/chunk_index": 0, "data/file_index": 0})
        table(rows, path / "meta/episodes/chunk-000/file-000.parquet")
        table(pd.DataFrame({"task_index": range(len(tasks))}, index=list(tasks)), path / "meta/tasks.parquet")
    else:
        for k, frame in enumerate(frames):
            table(frame, path / LAYOUTS[version].format(episode_chunk=0, episode_index=k))
        write(path / "meta/episodes.jsonl", "\n".join(json.dumps(e) for e in episodes))
        tasks_rows = [json.dumps({"task_index": k, "task": t}) for k, t in enumerate(tasks)]
        write(path / "meta/tasks.jsonl", "\n".join(tasks_rows))
    return path


def write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def table(frame: pd.DataFrame, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    frame.to_parquet(path)
