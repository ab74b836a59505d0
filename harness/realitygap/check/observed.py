"""One recording as the checks see it: the plant that the scenario states, and all signals on one even clock."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from realitygap_engines import GRAVITY
from realitygap_engines.law.dynamics import Dynamics
from realitygap_engines.model.robot import quaternion_from_rotation, rotation_from_rpy
from scipy.ndimage import uniform_filter1d

from realitygap.files.errors import standing
from realitygap.recording import Recording, read_recording
from realitygap.recording.commands import held_at
from realitygap.recording.quantum import quantum
from realitygap.recording.readers.units import unit_of
from realitygap.recording.sections import fitting_cases
from realitygap.robot.drive import CASCADE, DC, PID
from realitygap.robot.effects.place import place
from realitygap.robot.plant import Plant, build_plant
from realitygap.scenario.file import RunCase, ScenarioFile
from realitygap.scenario.schema import Run, Scenario
from realitygap.trace.trace import Array

Read = Callable[..., Recording]
Mask = NDArray[np.bool_]
SAMPLES, STEP = 20_000, 0.01
"""Samples of the even clock at most, and its least spacing [s]: a mistake shows in the whole motion and within the
bandwidth of a servo, some Hz, and the checks are to take a moment."""
SMOOTHED = 0.15
"""s: over which positions are smoothed for accelerations."""
POSES = 10
"""Of which the inertia is taken that a joint carries."""
FOLLOWERS = (DC, PID, CASCADE)
"""Servos that bring the position to the command."""


@dataclass(frozen=True)
class Observed:
    """One recording with what the scenario says of it.

    Attributes:
        name: of the recording.
        key: where it stands in the scenario, as `recordings.runs[0]`.
        scenario: with the overrides of this run.
        plant: as the scenario states it, with its effects.
        recording: as it was read, in the scenario's units.
        run: what the scenario says of this recording alone.
    """

    name: str
    key: str
    scenario: Scenario
    plant: Plant
    recording: Recording
    run: Run

    @property
    def joints(self) -> tuple[str, ...]:
        """Names in the order of all columns."""
        return self.recording.trace.joints

    @property
    def holder(self) -> str:
        """What holds the recording: `bag`, `table` or `data set`."""
        if self.recording.episode is not None:
            return "data set"
        return "table" if self.recording.receive_time is None else "bag"

    def line(self, signal: str) -> str:
        """The line of the scenario that says where a signal is."""
        if signal == "command":
            return "motion.recorded"
        return "recordings.state" if self.holder == "bag" else f"recordings.columns.{signal}"

    def stated_unit(self, signal: str, joint: int) -> str:
        """The unit of `recordings.columns.units` that a position, velocity or command is read in; "" of a data set's,
        which are stated elsewhere.
        """
        if self.scenario.recordings is None or self.holder == "data set":
            return ""
        stated = getattr(self.scenario.recordings.columns.units, signal)
        return unit_of(stated, self.joints[joint]) or ""

    @cached_property
    def period(self) -> float:
        """The usual time between two measurements [s]."""
        return float(np.median(np.diff(self.recording.trace.time)))

    @cached_property
    def step(self) -> float:
        """Spacing of the even clock [s]."""
        time = self.recording.trace.time
        length = float(time[-1] - time[0])
        return max(self.period, length / SAMPLES, min(STEP, length / 200))

    @cached_property
    def clock(self) -> Array:
        """Even times over the measurement [s]. Shape (k,)."""
        time = self.recording.trace.time
        even = time[0] + self.step * np.arange(int((time[-1] - time[0]) / self.step) + 1)
        return np.asarray(np.minimum(even, time[-1]))  # rounding passes the last reading, where nothing is known

    @cached_property
    def position(self) -> Array:
        """What was measured [rad or m]. Shape (k, n)."""
        return self._even(self.recording.trace.position)

    @cached_property
    def velocity(self) -> Array | None:
        """The reported velocity [rad/s or m/s]; None where there is none. Shape (k, n)."""
        value = self.recording.trace.velocity
        return None if value is None else self._even(value)

    @cached_property
    def effort(self) -> Array | None:
        """The measured effort [N·m or N], NaN where unknown; None where there is none. Shape (k, n)."""
        value = self.recording.trace.effort
        return None if value is None else self._even(value)

    @cached_property
    def command(self) -> Array:
        """The command in force, NaN where there is none. Shape (k, n)."""
        r = self.recording
        if not len(r.command_time):
            return np.full((len(self.clock), len(self.joints)), np.nan)
        if self._width == 1:
            return held_at(r.command_time, r.command, self.clock)
        out = self._even(held_at(r.command_time, r.command, r.trace.time))
        out[np.isnan(held_at(r.command_time, r.command, self.clock))] = np.nan
        return out

    @cached_property
    def quantum(self) -> Array:
        """The resolution of the measured position [rad or m]. Shape (n,)."""
        value = self.recording.trace.position
        return np.zeros(len(self.joints)) if value is None else quantum(value)

    @cached_property
    def follows(self) -> Mask:
        """Which joints have a servo that is told positions and brings the joint there. Shape (n,)."""
        told = self.recording.command_kind == "position"
        return np.isin(self.plant.drive["kind"], FOLLOWERS) & told

    @property
    def is_followed(self) -> bool:
        """Whether the joints follow the measured motion, so that nothing is commanded."""
        return self.scenario.follows

    @property
    def needed_effort(self) -> Array:
        """The joint efforts that the measured motion takes without friction [N·m or N], of a fixed base. Shape (k, n).

        Inverse dynamics of rigid bodies along the position as a cubic over `SMOOTHED` seconds (Savitzky, Golay 1964).
        """
        return np.asarray(self.needed_by_links + self.plant.drive["armature"] * self.acceleration)

    @cached_property
    def needed_by_links(self) -> Array:
        """The same without what rotors take. Shape (k, n)."""
        gravity = np.array([0.0, 0.0, -GRAVITY])
        return np.asarray(Dynamics(self.plant.model).inverse(*self._smoothed, self._base, gravity))

    @cached_property
    def carried(self) -> Array:
        """The inertia of all that each joint of a fixed base carries [kg·m² or kg], without rotors, in the mean of some
        poses. Shape (n,).
        """
        dynamics, poses = Dynamics(self.plant.model), self.position[:: max(len(self.clock) // POSES, 1)]
        found = []
        for q in poses:
            dynamics.update(q, np.zeros(len(q)), self._base, np.zeros(3))
            found.append(np.diag(dynamics.inertia).copy())
        return np.asarray(np.mean(found, axis=0))

    @property
    def _base(self) -> Array:
        """Where a fixed base is."""
        base = np.zeros(13)
        roll, pitch = self.plant.base_tilt
        base[3:7] = quaternion_from_rotation(rotation_from_rpy(roll, 0, 0) @ rotation_from_rpy(0, pitch, 0))
        return base

    @property
    def acceleration(self) -> Array:
        """Of the smoothed position [rad/s² or m/s²]. Shape (k, n)."""
        return self._smoothed[2]

    @cached_property
    def _smoothed(self) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration, smoothed. Shapes (k, n)."""
        from scipy.signal import savgol_filter  # loads all of statistics, which takes long, and few need it

        width = min(max(5, 2 * round(0.5 * SMOOTHED / self.step) + 1), len(self.clock) // 2 * 2 - 1)
        q, w, a = (savgol_filter(self.position, width, 3, deriv=k, delta=self.step, axis=0) for k in range(3))
        return q, w, a

    def prismatic(self, joint: int) -> bool:
        """Whether a joint slides."""
        return self.plant.model.joints[joint].prismatic

    @property
    def _width(self) -> int:
        """Over how many measurements all signals are averaged alike, so that what holds between them still does."""
        return max(1, round(self.step / self.period))

    def _even(self, value: Array | None) -> Array:
        """A signal on the even clock, averaged over its step where that is coarser than the measurement."""
        time, n = self.recording.trace.time, len(self.joints)
        if value is None:
            return np.full((len(self.clock), n), np.nan)
        width = self._width
        out = np.empty((len(self.clock), n))
        for j in range(n):
            known = np.isfinite(value[:, j])  # a running mean never gets rid of what is no number
            if known.sum() < 2:
                out[:, j] = np.nan
                continue
            own = value[known, j]
            smooth = uniform_filter1d(own, width) if width > 1 else own
            out[:, j] = np.interp(self.clock, time[known], smooth, left=np.nan, right=np.nan)
        return out


def observe(file: ScenarioFile, read: Read = read_recording) -> list[Observed]:
    """Every recording of a scenario whose robot has joints.

    Raises:
        InputError: for what cannot be read.
    """
    plants: dict[str, Plant] = {}
    out = []
    for case in fitting_cases(file):
        plant = _plant(file, case, plants)
        if (model := plant.model).joints:
            told = {"mimics": model.mimics, "limits": model.limits}
            with standing(f"{file.path}: {case.key}.path: ", file=file.path):
                recording = read(case.path, case.scenario, model.joint_names, file=file.path, **told)
            out.append(Observed(case.name, case.key, case.scenario, plant, recording, case.run))
    return out


def _plant(file: ScenarioFile, case: RunCase, known: dict[str, Plant]) -> Plant:
    """The plant of a run; runs with the same overrides share it."""
    key = repr(sorted(case.run.overrides.items()))
    if key not in known:
        with standing(f"{file.path}: ", file=file.path):
            known[key] = place(build_plant(file, case.scenario), case.scenario.effects)
    return known[key]
