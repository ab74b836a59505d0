"""Whole-body cases: a 20-joint humanoid standing, squatting, swaying and swinging its arms, with planted truths."""

import json
import shutil
import zlib
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import planted
import standing
import yaml
from chain import Chain
from drivetrain import drives
from foreign import Foreign, Motion
from motions import Command
from outside import OUTSIDE
from planted import Planted
from recorder import Sensing, clock, disturbance, record, reported_velocity, write_bag
from robots import Link, Robot, _rounded
from standing import TORSO, Humanoid

LEGS = ("*_knee", "*_ankle_*", "*_hip_roll", "*_hip_pitch")
COMMON = {"kind": "dc", "gain": 5.056, "duty_limit": 0.9625, "supply": 15.0}
LARGE = {"torque_constant": 2.191, "resistance": 2.965, "armature": 0.02661}
SMALL = {"torque_constant": 1.622, "resistance": 3.949, "armature": 0.01195}
LARGE_FRICTION = {"coulomb": 0.1035, "viscous": 0.0352}
SMALL_FRICTION = {"coulomb": 0.0904, "viscous": 0.0117}
STANCE = {"hip_pitch": -0.831, "knee": 1.174, "ankle_pitch": -0.545, "elbow": -0.873, "shoulder_pitch": 0.349}
STANCE_ROLL = {"hip_roll": 0.129, "ankle_roll": -0.132, "hip_yaw": 0.026}
MOTIONS = ("squat", "sway", "arms", "twist", "spread")
SINGLES = (  # effect and the joint, link or pattern at which it sits
    ("coulomb_friction", "left_knee"),
    ("command_delay", "*"),
    ("soft_ground", "ground"),
    ("link_mass", TORSO),
    ("ground_friction", "ground"),
    ("supply_voltage", "*"),
    ("joint_offset", "right_hip_pitch"),
    ("backlash", "left_shoulder_pitch"),
    ("torque_constant", "right_knee"),
    ("center_of_mass", TORSO),
    ("viscous_friction", "left_elbow"),
    ("controller_gain", "left_ankle_pitch"),
    ("constant_effort", "right_shoulder_pitch"),
    ("velocity_filter", "*"),
    ("load_dependent_friction", "right_knee"),
    ("motor_heating", "left_knee"),
    ("rotor_inertia", "right_elbow"),
    ("voltage_sag", "*"),
    ("torque_ripple", "left_hip_pitch"),
    ("soft_ground", "ground"),
)
OTHERS = (("nothing", ()), ("pair", (4, 0)), ("outside", ()), ("nothing", ()), ("pair", (2, 1)), ("outside", ()))


@dataclass(frozen=True)
class Plan:
    """One whole-body case: what sits where, and how the recorder sees it."""

    name: str
    kind: str
    effects: tuple[tuple[str, str, float], ...]
    outside: str
    sensing: Sensing


def catalogue() -> list[Plan]:
    """Whole-body cases; every fourth has something other than one effect."""
    plans: list[Plan] = []
    singles, others = list(enumerate(SINGLES)), list(OTHERS)
    while singles or others:
        k = len(plans)
        sensing = Sensing(rate=100.0, effort=k % 2 == 0, velocity_noise=0.02)
        if others and (k % 4 == 3 or not singles):
            kind, chosen = others.pop(0)
            effects = tuple((*SINGLES[i], 1.0) for i in chosen)
            outside = ("dropout", "push")[len(others) % 2] if kind == "outside" else ""
        else:
            i, (effect, target) = singles.pop(0)
            kind, effects, outside = "single", ((effect, target, (1.0, 1.4)[i % 2]),), ""
        plans.append(Plan(f"humanoid_{k:03d}", kind, effects, outside, sensing))
    return plans


def _robot() -> Robot:
    joints = standing.joint_names()
    links = [Link(name, 1.0, 0.2, np.zeros(3), np.eye(3)) for name in joints]
    n = len(joints)
    return Robot("humanoid", joints, links, np.zeros((n, 3)), False, COMMON, {}, (10.0, 6.0))


def _large(joint: str) -> bool:
    return any(part in joint for part in ("knee", "ankle", "hip_roll", "hip_pitch"))


def _humanoid(robot: Robot) -> Humanoid:
    n = len(robot.joints)
    drive = drives(n)
    for i, joint in enumerate(robot.joints):
        motor, friction = (LARGE, LARGE_FRICTION) if _large(joint) else (SMALL, SMALL_FRICTION)
        for key, value in {**COMMON, **motor, **friction}.items():
            drive[key][i] = 0 if key == "kind" else value
        drive["static"][i] = drive["coulomb"][i]
    none = np.zeros(0)
    empty = Chain(none.astype(bool), none, none, none, none, none, none)
    return Humanoid(Foreign(empty, drive), robot.joints)


def command(name: str, robot: Robot, rate: float, length: float, seed: int) -> Command:
    """Joint goals of one whole-body motion, from a slight squat and back."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(length * rate)) / rate
    value = np.zeros((len(time), len(robot.joints)))
    wave = _waves(name, time, rng)
    for i, joint in enumerate(robot.joints):
        side, _, part = joint.partition("_")
        sign = -1.0 if side == "right" else 1.0
        value[:, i] = STANCE.get(part, 0.0) + sign * STANCE_ROLL.get(part, 0.0)
        value[:, i] += wave.get(part, 0.0) + sign * wave.get("opposed_" + part, 0.0)
        value[:, i] += wave.get(joint, 0.0)
    return Command(time, np.round(value, 6), np.ones(len(time)))


def _waves(name: str, time: np.ndarray, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Departures from the stance by joint part; `opposed_` is mirrored on the right side."""
    rise = np.clip(time / 0.6, 0, 1) ** 2 * (3 - 2 * np.clip(time / 0.6, 0, 1))

    def wave(size: float, low: float, high: float) -> np.ndarray:
        return size * rise * np.sin(2 * np.pi * rng.uniform(low, high) * time)

    out: dict[str, np.ndarray] = {}
    depth = 0.22 * rise * (1 - np.cos(2 * np.pi * rng.uniform(0.5, 0.8) * time))
    if name in ("squat", "spread"):
        depth = depth if name == "squat" else 0.4 * depth
        out |= {"hip_pitch": -depth, "knee": 2 * depth, "ankle_pitch": -depth}
    if name == "sway":
        lean = wave(0.08, 0.35, 0.55)
        out |= {"hip_roll": lean, "ankle_roll": -lean}
    if name == "twist":
        out |= {"hip_yaw": wave(0.25, 0.6, 0.9), "opposed_shoulder_pitch": wave(0.5, 0.6, 0.9)}
    if name == "spread":
        out |= {"opposed_hip_yaw": wave(0.06, 0.4, 0.6), "opposed_hip_roll": wave(0.03, 0.4, 0.6)}
    swing = 1.0 if name == "arms" else 0.3
    out.setdefault("opposed_shoulder_pitch", wave(0.8 * swing, 0.5, 0.9))
    out |= {"elbow": wave(0.6 * swing, 0.6, 1.2), "opposed_shoulder_roll": np.abs(wave(0.5 * swing, 0.4, 0.8))}
    return out | {"head_pitch": wave(0.4 * swing, 0.4, 0.9), "head_yaw": wave(0.6 * swing, 0.4, 0.9)}


def plant_effect(h: Humanoid, robot: Robot, effect: str, target: str, size: float, seed: int) -> Planted:
    """Plant one effect on the humanoid."""
    rng = np.random.default_rng(seed)
    if effect == "soft_ground":
        h.ground.stiffness, h.ground.damping = (
            _rounded(rng.uniform(3000, 6000) / size),
            _rounded(rng.uniform(60, 120)),
        )
        return Planted(effect, target, {"stiffness": h.ground.stiffness, "damping": h.ground.damping})
    if effect == "ground_friction":
        h.ground.friction = _rounded(rng.uniform(0.12, 0.22) / size)
        return Planted(effect, target, {"coefficient": h.ground.friction})
    if effect == "link_mass":
        mass = standing.body(target)[0]
        h.mass[target] = _rounded(mass * (1 + size * rng.uniform(0.2, 0.3)))
        return Planted(effect, target, {"mass": h.mass[target]})
    if effect == "center_of_mass":
        shift = size * np.array([rng.uniform(0.015, 0.025), rng.uniform(0.01, 0.02), 0.0])
        h.com[target] = _rounded(standing.body(target)[1] + shift)
        return Planted(effect, target, dict(zip("xyz", map(float, h.com[target]), strict=True)))
    joints = range(len(robot.joints)) if target == "*" else [robot.joints.index(target)]
    if effect in planted.SUPPLY:
        joints = [0]
    values: dict[str, float] = {}
    for j in joints:
        values = planted.EFFECTS[effect](h.plant, robot, j, size, np.random.default_rng(seed))
    return Planted(effect, target, {k: float(v) for k, v in values.items()})


def generate(plan: Plan, out: Path, seed: int = 1) -> dict[str, Any]:
    """Write one whole-body case and its truth; returns the truth."""
    rng = np.random.default_rng([seed, zlib.crc32(plan.name.encode())])
    robot = _robot()
    n = len(robot.joints)
    robot.torque, robot.speed, robot.peak, robot.fastest = (np.ones(n) for _ in range(4))
    runs = [("squat", "train", 2), ("arms", "train", 1), ("sway", "train", 1)]
    slipping = any(e == "ground_friction" for e, _, _ in plan.effects)
    if slipping or rng.random() < 0.3:  # feet that press apart: what they slip by depends on the law of contact
        runs.append(("spread", "train", 1))
    runs += [("squat", "held_out", 1), ("spread" if slipping else str(rng.choice(["sway", "arms"])), "held_out", 1)]
    seeds = [int(x) for x in rng.integers(1, 2**31, len(runs))]
    length, sensing = 5.0, plan.sensing
    clean = []
    for (name, _, _), s in zip(runs, seeds, strict=True):
        h = _humanoid(robot)
        robot.bristles(h.plant)
        clean.append(standing.simulate(h, command(name, robot, sensing.rate, length, s), length)[0])
    effort, velocity = np.concatenate([m.effort for m in clean]), np.concatenate([m.velocity for m in clean])
    robot.torque = np.maximum(np.sqrt(np.mean(effort**2, axis=0)), 0.05)
    robot.speed = np.maximum(np.sqrt(np.mean(velocity**2, axis=0)), 0.2)
    robot.peak, robot.fastest = np.abs(effort).max(axis=0), np.abs(velocity).max(axis=0)
    inner = [int(x) for x in rng.integers(1, 2**31, len(plan.effects) + 1)]
    h = _humanoid(robot)
    told = [plant_effect(h, robot, e, t, size, s) for (e, t, size), s in zip(plan.effects, inner, strict=False)]
    other = None
    if plan.outside:
        j = robot.joints.index("left_shoulder_pitch" if plan.outside == "push" else "right_elbow")
        other = OUTSIDE[plan.outside](h.plant, robot, j, np.random.default_rng(inner[-1]))
    robot.bristles(h.plant)
    folder = out / "cases" / plan.name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    entries: list[dict[str, Any]] = []
    seen = 0.0
    for k, ((name, use, repetitions), s) in enumerate(zip(runs, seeds, strict=True)):
        for repetition in range(repetitions):
            stem = f"{name}_{k + 1}" + (f"_rep{repetition + 1}" if repetitions > 1 else "")
            sent = clock(command(name, robot, sensing.rate, length, s), sensing, rng)
            noise = disturbance(robot, sensing, length + 1.6, rng)
            motion, height = standing.simulate(standing.copy(h), sent, length, noise)
            if height.min() < 0.6 * height[0]:
                raise RuntimeError(f"{plan.name}: the humanoid falls in {stem}")
            seen = max(seen, _visibility(robot, h, motion, clean[k], sensing))
            write_bag(
                record(h.plant, robot, motion, sent, sensing, int(rng.integers(2**31))), robot.joints, folder / stem
            )
            entries.append({"path": stem, "use": use})
    (folder / "scenario.yaml").write_text(yaml.safe_dump(_scenario(plan, sensing, entries), sort_keys=False))
    truth = {
        "case": plan.name,
        "kind": plan.kind,
        "robot": "humanoid",
        "truth": [
            {**asdict(x), "size": size, "visibility": round(seen, 2), "twins": []}
            for x, (_, _, size) in zip(told, plan.effects, strict=True)
        ],
        "outside": other,
        "tolerated": [],
        "sensing": asdict(sensing),
        "joints": robot.joints,
    }
    (out / "truth").mkdir(exist_ok=True)
    (out / "truth" / f"{plan.name}.json").write_text(json.dumps(truth, indent=1, ensure_ascii=False) + "\n")
    return truth


def _visibility(robot: Robot, h: Humanoid, motion: Motion, clean: Motion, sensing: Sensing) -> float:
    sigma = np.hypot(sensing.position_noise, 0.29) * sensing.quantum
    parts = [(motion.reading - clean.reading) / sigma]
    parts.append((reported_velocity(h.plant, motion) - clean.velocity) / (sensing.velocity_noise * robot.speed))
    return max(float(np.sqrt(np.mean(np.square(x), axis=0)).max()) for x in parts)


def _scenario(plan: Plan, sensing: Sensing, entries: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "name": plan.name,
        "robot": {
            "urdf": "${REALITYGAP_DATA}/sigmaban/robot.urdf",
            "base": "floating",
            "stand_on": "left_foot",
        },
        "servos": [
            {"name": "large", "joints": list(LEGS), **COMMON, **LARGE, "friction": dict(LARGE_FRICTION)},
            {"name": "small", "joints": "*", **COMMON, **SMALL, "friction": dict(SMALL_FRICTION)},
        ],
        "motion": {"recorded": "/joint_commands"},
        "ground": "flat",
        "physics": {"step_rate": 1000},
        "recordings": {"state": "/joint_states", "effort": "motor" if sensing.effort else "none", "runs": entries},
    }
