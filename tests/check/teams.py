"""What teams bring: a robot of one, two or six joints, a scenario, and recordings of it with noise and quanta.

Lengths in m, angles in rad. The two-joint robot is the bundled demo with its own recordings; the others are generated.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import realitygap_engines as engines
import yaml
from realitygap.check.observed import observe
from realitygap.robot.effects.place import place
from realitygap.robot.plant import Plant, build_plant
from realitygap.scenario.file import ScenarioFile, load_scenario
from realitygap.simulate.commands import Commands
from realitygap.simulate.rollout import rollout
from realitygap.simulate.start import start_integral, start_state
from realitygap.trace.trace import Trace
from realitygap_engines import Physics
from scipy.ndimage import uniform_filter1d

sys.path.insert(0, str(Path(__file__).parents[1] / "planted"))  # plain modules, not a package
from motions import MOTIONS
from signals import Signals, there

DEMO = Path(__file__).parents[2] / "scenarios" / "demo" / "scenario.yaml"
QUANTUM = 2 * np.pi / 4096
RATE, LENGTH = 125.0, 6.0
COURSES = ("steps", "sines", "triangle", "chirp", "sine")


@dataclass
class Table:
    """One recording: time (k,), the others (k, n); the commands may be on another clock."""

    time: np.ndarray
    command: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    effort: np.ndarray | None
    command_time: np.ndarray | None = None


@dataclass
class Team:
    """A folder that a team has: files by name, the scenario, and recordings."""

    joints: list[str]
    files: dict[str, str]
    scenario: dict[str, Any]
    tables: dict[str, Table] = field(default_factory=dict)

    def copy(self) -> "Team":
        """One that can be spoilt."""
        tables = {
            name: replace(t, **{k: v.copy() for k, v in vars(t).items() if v is not None})
            for name, t in self.tables.items()
        }
        return Team(list(self.joints), dict(self.files), yaml.safe_load(yaml.safe_dump(self.scenario)), tables)

    def write(self, folder: Path) -> Path:
        """The scenario file of the folder that it is written to."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in self.files.items():
            (folder / name).write_text(text)
        runs = self.scenario["recordings"]["runs"]
        apart = any(t.command_time is not None for t in self.tables.values())
        for run, (name, table) in zip(runs, self.tables.items(), strict=True):
            run["path"] = name if apart else f"{name}.csv"
            (_write_bag if apart else _write_csv)(table, self.joints, folder / run["path"])
        self.scenario["motion"] = {"recorded": "/joint_commands"} if apart else {"recorded": "command"}
        if self.scenario.pop("no motion", False):
            self.scenario["motion"] = None
        if apart:
            self.scenario["recordings"]["state"] = "/joint_states"
        path = folder / "scenario.yaml"
        path.write_text(yaml.safe_dump(self.scenario, sort_keys=False, allow_unicode=True))
        return path


def _write_csv(table: Table, joints: Sequence[str], path: Path) -> None:
    signals = {"command": table.command, "position": table.position, "velocity": table.velocity}
    if table.effort is not None:
        signals["effort"] = table.effort
    names = ["time", *(f"{signal}_{joint}" for signal in signals for joint in joints)]
    rows = np.column_stack([table.time, *signals.values()])
    np.savetxt(path, rows, fmt="%.9g", delimiter=",", header=",".join(names), comments="")


def _write_bag(table: Table, joints: list[str], path: Path) -> None:
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    time_type, header_type = store.types["builtin_interfaces/msg/Time"], store.types["std_msgs/msg/Header"]
    state_type = store.types["sensor_msgs/msg/JointState"]
    name, none = state_type.__msgtype__, np.zeros(0)
    effort = table.effort if table.effort is not None else np.zeros((len(table.time), 0))
    sent = table.time if table.command_time is None else table.command_time
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topics = {t: writer.add_connection(t, name, typestore=store) for t in ("/joint_states", "/joint_commands")}
        rows = [
            (t, "/joint_states", (table.position[k], table.velocity[k], effort[k])) for k, t in enumerate(table.time)
        ]
        rows += [(t, "/joint_commands", (table.command[k], none, none)) for k, t in enumerate(sent)]
        for second, topic, values in sorted(rows, key=lambda row: row[0]):
            stamp = 1_700_000_000_000_000_000 + round(second * 1e9)
            header = header_type(time_type(stamp // 10**9, stamp % 10**9), "")
            writer.write(topics[topic], stamp, store.serialize_cdr(state_type(header, joints, *values), name))


def demo() -> Team:
    """The bundled demo: two joints, six recordings."""
    file = load_scenario(DEMO)
    scenario = yaml.safe_load(DEMO.read_text())
    files = {p.name: p.read_text() for p in DEMO.parent.glob("*.urdf")}
    tables = {}
    for o in observe(file):
        t = Signals(o.recording.trace)
        tables[o.name] = Table(t.time, t.command, t.position, t.velocity, t.effort)
    del scenario["recordings"]["state"]
    return Team(list(o.joints), files, scenario, tables)


def urdf(
    joints: list[str], axes: np.ndarray, lengths: np.ndarray, masses: np.ndarray, limits: Sequence[Any], base: str = ""
) -> str:
    """A chain of rods that hang from one another, on a base without or with (floating) a body."""
    out = ['<robot name="team">', f'  <link name="base">{base}</link>']
    parent, origin = "base", 0.0
    for i, joint in enumerate(joints):
        m, length = masses[i], lengths[i]
        across, along = m * length**2 / 12, 1e-4 * m
        slide = "prismatic" if joint.startswith("slide") else "revolute"
        out += [
            f'  <joint name="{joint}" type="{slide}"><parent link="{parent}"/><child link="link_{joint}"/>',
            f'    <origin xyz="0 0 {origin:.6g}"/><axis xyz="{" ".join(f"{a:.6g}" for a in axes[i])}"/>',
            f'    <limit lower="-3.1" upper="3.1" effort="{limits[i][0]:.6g}" velocity="{limits[i][1]:.6g}"/></joint>',
            f'  <link name="link_{joint}"><inertial><origin xyz="0 0 {-length / 2:.6g}"/><mass value="{m:.6g}"/>',
            f'    <inertia ixx="{across:.6g}" iyy="{across:.6g}" izz="{along:.6g}" '
            'ixy="0" ixz="0" iyz="0"/></inertial>',
            f'    <collision><origin xyz="0 0 {-length:.6g}"/><geometry><sphere radius="0.03"/></geometry></collision>',
            "  </link>",
        ]
        parent, origin = f"link_{joint}", -length
    return "\n".join([*out, "</robot>", ""])


NAMES = ("pan", "lift", "elbow", "flex", "roll", "grip")
BODY = (
    '<inertial><mass value="2"/><inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>'
    '<collision><geometry><box size="0.2 0.1 0.1"/></geometry></collision>'
)


def generated(
    seed: int, n: int, kind: str = "dc", *, floating: bool = False, effort: bool = True, runs: int = 3
) -> Team:
    """A robot of n joints with its scenario, and nothing recorded yet. Kinds: dc, pid, cascade (one slide)."""
    rng = np.random.default_rng([seed, n, len(kind)])
    joints = [f"slide{i}" for i in range(n)] if kind == "cascade" else list(NAMES[:n] if n > 1 else NAMES[1:2])
    lengths = rng.uniform(0.1, 0.2, n)
    masses = np.sort(rng.uniform(0.15, 0.8, n))[::-1]
    axes = np.eye(3)[rng.permutation(np.arange(n) % 2) if n > 1 else [1]]
    if kind == "cascade":
        axes, masses = np.tile([1.0, 0.0, 0.0], (n, 1)), rng.uniform(5.0, 30.0, n)
    beyond = [float(9.81 * sum(masses[i:]) * sum(lengths[i:])) for i in range(n)]
    inertia = [float(masses[i:].sum() * sum(lengths[i:]) ** 2 / 3) for i in range(n)]
    servos: list[dict[str, Any]] = []
    limits = []
    for i, joint in enumerate(joints):
        stall = rng.uniform(2.5, 6.0) * beyond[i]
        supply, free = 12.0, rng.uniform(5.0, 8.0)
        kt = supply / free
        if kind == "dc":
            stiff = rng.uniform(3.0, 6.0)
            servo: dict[str, Any] = {
                "gain": stiff,
                "supply": supply,
                "torque_constant": kt,
                "resistance": kt * supply / stall,
            }
            servo |= {"armature": 0.1 * inertia[i], "friction": {"coulomb": 0.02 * stall, "viscous": 0.005 * stall}}
        elif kind == "pid":
            kp = rng.uniform(8.0, 20.0) * beyond[i]
            servo = {"kp": kp, "kd": rng.uniform(0.02, 0.05) * kp, "armature": 0.1 * inertia[i]}
            servo["friction"] = {"coulomb": 0.03 * beyond[i], "viscous": 0.02 * kp}
        else:
            kv = rng.uniform(60.0, 100.0)
            servo = {"gain": 30.0, "kv": kv * masses[i] / 30.0, "kp": rng.uniform(15.0, 25.0)}
            stall, free = masses[i] * 20.0, 3.0
        servos.append({"name": joint, "joints": joint, "kind": kind, **{k: _short(v) for k, v in servo.items()}})
        limits.append((stall, free))
    scenario = {
        "name": "team",
        "robot": {"urdf": "robot.urdf", "base": "floating" if floating else "fixed"},
        "servos": servos,
        "motion": {"recorded": "command"},
        "recordings": {"effort": "motor" if effort else "none", "runs": [{"path": str(i)} for i in range(runs)]},
    }
    text = urdf(joints, axes, lengths, masses, limits, BODY if floating else "")
    return Team(joints, {"robot.urdf": text}, scenario)


def _short(value: Any) -> Any:
    return {k: _short(v) for k, v in value.items()} if isinstance(value, dict) else float(f"{value:.4g}")


def recorded(team: Team, folder: Path, seed: int, change: Any = None, *, off: bool = False) -> Team:
    """The team with recordings of its robot: simulated in MuJoCo, sampled with noise and quanta.

    Args:
        team: without recordings.
        folder: for its files.
        seed: of motions and noise.
        change: (plant, generator) -> plant: what the robot has and its model lacks.
        off: whether the servos are switched off for a part of each motion.
    """
    rng = np.random.default_rng(seed)
    team, n = team.copy(), len(team.joints)
    for name, text in team.files.items():
        folder.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    file = ScenarioFile(folder / "scenario.yaml", *_checked(folder, team.scenario))
    plant = place(build_plant(file), [])
    plant = change(plant, rng) if change else plant
    courses = [str(c) for c in rng.permutation(COURSES)[: len(team.scenario["recordings"]["runs"])]]
    for k, course in enumerate(courses):
        trace, command = _motion(plant, course, rng, off and k == 0)
        team.tables[f"{course}_{k}"] = _sampled(trace, command, rng, n)
    return team


def _checked(folder: Path, scenario: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
    from realitygap.files.validation import validate
    from realitygap.scenario.schema import Scenario

    return validate(folder / "scenario.yaml", Scenario, scenario), scenario


def _motion(plant: Plant, course: str, rng: np.random.Generator, off: bool) -> tuple[Signals, np.ndarray]:
    n = len(plant.model.joints)
    time = np.arange(round(LENGTH * RATE)) / RATE
    reach = 0.1 if plant.model.joints[0].prismatic else 1.0 if n < 3 else 0.6
    value = np.stack([MOTIONS[course](time, rng) for _ in range(n)], axis=1) * reach
    if off:
        value[(time > 3.0) & (time < 4.5)] = np.nan
    commands = Commands(time, value)
    start = start_state(plant, value[0] + plant.drive["offset"])
    integral = start_integral(plant, Trace(time[:1], tuple(plant.model.joint_names), value[:1]), commands, 0.0)
    with engines.load("mujoco").open(plant.machine(), Physics(1e-3, ground=plant.ground)) as simulation:
        trace = rollout(simulation, plant, commands, start, LENGTH, integral=integral).trace
    mean = uniform_filter1d(there(trace.effort), round(1000 / RATE), axis=0)  # a current is measured over a period
    return Signals(replace(trace, effort=mean).at(time)), value


def _sampled(trace: Signals, command: np.ndarray, rng: np.random.Generator, n: int) -> Table:
    shape = (len(trace.time), n)
    slide = np.abs(trace.position).max() < 0.4
    quantum = 2e-5 if slide else QUANTUM
    position = np.round((trace.position + 0.3 * quantum * rng.standard_normal(shape)) / quantum) * quantum
    velocity = trace.velocity + 0.01 * trace.velocity.std(axis=0) * rng.standard_normal(shape)
    effort = trace.effort + 0.03 * trace.effort.std(axis=0) * rng.standard_normal(shape)
    stamps = trace.time + 1e-4 * rng.uniform(-1, 1, len(trace.time))
    return Table(stamps - stamps[0], command, position, velocity, effort)
