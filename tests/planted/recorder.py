"""What a recorder writes of a motion: encoder quantum, noise, irregular clock, and the files that teams keep."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from foreign import Foreign, Motion
from motions import Command
from robots import Robot


@dataclass(frozen=True)
class Sensing:
    """How good the recording is.

    Attributes:
        rate: samples per second.
        quantum: of the encoder [rad or m].
        position_noise: standard deviation before quantising, in quanta.
        velocity_noise: share of the typical speed.
        effort_noise: share of the typical effort.
        velocity: "measured" (a tachometer), or "difference" of two readings.
        effort: whether the motor's effort is recorded.
        disturbance: standard deviation of the disturbing torque, as a share of the typical effort.
        jitter: of the sampling instants, as a share of the period; their stamps are off by a hundredth of that.
        clock: relative error of the clock that stamps commands and readings.
    """

    rate: float = 200.0
    quantum: float = 2 * np.pi / 4096
    position_noise: float = 0.3
    velocity_noise: float = 0.01
    effort_noise: float = 0.03
    velocity: str = "measured"
    effort: bool = True
    disturbance: float = 0.008
    jitter: float = 0.03
    clock: float = 0.0


@dataclass
class Recording:
    """One recording: arrays of shape (t, n) but `time` and `enabled` (t,)."""

    time: np.ndarray
    command: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    effort: np.ndarray | None
    enabled: np.ndarray


def clock(command: Command, sensing: Sensing, rng: np.random.Generator) -> Command:
    """The instants at which commands are really sent and readings taken."""
    period = 1.0 / sensing.rate
    time = command.time + np.clip(sensing.jitter * rng.standard_normal(len(command.time)), -0.3, 0.3) * period
    time[0] = 0.0
    return Command(time, command.value, command.enabled)


def disturbance(robot: Robot, sensing: Sensing, duration: float, rng: np.random.Generator) -> np.ndarray:
    """Coloured noise (first order, 0.15 s) on every joint, on a grid of 1 ms. Shape (k, n)."""
    count = round(duration / 1e-3) + 2
    decay = np.exp(-1e-3 / 0.15)
    white = rng.standard_normal((count, len(robot.joints)))
    out = np.zeros_like(white)
    for k in range(1, count):
        out[k] = decay * out[k - 1] + np.sqrt(1 - decay**2) * white[k]
    return np.asarray(out * sensing.disturbance * robot.torque)


def reported_velocity(plant: Foreign, motion: Motion) -> np.ndarray:
    """The velocity after the sensor's own low-pass and scale, on the dense clock."""
    out = motion.velocity.copy()
    h = motion.time[1] - motion.time[0]
    for j in range(plant.n()):
        if plant.velocity_time[j] > 0:
            decay, y = np.exp(-h / plant.velocity_time[j]), out[0, j]
            for k in range(len(out)):
                y = decay * y + (1 - decay) * motion.velocity[k, j]
                out[k, j] = y
        out[:, j] *= plant.velocity_scale[j]
    return out


def reported_effort(plant: Foreign, motion: Motion) -> np.ndarray:
    """The motor's effort less its sensor's hysteresis, which grows from rest by another law than the list's."""
    drive, speed = plant.drive, motion.velocity
    return np.asarray(motion.effort - drive["hysteresis"] * speed / np.hypot(speed, drive["hysteresis_speed"]))


def record(plant: Foreign, robot: Robot, motion: Motion, sent: Command, sensing: Sensing, seed: int) -> Recording:
    """Sample a motion as each command is sent; the effort is the one that this command makes."""
    rng = np.random.default_rng(seed)
    at = sent.time

    def sampled(values: np.ndarray) -> np.ndarray:
        return np.stack([np.interp(at, motion.time, v) for v in values.T], axis=1)

    shape = (len(at), len(robot.joints))
    position = sampled(motion.reading) + sensing.position_noise * sensing.quantum * rng.standard_normal(shape)
    position = np.round(position / sensing.quantum) * sensing.quantum
    if sensing.velocity == "difference":
        velocity = np.zeros(shape)
        velocity[1:] = np.diff(position, axis=0) / np.diff(sent.time)[:, None] / (1.0 + sensing.clock)
    else:
        noise = sensing.velocity_noise * robot.speed
        velocity = sampled(reported_velocity(plant, motion)) + noise * rng.standard_normal(shape)
        velocity = np.round(velocity / noise) * noise
    effort = None
    if sensing.effort:
        first = np.minimum(np.searchsorted(motion.time, at + 1e-9), len(motion.time) - 1)
        effort = reported_effort(plant, motion)[first] + sensing.effort_noise * robot.torque * rng.standard_normal(
            shape
        )
    stamp = sent.time + 0.01 * sensing.jitter / sensing.rate * rng.standard_normal(len(at))
    stamp = (stamp - stamp[0]) * (1.0 + sensing.clock)
    return Recording(np.maximum.accumulate(stamp), sent.value, position, velocity, effort, sent.enabled)


def write_csv(recording: Recording, path: Path) -> None:
    """A table of one joint."""
    names = ["time", "command", "position", "velocity", "torque_enabled"]
    digits = ["%.6f", "%.6f", "%.8g", "%.6g", "%.0f"]
    columns = [recording.time, *(x[:, 0] for x in (recording.command, recording.position, recording.velocity))]
    columns.append(recording.enabled)
    if recording.effort is not None:
        names.append("effort")
        digits.append("%.6g")
        columns.append(recording.effort[:, 0])
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        for row in zip(*columns, strict=True):
            writer.writerow([d % x for d, x in zip(digits, row, strict=True)])


def write_bag(recording: Recording, joints: list[str], path: Path) -> None:
    """A rosbag 2 (MCAP) with /joint_states and /joint_commands; no command is sent while the servos are off."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    time_type, header_type = store.types["builtin_interfaces/msg/Time"], store.types["std_msgs/msg/Header"]
    state_type = store.types["sensor_msgs/msg/JointState"]
    name = state_type.__msgtype__
    empty = np.zeros(0)
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        states = writer.add_connection("/joint_states", name, typestore=store)
        commands = writer.add_connection("/joint_commands", name, typestore=store)
        for k, second in enumerate(recording.time):
            stamp = 1_700_000_000_000_000_000 + round(second * 1e9)
            header = header_type(time_type(stamp // 10**9, stamp % 10**9), "")
            effort = empty if recording.effort is None else recording.effort[k]
            state = state_type(header, joints, recording.position[k], recording.velocity[k], effort)
            writer.write(states, stamp, store.serialize_cdr(state, name))
            if recording.enabled[k]:
                goal = state_type(header, joints, recording.command[k], empty, empty)
                writer.write(commands, stamp, store.serialize_cdr(goal, name))
