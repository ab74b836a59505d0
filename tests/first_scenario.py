"""What a first scenario is made of in tests: an arm, and recordings of it."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from realitygap.recording import read_recording
from realitygap.recording.recording import Recording
from realitygap.scenario.file import load_scenario
from realitygap.scenario.schema import Scenario

STATE = "sensor_msgs/msg/JointState"
EPOCH = 1.7e9


def arm(
    path: Path,
    joints: Sequence[str] = ("shoulder", "elbow"),
    effort: float = 3.0,
    root: str = "base",
    feet: bool = False,
) -> Path:
    """A URDF with joints in a chain; with feet, both hang from the base and end in a foot."""
    links = [f'<link name="{root}">{INERTIAL}</link>']
    parent = root
    for joint in joints:
        child = f"{joint}_foot" if feet else f"{joint}_link"
        limit = f'<limit lower="-3" upper="3" effort="{effort}" velocity="6"/>'
        links.append(f'<link name="{child}">{INERTIAL}</link>')
        links.append(
            f'<joint name="{joint}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
            f'<axis xyz="0 1 0"/>{limit}</joint>'
        )
        parent = root if feet else child
    path.write_text(f'<robot name="arm">{"".join(links)}</robot>')
    return path


INERTIAL = '<inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'


def goal(t: Any) -> Any:
    return np.sin(3 * t) + 0.3 * np.sin(7 * t)


def messages(
    state: str = "/joint_states",
    command: str = "/joint_commands",
    velocity: bool = True,
    lag: float = 0.05,
    names: Sequence[str] = ("elbow", "shoulder", "gripper"),
) -> list[tuple[str, float, str, dict[str, Any]]]:
    out = []
    for k in range(300):
        t = 0.01 * k
        count = len(names)
        measured = {"stamp": EPOCH + t, "name": list(names), "position": [goal(t - lag)] * count}
        if velocity:
            measured["velocity"] = [1.0] * count
        asked = {"stamp": EPOCH + t, "name": list(names), "position": [goal(t)] * count}
        out += [(state, EPOCH + t, STATE, measured), (command, EPOCH + t, STATE, asked)]
    return out


def read_all(path: Path, joints: Sequence[str]) -> tuple[Scenario, list[Recording]]:
    loaded = load_scenario(path)
    return loaded.scenario, [read_recording(c.path, c.scenario, joints, file=path) for c in loaded.cases()]
