"""Traces as bare MCAP files with standard messages, for PlotJuggler, Foxglove and Rerun."""

import shutil
import tempfile
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from realitygap.trace.trace import Trace

RATE = 200.0
"""Simulated traces are thinned to about this many samples per second [Hz]: more than any viewer shows."""


def write_mcap(path: Path, traces: dict[str, Trace]) -> None:
    """Write traces side by side: `/NAME/joint_states` and, for a moving base, `/NAME/base_pose`, per name.

    Angles in rad, stamps in seconds of the recording's clock. The file is written whole or not at all.
    """
    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        bag = Path(folder) / "bag"
        with Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
            for name, full in traces.items():
                trace = _thinned(full)
                stamps = np.round((trace.time - min(trace.time[0], 0.0)) * 1e9).astype(np.int64)
                header = types["std_msgs/msg/Header"]
                time = types["builtin_interfaces/msg/Time"]
                headers = [header(time(int(s // 10**9), int(s % 10**9)), name) for s in stamps]
                joint_state = types["sensor_msgs/msg/JointState"]
                if trace.joints:
                    kind = "sensor_msgs/msg/JointState"
                    connection = writer.add_connection(f"/{name}/joint_states", kind, typestore=store)
                    columns = [_rows(trace, s) for s in ("position", "velocity", "effort")]
                    for k, s in enumerate(stamps):
                        message = joint_state(headers[k], list(trace.joints), *(c[k] for c in columns))
                        writer.write(connection, int(s), store.serialize_cdr(message, kind))
                if trace.base_position is not None and trace.base_quaternion is not None:
                    kind = "geometry_msgs/msg/PoseStamped"
                    connection = writer.add_connection(f"/{name}/base_pose", kind, typestore=store)
                    for k, s in enumerate(stamps):
                        w, x, y, z = trace.base_quaternion[k].tolist()
                        pose = types["geometry_msgs/msg/Pose"](
                            types["geometry_msgs/msg/Point"](*trace.base_position[k].tolist()),
                            types["geometry_msgs/msg/Quaternion"](x, y, z, w),
                        )
                        message = types[kind](headers[k], pose)
                        writer.write(connection, int(s), store.serialize_cdr(message, kind))
        shutil.move(next(bag.glob("*.mcap")), path)


def _rows(trace: Trace, signal: str) -> np.ndarray:
    value = getattr(trace, signal)
    return np.zeros((len(trace.time), 0)) if value is None else np.ascontiguousarray(value, dtype=np.float64)


def _thinned(trace: Trace) -> Trace:
    if len(trace.time) < 3:
        return trace
    rate = (len(trace.time) - 1) / (trace.time[-1] - trace.time[0])
    every = max(int(rate // RATE), 1)
    return trace.rows(np.arange(0, len(trace.time), every))
