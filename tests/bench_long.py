"""What a long recording takes: the CPU seconds and the memory of `realitygap run`, and the size of what it leaves.

    python tests/bench_long.py [--minutes 60] [--rate 500] [--joints 20] [--format mcap parquet] [--keep FOLDER]

The robot is a row of pendulums with servos; its recording is *synthetic*, in closed form, with the readings of encoders
of 4096 steps. Memory is the largest sum over all processes of what each holds alone and its share of what several hold
(PSS), and the largest of one process (RSS), looked at four times a second.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

Array = NDArray[np.float64]
KP = 60.0
"""Stiffness of the servos [N·m/rad]."""
MASS, LEVER, INERTIA, DAMPING = 0.3, 0.2, 0.01, 0.1
"""Of a pendulum: kg, m, kg·m² about its centre of mass, N·m·s/rad."""
GRAVITY = 9.81
COUNT = 2 * np.pi / 4096
"""Quantum of the encoders [rad]."""
PART = 100_000
"""Samples that are made at a time."""


def urdf(joints: int) -> str:
    """Pendulums beside one another on a base that stands still."""
    out = ['<robot name="row"><link name="base"/>']
    for j in range(joints):
        out.append(
            f'<joint name="joint_{j}" type="revolute"><parent link="base"/><child link="link_{j}"/>'
            f'<origin xyz="0 {0.2 * j} 0"/><axis xyz="0 1 0"/>'
            f'<limit lower="-3.1" upper="3.1" effort="40" velocity="20"/><dynamics damping="{DAMPING}" friction="0"/>'
            f'</joint><link name="link_{j}"><inertial><origin xyz="0 0 -{LEVER}"/><mass value="{MASS}"/>'
            f'<inertia ixx="{INERTIA}" ixy="0" ixz="0" iyy="{INERTIA}" iyz="0" izz="{INERTIA}"/></inertial></link>'
        )
    return "".join([*out, "</robot>"])


def scenario(recording: str, rate: float) -> dict[str, object]:
    """The scenario, which is YAML as JSON is."""
    topics = {"state": "/joint_states", "effort": "motor"} if recording.endswith(".mcap") else {"effort": "motor"}
    return {
        "name": "long",
        "robot": {"urdf": "row.urdf", "base": "fixed"},
        "servos": [{"joints": "*", "kind": "pid", "kp": KP}],
        "motion": {"recorded": "/joint_commands" if recording.endswith(".mcap") else "command"},
        "physics": {"step_rate": rate},
        "recordings": {**topics, "virtual": True, "runs": [{"path": recording}]},
    }


def readings(time: Array, joints: int) -> tuple[Array, Array, Array, Array]:
    """Command, position, velocity and effort at some times, in rad, rad/s and N·m. Shapes (t, n)."""
    pace = np.asarray(2 * np.pi * (0.2 + 0.02 * np.arange(joints)), dtype=np.float64)
    phase = time[:, None] * pace + np.arange(joints)
    angle: Array = 0.3 * np.sin(phase)
    speed: Array = 0.3 * pace * np.cos(phase)
    inertia, weight = INERTIA + MASS * LEVER**2, MASS * GRAVITY * LEVER
    effort = -inertia * pace**2 * angle + DAMPING * speed + weight * np.sin(angle)
    return angle + effort / KP, np.round(angle / COUNT) * COUNT, speed, effort


def parts(samples: int, rate: float) -> list[Array]:
    """The times of all samples [s], some at a time."""
    return [np.arange(k, min(k + PART, samples)) / rate for k in range(0, samples, PART)]


def write_mcap(path: Path, samples: int, rate: float, joints: int) -> None:
    """States and commands as sensor_msgs/JointState, each a topic of its own."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    types, kind = store.types, "sensor_msgs/msg/JointState"
    names = [f"joint_{j}" for j in range(joints)]

    def message(stamp: int, *values: Array) -> bytes:
        header = types["std_msgs/msg/Header"](
            types["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9), "base"
        )
        return bytes(store.serialize_cdr(types[kind](header, names, *values), kind))

    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        with Writer(Path(folder) / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
            states, commands = (
                writer.add_connection(topic, kind, typestore=store) for topic in ("/joint_states", "/joint_commands")
            )
            none = np.empty(0)
            for times in parts(samples, rate):
                for t, c, q, w, e in zip(times, *readings(times, joints), strict=True):
                    stamp = 1_700_000_000_000_000_000 + round(t * 1e9)
                    writer.write(commands, stamp, message(stamp, c, none, none))
                    writer.write(states, stamp + 100_000, message(stamp + 100_000, q, w, e))
        next(Path(folder).rglob("*.mcap")).rename(path)


def write_parquet(path: Path, samples: int, rate: float, joints: int) -> None:
    """All signals in one table."""
    writer = None
    for times in parts(samples, rate):
        columns: dict[str, Array] = {"time": times}
        for name, values in zip(("command", "position", "velocity", "effort"), readings(times, joints), strict=True):
            columns |= {f"{name}_joint_{j}": np.ascontiguousarray(values[:, j]) for j in range(joints)}
        table = pa.table(columns)
        writer = writer or pq.ParquetWriter(path, table.schema, compression="zstd")
        writer.write_table(table)
    assert writer is not None
    writer.close()


def family(pid: int) -> list[int]:
    """A process and all that came of it."""
    out = [pid]
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        out += [p for child in task.read_text().split() for p in family(int(child))]
    return out


def held(pid: int) -> tuple[float, float]:
    """PSS and RSS of a process [MB]; nothing where it has ended."""
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()[1:]
    except OSError:
        return 0.0, 0.0
    found = {line.split(":")[0]: float(line.split()[1]) / 1000 for line in lines if line.endswith("kB")}
    return found.get("Pss", 0.0), found.get("Rss", 0.0)


def measured(command: list[str], told: Path) -> tuple[float, float, float, float]:
    """CPU seconds and wall seconds of a command, the largest memory of all its processes and of one [MB]."""
    began, before = time.monotonic(), os.times()
    together = alone = 0.0
    with told.open("w") as said:
        process = subprocess.Popen(command, stdout=said, stderr=subprocess.STDOUT)
        while process.poll() is None:
            found = [held(pid) for pid in family(process.pid)]
            together, alone = max(together, sum(p for p, _ in found)), max([alone, *(r for _, r in found)])
            time.sleep(0.25)
    after = os.times()
    cpu = after.children_user + after.children_system - before.children_user - before.children_system
    if process.returncode:
        sys.exit(f"{' '.join(command)} ended with {process.returncode}:\n{told.read_text()}")
    return cpu, time.monotonic() - began, together, alone


def main() -> None:
    """One line per format of the recording."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--rate", type=float, default=500.0, help="Hz of the recording, and of the simulation's steps")
    parser.add_argument("--joints", type=int, default=20)
    parser.add_argument("--engine", default="mujoco")
    parser.add_argument("--format", nargs="+", default=["mcap", "parquet"], choices=["mcap", "parquet"])
    parser.add_argument("--keep", type=Path, help="a folder for recordings, which are made once, and results")
    args = parser.parse_args()
    samples = round(60 * args.minutes * args.rate)
    with tempfile.TemporaryDirectory() as name:
        folder = args.keep or Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "row.urdf").write_text(urdf(args.joints))
        for form in args.format:
            path = folder / f"long_{args.minutes:g}_{args.rate:g}_{args.joints}.{form}"
            if not path.exists():
                {"mcap": write_mcap, "parquet": write_parquet}[form](path, samples, args.rate, args.joints)
            file, out = folder / f"{form}.yaml", folder / f"results_{form}"
            file.write_text(json.dumps(scenario(path.name, args.rate)))
            command = ["-m", "realitygap.cli.main", "run", str(file), "--engine", args.engine, "--out", str(out)]
            cpu, wall, together, alone = measured([sys.executable, *command], folder / f"{form}.txt")
            left = sum(f.stat().st_size for f in out.rglob("*") if f.is_file())
            size = path.stat().st_size / 1e6
            sys.stdout.write(
                f"{form}: {args.minutes:g} min, {args.rate:g} Hz, {args.joints} joints, {size:.0f} MB: {cpu:.0f} "
                f"CPU-s, {wall:.0f} s, {together:.0f} MB in all, {alone:.0f} MB in one process; the result folder has "
                f"{left / 1e6:.1f} MB\n"
            )
            sys.stdout.flush()


if __name__ == "__main__":
    main()
