"""What is planted: every effect of DESIGN.md on a foreign plant. Those of firmware and fittings are in `firmware`.

Parameters are totals, as in DESIGN.md. `size` scales the departure from the model: 1 is plain, 0.5 is half of it.
"""

from dataclasses import dataclass, replace
from typing import Any

import firmware
import numpy as np
from draws import Plant, Rng, Values, factor, sign
from foreign import Foreign
from robots import Robot, _rounded

TABLE = (
    "coulomb_friction",
    "viscous_friction",
    "stribeck_friction",
    "load_dependent_friction",
    "backlash",
    "joint_compliance",
    "rotor_inertia",
    "torque_constant",
    "torque_speed_limit",
    "supply_voltage",
    "voltage_sag",
    "command_delay",
    "controller_gain",
    "joint_offset",
    "torque_ripple",
    "motor_heating",
    "constant_effort",
    "link_mass",
    "center_of_mass",
    "link_inertia",
    "base_tilt",
    "ground_friction",
    "soft_ground",
    "velocity_filter",
    "payload",
    "dead_band",
    "joint_stop",
    "command_profile",
    "effort_limit",
    "direction_friction",
    "friction_ripple",
    "cable_spring",
    "motor_braking",
    "current_lag",
    "gain_law",
    "servo_rate",
    "derivative_gain",
    "derivative_lag",
    "motor_saturation",
    "effort_hysteresis",
    "effort_map",
)
"""The effects in the order of DESIGN.md's table: among exact twins the first is named."""


@dataclass(frozen=True)
class Planted:
    """One planted effect: what the judge knows."""

    effect: str
    target: str
    parameters: Values


def coulomb_friction(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    total = _rounded(p.drive["coulomb"][j] + size * rng.uniform(0.08, 0.18) * r.torque[j])
    p.drive["coulomb"][j] = p.drive["static"][j] = total
    return {"torque": total}


def viscous_friction(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    total = _rounded(p.drive["viscous"][j] + size * rng.uniform(0.10, 0.22) * r.torque[j] / r.speed[j])
    p.drive["viscous"][j] = total
    return {"coefficient": total}


def stribeck_friction(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    d = p.drive
    coulomb = _rounded(d["coulomb"][j] + 0.3 * size * rng.uniform(0.08, 0.15) * r.torque[j])
    static = _rounded(coulomb + size * rng.uniform(0.15, 0.30) * r.torque[j])
    velocity = _rounded(rng.uniform(0.1, 0.3) * r.speed[j])
    d["coulomb"][j], d["static"][j], d["stribeck_velocity"][j], d["stribeck_exponent"][j] = coulomb, static, velocity, 2
    return {"static": static, "coulomb": coulomb, "velocity": velocity, "exponent": 2.0}


def load_dependent_friction(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    coefficient = _rounded(size * rng.uniform(0.15, 0.30))
    p.drive["load"][j] = coefficient
    out = {"coefficient": coefficient}
    if rng.random() < 0.3:
        extra, velocity = _rounded(size * rng.uniform(0.15, 0.3)), _rounded(rng.uniform(0.1, 0.3) * r.speed[j])
        p.drive["load_static"][j], p.drive["load_velocity"][j] = extra, velocity
        out |= {"static_coefficient": extra, "velocity": velocity, "exponent": 2.0}
    return out


def backlash(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    angle = _rounded(size * rng.uniform(0.015, 0.035) * (r.reach if r.prismatic else 1.0) * (0.3 if r.prismatic else 1))
    p.drive["backlash"][j] = angle
    return {"angle": angle}


def joint_compliance(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    twist = size * rng.uniform(0.03, 0.06) * r.reach
    stiffness = _rounded(r.torque[j] / twist)
    p.drive["stiffness"][j] = stiffness
    return {"stiffness": stiffness}


def rotor_inertia(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    factor = 1.0 + size * (rng.uniform(0.6, 1.0) if rng.random() < 0.6 else -rng.uniform(0.4, 0.6))
    factor = max(factor, 0.2)
    total = _rounded(p.drive["armature"][j] * factor)
    p.drive["armature"][j] = total
    return {"armature": total}


def _wrong(name: str) -> Plant:
    def plant(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
        total = _rounded(p.drive[name][j] * factor(rng, size))
        p.drive[name][j] = total
        return {name: total}

    return plant


def supply_voltage(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    total = _rounded(p.drive["supply"][0] * factor(rng, size))
    p.drive["supply"] = total  # all servos hang on it
    return {"supply": total}


def controller_gain(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    name = "kp" if r.servo["kind"] == "pid" else "gain"
    total = _rounded(p.drive[name][j] * factor(rng, size))
    p.drive[name][j] = total
    return {"gain": total}


def torque_speed_limit(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    weak = max(0.25, 1.0 - size * rng.uniform(0.3, 0.45))
    stall = _rounded(weak * r.peak[j])
    speed = _rounded(rng.uniform(0.9, 1.3) * r.fastest[j])
    p.drive["stall_torque"][j], p.drive["no_load_speed"][j] = stall, speed
    return {"stall_torque": stall, "no_load_speed": speed}


def voltage_sag(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    current = np.sum(r.peak) / p.drive["torque_constant"][0]
    p.sag = _rounded(size * rng.uniform(0.2, 0.35) * p.drive["supply"][0] / current)
    return {"resistance": p.sag}


def command_delay(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    time = _rounded(size * rng.uniform(0.008, 0.025))
    p.drive["delay"][j] = time
    return {"time": time}


def joint_offset(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    angle = _rounded(sign(rng) * size * rng.uniform(0.05, 0.12))
    p.drive["offset"][j] = angle
    return {"angle": angle}


def torque_ripple(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    amplitude = _rounded(size * rng.uniform(0.12, 0.22) * r.torque[j])
    turns = float(rng.integers(6, 25)) / (r.reach if r.prismatic else 1.0) * (0.5 if r.prismatic else 1.0)
    phase = _rounded(rng.uniform(-np.pi, np.pi))
    p.drive["ripple"][j], p.drive["ripple_periods"][j], p.drive["ripple_phase"][j] = amplitude, turns, phase
    return {"amplitude": amplitude, "periods": turns, "phase": phase}


def motor_heating(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    loss = _rounded(size * rng.uniform(0.04, 0.08))
    p.drive["heating"][j] = loss
    return {"loss": loss}


def constant_effort(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    effort = _rounded(sign(rng) * size * rng.uniform(0.08, 0.18) * r.torque[j])
    p.drive["constant"][j] = effort
    return {"effort": effort}


def link_mass(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    total = _rounded(p.chain.mass[j] * factor(rng, size))
    p.chain.mass[j] = total
    return {"mass": total}


def center_of_mass(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    """Along the link by some of its length, and to a side that its joint feels."""
    length = r.links[j].length
    com = p.chain.com[j].copy()
    com[2] += sign(rng) * size * rng.uniform(0.10, 0.18) * length
    com[0] += sign(rng) * size * rng.uniform(0.05, 0.10) * length
    p.chain.com[j] = _rounded(com)
    return dict(zip("xyz", map(float, p.chain.com[j]), strict=True))


def link_inertia(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    scale = _rounded(1.0 + size * rng.uniform(0.8, 1.6))
    p.chain.inertia[j] *= scale
    return {"scale": scale}


def base_tilt(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    """About the first joint's axis, and about the other horizontal one where a second joint feels it."""
    pitch = _rounded(sign(rng) * size * rng.uniform(0.05, 0.12))
    roll = 0.0
    if r.kind == "skew" and rng.random() < 0.7:
        roll = _rounded(sign(rng) * size * rng.uniform(0.08, 0.15))
        pitch = pitch if rng.random() < 0.5 else 0.0
    x = np.array([[1, 0, 0], [0, np.cos(roll), -np.sin(roll)], [0, np.sin(roll), np.cos(roll)]])
    y = np.array([[np.cos(pitch), 0, np.sin(pitch)], [0, 1, 0], [-np.sin(pitch), 0, np.cos(pitch)]])
    p.chain.gravity = (x @ y).T @ p.chain.gravity
    return {"roll": roll, "pitch": pitch}


def velocity_filter(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    time, scale = _rounded(size * rng.uniform(0.008, 0.025)), _rounded(1.0 - size * rng.uniform(0.05, 0.15))
    p.velocity_time[j], p.velocity_scale[j] = time, scale
    return {"time": time, "scale": scale}


EFFECTS: dict[str, Plant] = {
    "coulomb_friction": coulomb_friction,
    "viscous_friction": viscous_friction,
    "stribeck_friction": stribeck_friction,
    "load_dependent_friction": load_dependent_friction,
    "backlash": backlash,
    "joint_compliance": joint_compliance,
    "rotor_inertia": rotor_inertia,
    "torque_constant": _wrong("torque_constant"),
    "torque_speed_limit": torque_speed_limit,
    "supply_voltage": supply_voltage,
    "voltage_sag": voltage_sag,
    "command_delay": command_delay,
    "controller_gain": controller_gain,
    "joint_offset": joint_offset,
    "torque_ripple": torque_ripple,
    "motor_heating": motor_heating,
    "constant_effort": constant_effort,
    "link_mass": link_mass,
    "center_of_mass": center_of_mass,
    "link_inertia": link_inertia,
    "base_tilt": base_tilt,
    "velocity_filter": velocity_filter,
}
"""Laws of bodies, motors and friction."""
EVERY = {**EFFECTS, **firmware.EFFECTS, **firmware.LATER}
BODY = ("link_mass", "center_of_mass", "link_inertia", "payload")
SUPPLY = ("supply_voltage", "voltage_sag")
MOTOR = ("torque_constant", "motor_heating", "motor_braking", *SUPPLY)


UNSEEN_BEHIND_A_VELOCITY_LOOP = (
    "controller_gain",
    "load_dependent_friction",
    "joint_offset",
    "center_of_mass",
    "link_inertia",
    "joint_compliance",
    "torque_speed_limit",
    "payload",
    "effort_limit",
    "current_lag",
    "gain_law",
    "motor_saturation",
)
"""On a horizontal linear drive: it has no gravity and no duty, and its loop hides the rest."""


def fits(effect: str, robot: Robot) -> bool:
    """Whether an effect can sit on a robot and be seen there."""
    kind = robot.servo["kind"]
    if effect == "derivative_lag":
        return bool(kind == "cascade")
    if effect == "motor_braking" and len(robot.joints) > 1:
        return False  # nobody lets an arm fall onto itself
    if kind == "cascade":
        return effect not in (*MOTOR, *UNSEEN_BEHIND_A_VELOCITY_LOOP)
    return kind == "dc" or effect not in MOTOR


def target_of(effect: str, robot: Robot, j: int) -> str:
    """The target's name: a joint, a link, the base, or all servos of one supply."""
    if effect in BODY:
        return robot.links[j].name
    if effect == "base_tilt":
        return "base"
    if effect in SUPPLY and len(robot.joints) > 1:
        return "*"
    return robot.joints[j]


def plant(effect: str, plant_: Foreign, robot: Robot, j: int, size: float, rng: Rng) -> Planted:
    """Plant one effect and tell its truth."""
    values = EVERY[effect](plant_, robot, j, size, rng)
    return Planted(effect, target_of(effect, robot, j), {k: float(v) for k, v in values.items()})


def plant_everywhere(effect: str, plant_: Foreign, robot: Robot, size: float, seed: int) -> Planted:
    """Plant one effect with the same values at every joint, of the size that suits their mean."""
    n = len(robot.joints)
    names = ("torque", "speed", "peak", "fastest")
    typical: dict[str, Any] = {k: np.full(n, np.mean(getattr(robot, k))) for k in names}
    mean, values = replace(robot, **typical), {}
    for j in range(n):
        values = EVERY[effect](plant_, mean, j, size, np.random.default_rng(seed))
    return Planted(effect, "*", {k: float(v) for k, v in values.items()})


def twins(truth: Planted, robot: Robot) -> list[list[str]]:
    """Effects that do exactly the same on this robot and stand before the truth in the table: [effect, target]."""
    first, inner = robot.joints[0], robot.links[0].name
    out: list[list[str]] = []
    if robot.prismatic:
        if truth.effect == "link_mass":
            out = [["rotor_inertia", first]]
        if truth.effect == "base_tilt":
            out = [["constant_effort", first], ["joint_offset", first]]
    else:
        if truth.effect == "link_inertia" and truth.target == inner:
            out = [["rotor_inertia", first]]
        if truth.effect == "base_tilt" and not truth.parameters["roll"]:
            out = [["joint_offset", first]]
    return out
