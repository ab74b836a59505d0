"""What tests of recordings ask a reader for, and the messages of two joints that they write."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from realitygap.recording import Recording
from realitygap.scenario.schema import Scenario

FORMS = ("bag", "mcap", "db3")
STATE = "sensor_msgs/msg/JointState"
EPOCH = 1.7e9
FILE = Path("scenario.yaml")


def scenario(
    state: str | dict[str, Any] | None = "/joint_states",
    command: str | dict[str, Any] | None = "/joint_commands",
    base: str = "fixed",
    meaning: str = "position",
    **recordings: Any,
) -> Scenario:
    return Scenario.model_validate(
        {
            "name": "test",
            "robot": {"urdf": "robot.urdf", "base": base},
            "motion": {"recorded": command, "as": meaning} if command else None,
            "recordings": {"state": state, **recordings},
        }
    )


@dataclass(frozen=True)
class Run:
    """A run as repetitions are looked for among them."""

    name: str
    recording: Recording
    overrides: str = "{}"
    use: str | None = None
    window: tuple[float, float] = (-np.inf, np.inf)


def two_joints(count: int = 100, period: float = 0.01, **more: Any) -> list[tuple[str, float, str, dict[str, Any]]]:
    """States a = t, b = 2t in the order b, a; commands a = 10 + t, b = 20 + t, half a period later."""
    messages = []
    for k in range(count):
        t = k * period
        state = {"stamp": EPOCH + t, "name": ["b", "a"], "position": [2 * t, t], "velocity": [2.0, 1.0], **more}
        messages.append(("/joint_states", EPOCH + t + 0.002, STATE, state))
        late = t + period / 2
        command = {"stamp": EPOCH + late, "name": ["a", "b"], "position": [10 + late, 20 + late]}
        messages.append(("/joint_commands", EPOCH + late + 0.002, STATE, command))
    return messages
