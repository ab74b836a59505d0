"""Small files of every kind that work as they are; what is fuzzed is made of them."""

import io
import json
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

JOINTS = ("shoulder", "elbow")
SAMPLES, PERIOD = 60, 0.01
URDF = """<robot name="arm"><link name="base"/>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0" rpy="0 0 0"/>
<axis xyz="0 1 0"/><limit lower="-3.2" upper="3.2" effort="13.78" velocity="6.2"/><dynamics damping="0.1" friction="0"/>
</joint><link name="upper"><inertial><origin xyz="0 0 -0.1143" rpy="0 0 0"/><mass value="1.32"/>
<inertia ixx="0.0036" ixy="0" ixz="0" iyy="0.0036" iyz="0" izz="8.5e-05"/></inertial></link>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0 0 -0.1585" rpy="0 0 0"/>
<axis xyz="0 1 0"/><limit lower="-3.2" upper="3.2" effort="13.78" velocity="6.2"/><mimic joint="shoulder" offset="0"/>
</joint><link name="fore"><inertial><origin xyz="0 0 -0.1115" rpy="0 0 0"/><mass value="1.203"/>
<inertia ixx="0.004" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="9.3e-05"/></inertial>
<collision><origin xyz="0 0 -0.1"/><geometry><box size="0.1 0.1 0.2"/></geometry></collision></link></robot>"""
SCENARIO: dict[str, Any] = {
    "name": "arm",
    "robot": {"urdf": "arm.urdf", "base": "fixed"},
    "servos": [{"name": "drive", "joints": "*", "kind": "pid", "kp": 20.0, "kd": 1.0}],
    "motion": {"recorded": "command"},
    "physics": {"step_rate": 500},
    "effects": [{"effect": "coulomb_friction", "target": "elbow", "torque": 0.1}],
    "recordings": {"effort": "none", "runs": [{"path": "run.csv", "window": [0.1, 0.5]}]},
    "budget": {"position": 50.0},
}
ANIMATION: dict[str, Any] = {"name": "move", "keyframes": [{"duration": 0.2, "pause": 0.1, "goals": {"elbow": 10.0}}]}
MATRIX: dict[str, Any] = {
    "name": "all",
    "scenarios": "scenario.yaml",
    "engines": ["mujoco"],
    "axes": {"step_rate": [500, 1000], "servos.drive.kp": [10.0, 20.0]},
    "leave_out": [{"step_rate": 500, "servos.drive.kp": 10.0}],
}
BENCHES: dict[str, dict[str, Any]] = {
    "supply": {
        "table": "voltages.csv",
        "units": {"voltage": "V", "current": "A"},
        "chains": [{"name": "chain", "motors": ["m0"]}],
        "drive": {"torque_constant": 2.19, "resistance": 2.96},
    },
    "links": {
        "urdf": "arm.urdf",
        "masses": {"table": "masses.csv", "unit": "kg"},
        "parts": [{"name": "fore", "links": ["fore"]}],
    },
    "servo": {
        "units": {"torque": "N·m", "speed": "rad/s", "supply": "V", "load": "kg"},
        "torque_speed": "torque_speed.csv",
        "nominal_supply": "14.8 V",
        "types": [{"name": "MX", "datasheet": {"supply": "14.8 V", "stall_torque": "7.3 N·m"}, "joints": ["*"]}],
    },
}


def motion() -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and the angles of both joints [rad], which their commands are, too."""
    time = np.arange(SAMPLES) * PERIOD
    return time, 0.3 * np.sin(6.0 * time[:, None] + np.arange(len(JOINTS)))


@cache
def table() -> pd.DataFrame:
    """The motion as a table."""
    time, angle = motion()
    columns = {"time": time}
    for signal in ("position", "command"):
        columns |= {f"{signal}_{joint}": angle[:, j] for j, joint in enumerate(JOINTS)}
    return pd.DataFrame(columns)


@cache
def csv() -> bytes:
    """The table as text."""
    return table().to_csv(index=False).encode()


@cache
def parquet() -> bytes:
    """The table as Parquet."""
    out = io.BytesIO()
    table().to_parquet(out)
    return out.getvalue()


@cache
def bag() -> bytes:
    """The motion as a bare MCAP file."""
    time, angle = motion()
    return mcap([(t, list(JOINTS), row, row) for t, row in zip(time.tolist(), angle.tolist(), strict=True)])


def mcap(messages: list[tuple[float, list[str], list[float], list[float]]], topic: str = "/joint_states") -> bytes:
    """A bare MCAP file of joint states: stamp [s], names, positions and velocities of each message."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    kind = "sensor_msgs/msg/JointState"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bag"
        with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
            connection = writer.add_connection(topic, kind, typestore=store)
            for stamp, names, position, velocity in messages:
                ns = max(round(stamp * 1e9), 0)
                header = types["std_msgs/msg/Header"](
                    types["builtin_interfaces/msg/Time"](ns // 10**9 % 2**31, ns % 10**9), ""
                )
                values = (np.asarray(v, dtype=np.float64) for v in (position, velocity, []))
                writer.write(connection, ns, store.serialize_cdr(types[kind](header, names, *values), kind))
        return next(path.glob("*.mcap")).read_bytes()


def dumped(content: object) -> bytes:
    """JSON, which is YAML, too."""
    return json.dumps(content).encode("utf-8", "surrogatepass")


def files(**changed: bytes) -> dict[str, bytes]:
    """The files of a scenario that runs, by name with __ in place of the dot; some of them changed."""
    out = {"arm.urdf": URDF.encode(), "run.csv": csv(), "scenario.yaml": dumped(SCENARIO)}
    return out | {name.replace("__", "."): content for name, content in changed.items()}


def written(folder: Path, content: dict[str, bytes]) -> None:
    """Write files into a folder."""
    folder.mkdir(exist_ok=True)
    for name, data in content.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
