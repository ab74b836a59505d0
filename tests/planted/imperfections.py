"""What keeps every law of a real machine only nearly right: small, true of the machine, and not what is missing.

Sizes are those of ordinary machines in order, and none of these is what a team would call the cause of a gap: friction
uneven by 4 to 10 % with direction and angle, a torque constant that droops by 2 to 5 %, a cable that pulls with 0.5 to
1.5 % of the load, gravity as standardised (the model has 9.81), a recorder's clock that is 0.1 % off, and springs and
supplies that follow another law than the list's.
"""

from typing import Any

import numpy as np
from chain import GRAVITY
from foreign import Foreign
from robots import Robot, _rounded
from servo import ONE_WAY

STANDARD_GRAVITY = 9.80665
CLOCK = 1e-3
"""Relative error of the recorder's clock: ten times a good quartz's, as of a microcontroller's own oscillator."""


def clock_error(seed: int) -> float:
    """The recorder's clock, fast or slow."""
    return CLOCK * (1.0 if np.random.default_rng([seed, 1]).random() < 0.5 else -1.0)


def imperfect(plant: Foreign, robot: Robot, seed: int) -> list[dict[str, Any]]:
    """Make the laws of a plant nearly right, alike for one seed; returns what is true of each joint.

    The friction, springs and supply that are uneven are those which the plant has, planted ones among them.
    """
    rng = np.random.default_rng([seed, 0])
    plant.chain.gravity = plant.chain.gravity * (STANDARD_GRAVITY / GRAVITY)
    plant.sag_law = ONE_WAY
    plant.drive["rate_phase"] = np.random.default_rng([seed, 2]).random(plant.n())  # nobody starts servos in step
    return [
        {"joint": joint, **_uneven_friction(plant, robot, j, rng), **_droop(plant, robot, j, rng)}
        | {**_cable(plant, robot, j, rng), **_stiffening(plant, robot, j, rng)}
        for j, joint in enumerate(robot.joints)
    ]


def besides(told: list[dict[str, Any]]) -> list[list[str]]:
    """Effects of the list that are, more or less, what keeps the laws nearly right: [effect, target].

    Named, they are true of the machine; but nobody asked, and they are counted as wrong.
    """
    out = []
    for at in told:
        names = ["direction_friction", "friction_ripple", "cable_spring", "torque_constant", "motor_heating"]
        out += [[name, at["joint"]] for name in names]
    return out


def _sign(rng: np.random.Generator) -> float:
    return 1.0 if rng.random() < 0.5 else -1.0


def _uneven_friction(p: Foreign, r: Robot, j: int, rng: np.random.Generator) -> dict[str, float]:
    """Dry friction differs with direction and angle, viscous friction thins with speed: together 4 to 10 %."""
    share = rng.uniform(0.04, 0.10)
    direction = rng.uniform(0.3, 0.7)
    told = {
        "uneven_direction": _rounded(_sign(rng) * direction * share),
        "uneven_angle": _rounded((1.0 - direction) * share),
        "uneven_periods": _rounded(rng.uniform(1.0, 6.0) / r.reach),
        "uneven_phase": _rounded(rng.uniform(-np.pi, np.pi)),
        "thinning": _rounded(rng.uniform(0.04, 0.10) / r.fastest[j]),
    }
    return _set(p, j, told)


def _droop(p: Foreign, r: Robot, j: int, rng: np.random.Generator) -> dict[str, float]:
    """The motor gives less at its largest current (saturation), or after some seconds (windings and magnets)."""
    share = _rounded(rng.uniform(0.02, 0.05))
    if rng.random() < 0.5:
        return _set(p, j, {"saturation": share, "saturation_torque": _rounded(r.peak[j])})
    return _set(p, j, {"fading": share, "fading_time": _rounded(rng.uniform(1.0, 3.0))})


def _cable(p: Foreign, r: Robot, j: int, rng: np.random.Generator) -> dict[str, float]:
    """A cable bends to one side or the other of where it is slack; it pulls no harder than its stiffness allows."""
    return _set(
        p,
        j,
        {
            "cable": _rounded(rng.uniform(0.005, 0.015) * r.torque[j]),
            "cable_rest": _rounded(rng.uniform(-0.5, 0.5) * r.reach),
            "cable_width": _rounded(rng.uniform(0.4, 0.8) * r.reach),
        },
    )


def _stiffening(p: Foreign, r: Robot, j: int, rng: np.random.Generator) -> dict[str, float]:
    """A compliant joint is 5 to 15 % stiffer where the typical effort twists it than around zero."""
    share = rng.uniform(0.05, 0.15)
    if p.drive["stiffness"][j] <= 0.0:
        return {}
    return _set(p, j, {"stiffening": _rounded(share * (p.drive["stiffness"][j] / r.torque[j]) ** 2)})


def _set(p: Foreign, j: int, values: dict[str, float]) -> dict[str, float]:
    for name, value in values.items():
        p.drive[name][j] = value
    return values
