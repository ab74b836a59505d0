"""A motion that is to be performed, as a bare MCAP file with one `trajectory_msgs/JointTrajectory`."""

import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from realitygap.trace.trace import Array

TOPIC = "/joint_trajectory"


def write_trajectory(path: Path, joints: Sequence[str], time: Array, position: Array) -> None:
    """Write points between which a controller goes in straight lines, as it does where they have no velocities.

    Args:
        path: of the file, which is written whole or not at all.
        joints: n names.
        time: from the start [s], increasing. Shape (t,).
        position: [rad or m]. Shape (t, n).
    """
    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    stamp, duration = types["builtin_interfaces/msg/Time"], types["builtin_interfaces/msg/Duration"]
    point, kind = types["trajectory_msgs/msg/JointTrajectoryPoint"], "trajectory_msgs/msg/JointTrajectory"
    after = np.round(time * 1e9).astype(np.int64)
    none = np.zeros(0)
    points = [
        point(np.ascontiguousarray(p), none, none, none, duration(int(t // 10**9), int(t % 10**9)))
        for p, t in zip(position, after, strict=True)
    ]
    message = types[kind](types["std_msgs/msg/Header"](stamp(0, 0), ""), list(joints), points)
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        bag = Path(folder) / "bag"
        with Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
            connection = writer.add_connection(TOPIC, kind, typestore=store)
            writer.write(connection, 0, store.serialize_cdr(message, kind))
        shutil.move(next(bag.glob("*.mcap")), path)
