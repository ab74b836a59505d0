"""Robots of the blind suite: what the team knows (URDF and servo data) and the plant that it describes."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import drivetrain
import foreign
import numpy as np
from chain import GRAVITY, Chain
from servo import CASCADE, DC, PID

QUANTUM = 2 * np.pi / 4096


@dataclass
class Link:
    """A rod that hangs from its joint. Lengths in m, masses in kg."""

    name: str
    mass: float
    length: float
    com: np.ndarray
    inertia: np.ndarray


@dataclass
class Robot:
    """A robot as its team describes it.

    Attributes:
        kind: one of `BUILDERS`.
        joints, links: names and bodies, from the base outwards.
        axes: joint axes in link frames. Shape (n, 3).
        prismatic: Shape (n,).
        servo: the servo entry of the scenario, without `joints` and `friction`.
        friction: `coulomb`, `viscous` of every joint.
        limits: effort and velocity of the URDF.
        torque: typical motor effort, for sizes. Set from a first simulation. Shape (n,).
        speed, peak, fastest: typical speed, largest effort and speed. Shape (n,).
        quantum: of the encoder [rad or m].
    """

    kind: str
    joints: list[str]
    links: list[Link]
    axes: np.ndarray
    prismatic: bool
    servo: dict[str, Any]
    friction: dict[str, float]
    limits: tuple[float, float]
    quantum: float = QUANTUM
    torque: np.ndarray = field(default_factory=lambda: np.zeros(0))
    speed: np.ndarray = field(default_factory=lambda: np.zeros(0))
    peak: np.ndarray = field(default_factory=lambda: np.zeros(0))
    fastest: np.ndarray = field(default_factory=lambda: np.zeros(0))

    @property
    def reach(self) -> float:
        """Half the range that motions use [rad or m]."""
        return 0.1 if self.prismatic else 1.0

    def plant(self, gain: float = 1.0, load: float = 1.0) -> foreign.Foreign:
        """The plant of a perfect model; `gain` and `load` scale the controller and the last link's mass."""
        n = len(self.joints)
        origins = np.zeros((n, 3))
        for i in range(1, n):
            origins[i] = (0.0, 0.0, -self.links[i - 1].length)
        mass = np.array([x.mass for x in self.links])
        inertia = np.array([x.inertia for x in self.links])
        mass[-1] *= load
        inertia[-1] *= load
        chain = Chain(
            np.full(n, self.prismatic),
            self.axes.copy(),
            origins,
            np.tile(np.eye(3), (n, 1, 1)),
            mass,
            np.array([x.com for x in self.links]),
            inertia,
        )
        drive = drivetrain.drives(n)
        kinds = {"dc": DC, "pid": PID, "cascade": CASCADE}
        drive["kind"] = kinds[self.servo["kind"]]
        for key, value in self.servo.items():
            if key != "kind":
                drive[key] = value
        if drive["kind"][0] != DC:
            drive["effort_limit"], drive["velocity_limit"] = self.limits
        drive["gain" if self.servo["kind"] != "pid" else "kp"] *= gain
        drive["coulomb"] = drive["static"] = self.friction["coulomb"]
        drive["viscous"] = self.friction["viscous"]
        return foreign.Foreign(chain, drive)

    def bristles(self, plant: foreign.Foreign) -> None:
        """Bristles so stiff that a stuck joint stays within a fifth of the encoder's quantum."""
        drive = plant.drive
        bound = np.maximum(drive["static"], drive["coulomb"])
        bound = bound + (drive["load"] + drive["load_static"]) * np.maximum(self.peak, 1e-9)
        drive["bristle"] = bound / (0.2 * self.quantum)
        drive["bristle_damping"] = np.sqrt(drive["bristle"] * np.maximum(drive["armature"], 1e-6))

    def urdf(self, load: float = 1.0) -> str:
        """The team's URDF."""
        out = ['<?xml version="1.0"?>', f'<robot name="{self.kind}">', '  <link name="base"/>']
        parent = "base"
        for i, (joint, link) in enumerate(zip(self.joints, self.links, strict=True)):
            k = load if i == len(self.links) - 1 else 1.0
            x = link.inertia * k
            origin = "0 0 0" if i == 0 else f"0 0 {-self.links[i - 1].length:.9g}"
            travel = 2.0 if self.prismatic else 3.2
            out += [
                f'  <joint name="{joint}" type="{"prismatic" if self.prismatic else "revolute"}">',
                f'    <parent link="{parent}"/>',
                f'    <child link="{link.name}"/>',
                f'    <origin xyz="{origin}" rpy="0 0 0"/>',
                f'    <axis xyz="{" ".join(f"{a:.9g}" for a in self.axes[i])}"/>',
                f'    <limit lower="{-travel}" upper="{travel}" effort="{self.limits[0]:.6g}" '
                f'velocity="{self.limits[1]:.6g}"/>',
                f'    <dynamics damping="{self.friction["viscous"]:.9g}" friction="{self.friction["coulomb"]:.9g}"/>',
                "  </joint>",
                f'  <link name="{link.name}">',
                "    <inertial>",
                f'      <origin xyz="{" ".join(f"{c:.9g}" for c in link.com)}" rpy="0 0 0"/>',
                f'      <mass value="{link.mass * k:.9g}"/>',
                f'      <inertia ixx="{x[0, 0]:.9g}" ixy="{x[0, 1]:.9g}" ixz="{x[0, 2]:.9g}" '
                f'iyy="{x[1, 1]:.9g}" iyz="{x[1, 2]:.9g}" izz="{x[2, 2]:.9g}"/>',
                "    </inertial>",
                "  </link>",
            ]
            parent = link.name
        return "\n".join([*out, "</robot>", ""])


def _rounded(x: Any) -> Any:
    """Four digits, as a data sheet has them: file and plant hold the same number."""
    return np.vectorize(lambda v: float(f"{v:.4g}"))(np.asarray(x, dtype=float)) if np.ndim(x) else float(f"{x:.4g}")


def _rod(name: str, mass: float, length: float, tip: float) -> Link:
    """A rod with a share `tip` of its mass at its end."""
    com = length * (0.5 * (1 - tip) + tip)
    about_joint = mass * length**2 * ((1 - tip) / 3 + tip)
    across = about_joint - mass * com**2
    along = 0.02 * across + 1e-5 * mass
    return Link(
        name,
        _rounded(mass),
        _rounded(length),
        _rounded(np.array([0.0, 0.0, -com])),
        _rounded(np.diag([across, across, along])),
    )


SERVOS = (  # torque constant, resistance, supply, armature, gain, duty limit: two metal-gear servos and a small one
    (2.19, 2.96, 15.0, 0.0266, 5.1, 0.96),
    (1.65, 3.6, 14.8, 0.0128, 5.1, 0.96),
    (1.21, 2.68, 12.0, 0.0280, 4.6, 1.0),
)


def _dc(rng: np.random.Generator) -> tuple[dict[str, Any], float]:
    kt, r, supply, armature, gain, limit = SERVOS[rng.integers(len(SERVOS))]
    spread = rng.uniform(0.85, 1.15, 4)
    servo = {
        "kind": "dc",
        "gain": _rounded(gain * spread[0]),
        "duty_limit": limit,
        "supply": supply,
        "torque_constant": _rounded(kt * spread[1]),
        "resistance": _rounded(r * spread[2]),
        "armature": _rounded(armature * spread[3]),
    }
    return servo, servo["torque_constant"] / servo["resistance"] * supply


def pendulum(rng: np.random.Generator) -> Robot:
    """One joint with a position-controlled DC servo lifting a rod."""
    servo, stall = _dc(rng)
    length = rng.uniform(0.12, 0.3)
    tip = rng.uniform(0.0, 0.7)
    mass = rng.uniform(0.12, 0.3) * stall / (GRAVITY * length * (0.5 * (1 - tip) + tip))
    return Robot(
        "pendulum",
        ["elbow"],
        [_rod("forearm", mass, length, tip)],
        np.array([[0.0, 1.0, 0.0]]),
        False,
        servo,
        {
            "coulomb": _rounded(rng.choice([0.0, 0.01, 0.02]) * stall),
            "viscous": _rounded(rng.choice([0.0, 0.01, 0.03])),
        },
        (_rounded(stall), _rounded(servo["supply"] / servo["torque_constant"])),
    )


def geared(rng: np.random.Generator) -> Robot:
    """One joint with a torque controller (PID) whose friction stands in the URDF."""
    length, tip = rng.uniform(0.2, 0.35), rng.uniform(0.0, 0.5)
    mass = rng.uniform(0.6, 1.5)
    link = _rod("arm", mass, length, tip)
    kp = _rounded(rng.uniform(25.0, 60.0))
    armature = _rounded(rng.uniform(0.01, 0.03))
    inertia = armature + link.inertia[1, 1] + link.mass * link.com[2] ** 2
    kd = _rounded(rng.uniform(0.05, 0.15))
    damping = 2 * rng.uniform(0.3, 0.45) * np.sqrt(kp * inertia)
    ki = _rounded(rng.choice([0.0, 10.0]))
    gravity = link.mass * GRAVITY * abs(link.com[2])
    return Robot(
        "geared",
        ["hinge"],
        [link],
        np.array([[0.0, 1.0, 0.0]]),
        False,
        {"kind": "pid", "kp": kp, "ki": ki, "kd": kd, "armature": armature},
        {
            "coulomb": _rounded(rng.choice([0.0, 0.03, 0.05]) * gravity),
            "viscous": _rounded(damping),
        },
        (_rounded(rng.uniform(3.0, 5.0) * gravity), _rounded(rng.uniform(7.0, 10.0))),
    )


def slide(rng: np.random.Generator) -> Robot:
    """A horizontal linear drive with a velocity loop inside a position loop."""
    mass = rng.uniform(5.0, 40.0)
    bandwidth, outer = rng.uniform(60.0, 100.0), rng.uniform(15.0, 30.0)
    carriage = Link("carriage", _rounded(mass), 0.1, np.zeros(3), _rounded(np.diag([0.01, 0.01, 0.01]) * mass))
    armature = _rounded(rng.uniform(0.05, 0.2) * mass)
    gain = _rounded(rng.uniform(20.0, 40.0))
    return Robot(
        "slide",
        ["axis"],
        [carriage],
        np.array([[1.0, 0.0, 0.0]]),
        True,
        {
            "kind": "cascade",
            "gain": gain,
            "kv": _rounded(bandwidth * (mass + armature) / gain),
            "kp": _rounded(outer),
            "armature": armature,
        },
        {"coulomb": _rounded(rng.choice([0.0, 0.3]) * mass), "viscous": _rounded(rng.choice([0.0, 1.0]) * mass)},
        (_rounded(mass * 20.0), 3.0),
        quantum=2e-5,
    )


def _two(rng: np.random.Generator, kind: str, second: np.ndarray) -> Robot:
    servo, stall = _dc(rng)
    lengths = rng.uniform(0.12, 0.22, 2)
    tips = rng.uniform(0.0, 0.6, 2)
    gravity = rng.uniform(0.1, 0.16) * stall
    outer = gravity / (GRAVITY * lengths[1])
    inner = rng.uniform(0.7, 1.3) * outer
    return Robot(
        kind,
        ["shoulder", "elbow"],
        [_rod("upper_arm", inner, lengths[0], tips[0]), _rod("forearm", outer, lengths[1], tips[1])],
        np.array([[0.0, 1.0, 0.0], second]),
        False,
        servo,
        {
            "coulomb": _rounded(rng.choice([0.0, 0.01, 0.02]) * stall),
            "viscous": _rounded(rng.choice([0.0, 0.01, 0.03])),
        },
        (_rounded(stall), _rounded(servo["supply"] / servo["torque_constant"])),
    )


def planar(rng: np.random.Generator) -> Robot:
    """Two parallel joints in a vertical plane, on one supply."""
    return _two(rng, "planar", np.array([0.0, 1.0, 0.0]))


def skew(rng: np.random.Generator) -> Robot:
    """Two joints whose axes are not parallel, on one supply."""
    angle = rng.choice([0.5 * np.pi, 0.7, 1.1])
    axis = np.array([np.sin(angle), np.cos(angle), 0.0])
    return _two(rng, "skew", np.round(axis, 9))


def arm(rng: np.random.Generator) -> Robot:
    """Six joints on one supply, hung from a ceiling: pan, shoulder, elbow, wrist pitch, wrist roll, tool.

    The axes are those of small arms with servos such as the SO-101; the data sheet knows no friction.
    """
    servo, stall = _dc(rng)
    lengths = np.array([0.06, 0.12, 0.12, 0.07, 0.05, 0.08]) * rng.uniform(0.85, 1.15)
    shares = np.array([0.3, 0.3, 0.22, 0.14, 0.12, 0.1]) * rng.uniform(0.8, 1.2, 6)
    links = ["pan", "upper_arm", "forearm", "wrist", "hand", "tool"]
    # stretched out from the shoulder, the arm needs a fifth to a third of the stall torque
    ends = np.cumsum(lengths[1:])
    lever = float(shares[1:] @ (ends - 0.5 * lengths[1:]))
    scale = rng.uniform(0.2, 0.33) * stall / (GRAVITY * lever)
    aside = _rounded(rng.uniform(0.2, 0.35) * lengths[5])  # the tool is held aside, so that the wrist's roll feels it
    bodies = [_rod(name, m * scale, length, 0.3) for name, m, length in zip(links, shares, lengths, strict=True)]
    bodies[5].com[0] = aside
    y, z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    return Robot(
        "arm",
        ["pan_joint", "shoulder_joint", "elbow_joint", "wrist_pitch", "wrist_roll", "tool_joint"],
        bodies,
        np.array([z, y, y, y, z, y]),
        False,
        servo,
        {"coulomb": 0.0, "viscous": 0.0},
        (_rounded(stall), _rounded(servo["supply"] / servo["torque_constant"])),
    )


BUILDERS: dict[str, Callable[[np.random.Generator], Robot]] = {
    "pendulum": pendulum,
    "geared": geared,
    "slide": slide,
    "planar": planar,
    "skew": skew,
    "arm": arm,
}
ONE_JOINT = ("pendulum", "geared", "slide")
TWO_LINKS = ("planar", "skew")
