"""Recordings of a test bench as smooth motions, and the known arms that they move."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from realitygap_engines import GRAVITY
from realitygap_engines.errors import ModelError
from realitygap_engines.model.urdf import read_urdf
from scipy.signal import savgol_filter

from realitygap.bench.bag import read_signals
from realitygap.bench.estimate import Array
from realitygap.bench.servo_file import Arm, ArmRecordings
from realitygap.files.errors import InputError
from realitygap.scenario.file import resolve_path


@dataclass(frozen=True)
class Pendulum:
    """What moves about the motor's axis: `inertia` [kg·m²] and `gravity_torque` m·g·l [N·m]."""

    inertia: float
    gravity_torque: float

    def torque(self, position: Array, acceleration: Array) -> Array:
        """The torque [N·m] that the motion takes; 0 hangs down."""
        return self.inertia * acceleration + self.gravity_torque * np.sin(position)


@dataclass(frozen=True)
class BenchMotion:
    """A motion on an even clock, all Shape (t,): s, rad, rad/s, rad/s², A, and the duty where it was recorded.

    `pendulum` is what moved, None on a horizontal bench.
    """

    name: str
    time: Array
    position: Array
    velocity: Array
    acceleration: Array
    current: Array
    duty: Array | None
    pendulum: Pendulum | None

    def rows(self, keep: NDArray[np.bool_] | NDArray[np.int64] | slice) -> "BenchMotion":
        """The samples chosen by a mask, an index array or a slice."""
        names = ("time", "position", "velocity", "acceleration", "current")
        duty = None if self.duty is None else self.duty[keep]
        return replace(self, duty=duty, **{name: getattr(self, name)[keep] for name in names})

    def blocks(self, count: int) -> list["BenchMotion"]:
        """The motion cut into equal parts of time."""
        return [self.rows(part) for part in np.array_split(np.arange(len(self.time)), count)]


def read_motions(
    file: Path, spec: ArmRecordings, pendulum: Pendulum | None, windows: Sequence[float], *, duty: bool = False
) -> list[BenchMotion]:
    """A recording, smoothed by local cubics (Savitzky and Golay 1964) over each of some windows [s].

    The current is smoothed like the position, so that both sides of the equation of motion lose the same. The reported
    velocity is not used: servos delay it.
    """
    if duty and spec.duty is None:
        raise InputError(f"{file}: recordings.duty: is missing; expected the duty's topic, field and unit")
    signals = [spec.position, spec.current, *([spec.duty] if duty and spec.duty else [])]
    (stamps, angle), (current_time, amperes), *rest = read_signals(file, signals)
    step = float(np.median(np.diff(stamps)))
    time = np.arange(stamps[0], stamps[-1], step)
    if len(time) <= max(windows) / step + 5:
        raise InputError(f"{file}: lasts {time[-1] - time[0]:.2f} s, expected more than {max(windows):g} s")
    raw = np.interp(time, stamps, angle * spec.position.unit)
    current = np.interp(time, current_time, amperes * spec.current.unit)
    volts = None
    if rest and spec.duty:
        last = np.clip(np.searchsorted(rest[0][0], time, side="right") - 1, 0, None)
        volts = rest[0][1][last] * spec.duty.unit
    out = []
    for window in windows:
        width = max(round(window / step) | 1, 5)
        angle, speed, growth = (savgol_filter(raw, width, 3, deriv=k, delta=step) for k in range(3))
        amperes = savgol_filter(current, width, 3)
        out.append(BenchMotion(file.stem, time, angle, speed, growth, amperes, volts, pendulum))
    return out


def read_arms(path: Path, arms: Sequence[Arm]) -> dict[str, Pendulum]:
    """The arms by name; from a URDF the inertia about the joint's axis and m·g·l for a horizontal axis."""
    out = {}
    for i, arm in enumerate(arms):
        if arm.urdf is not None:
            file = resolve_path(path, arm.urdf, f"recordings.arms[{i}].urdf")
            try:
                model = read_urdf(file, floating=False)
            except ModelError as error:
                raise InputError(str(error)) from None
            if len(model.joints) != 1 or model.joints[0].prismatic:
                raise InputError(f"{file}: has {len(model.joints)} moving joints, expected one that turns")
            axis, link = model.joints[0].axis, model.links[1]
            lever = float(np.linalg.norm(np.cross(axis, link.com)))
            inertia = float(axis @ link.inertia @ axis) + link.mass * lever**2
            out[arm.name] = Pendulum(inertia, link.mass * GRAVITY * lever)
        elif arm.inertia is not None and arm.gravity_torque is not None:
            out[arm.name] = Pendulum(arm.inertia, arm.gravity_torque)
        else:
            raise InputError(f"{path}: recordings.arms[{i}]: expected a urdf, or inertia and gravity_torque")
    return out
