"""How far a proposed motion may go: what robot file, recordings and owner say, with a margin."""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np
from realitygap_engines.model.robot import Model

from realitygap.files.errors import InputError
from realitygap.robot.drive import Array
from realitygap.scenario.propose import JointLimits, ProposeSpec
from realitygap.trace.trace import Trace

MARGIN = 0.05
"""The share of a range that is kept from its ends, and of the largest speed and effort that is not used."""
BEYOND = 0.1
"""How much farther than in the recordings a joint may go at either end, as a share of the recorded range ..."""
FASTER = 1.25
"""... and how much faster: what a robot has done it can do, and its file is often generous."""


@dataclass(frozen=True)
class Limits:
    """What must not be left, by joint. Shapes (n,); infinite where nothing is known.

    Attributes:
        lower, upper: position [rad or m].
        speed: [rad/s or m/s].
        effort: of the motor [N·m or N].
    """

    lower: Array
    upper: Array
    speed: Array
    effort: Array

    def over(self, trace: Trace) -> dict[str, Array]:
        """How far every sample is beyond the limit of each quantity; below 0 within it. Shape (t, n) each."""
        assert trace.position is not None
        assert trace.velocity is not None
        out = {
            "position": np.maximum(self.lower - trace.position, trace.position - self.upper),
            "speed": np.abs(trace.velocity) - self.speed,
        }
        return out if trace.effort is None else out | {"effort": np.abs(trace.effort) - self.effort}

    def left(self, trace: Trace) -> Array:
        """When a motion is beyond any limit [s]. Shape (k,)."""
        beyond = np.any([np.any(v > 0.0, axis=1) for v in self.over(trace).values()], axis=0)
        return np.asarray(trace.time[beyond])

    def first(self, trace: Trace) -> float | None:
        """When a motion leaves a limit first [s]; None where it leaves none."""
        left = self.left(trace)
        return float(left[0]) if len(left) else None


def limits_of(model: Model, spec: ProposeSpec, position: Array | None, reached: Array | None) -> Limits:
    """The limits of a robot.

    Args:
        model: whose joints have limits.
        spec: what the owner says.
        position: all recorded positions (k, n) [rad or m]; None where none were recorded.
        reached: how fast each joint went in the recordings [rad/s or m/s]. Shape (n,).

    Raises:
        InputError: where nothing says how far or how fast a joint may go.
    """
    rows = [_limits(i, model, spec, position, reached) for i in range(len(model.joints))]
    return Limits(*(np.array(column) for column in zip(*rows, strict=True)))


def as_recorded(model: Model, spec: ProposeSpec) -> list[str]:
    """The joints that nobody has told how far and how fast they may go, so that recordings narrow what files allow."""
    told = {n: _told(spec, n) for n in model.joint_names}
    return [n for n, own in told.items() if own is None or own.position is None or own.speed is None]


def _told(spec: ProposeSpec, joint: str) -> JointLimits | None:
    """What the owner says of a joint."""
    return next((limits for pattern, limits in spec.limits.items() if fnmatchcase(joint, pattern)), None)


def _limits(
    i: int, model: Model, spec: ProposeSpec, position: Array | None, reached: Array | None
) -> tuple[float, float, float, float]:
    joint = model.joints[i]
    own = _told(spec, joint.name)
    margin = MARGIN * (joint.upper - joint.lower) if np.isfinite(joint.upper - joint.lower) else 0.0
    lower, upper = joint.lower + margin, joint.upper - margin
    speed, effort = (1.0 - MARGIN) * joint.velocity, (1.0 - MARGIN) * joint.effort
    if own is not None and own.position is not None:
        lower, upper = max(lower, own.position[0]), min(upper, own.position[1])
    elif position is not None:
        least, most = float(np.nanmin(position[:, i])), float(np.nanmax(position[:, i]))
        lower, upper = max(lower, least - BEYOND * (most - least)), min(upper, most + BEYOND * (most - least))
    if own is not None and own.speed is not None:
        speed = min(speed, own.speed)
    elif reached is not None and reached[i] > 0.0:
        speed = min(speed, FASTER * float(reached[i]))
    if own is not None and own.effort is not None:
        effort = min(effort, own.effort)
    if not np.isfinite([lower, upper, speed]).all():
        raise InputError(
            f"propose.limits: nothing says how far and how fast {joint.name} may go; expected "
            f"{joint.name}: {{position: [LOW, HIGH], speed: MOST}}"
        )
    return lower, max(upper, lower), speed, effort
