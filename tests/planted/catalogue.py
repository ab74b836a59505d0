"""Which cases there are: kind, robot, planted effects and their sizes, and how good the recordings are."""

import zlib
from dataclasses import dataclass, field, replace

import numpy as np
import planted
from recorder import Sensing
from robots import BUILDERS, ONE_JOINT, TWO_LINKS

FAMILIES = (
    ("coulomb_friction", "stribeck_friction", "load_dependent_friction"),
    ("viscous_friction",),
    ("backlash", "joint_compliance"),
    ("torque_constant", "supply_voltage", "voltage_sag", "controller_gain", "motor_heating", "torque_speed_limit"),
    ("joint_offset", "base_tilt", "constant_effort"),
    ("rotor_inertia", "link_mass", "center_of_mass", "link_inertia"),
    ("command_delay",),
    ("torque_ripple",),
    ("velocity_filter",),
)
"""Effects of one family do much the same; several at once are taken from several families."""
COUNTS = {"single": 78, "half": 44, "pair": 30, "triple": 12, "nothing": 24, "outside": 20}
COUNTS |= {"nearly_single": 48, "nearly_half": 20, "nearly_pair": 24, "nearly_triple": 12}
COUNTS |= {"nearly_nothing": 24, "nearly_outside": 12}
NEARLY = "nearly_"
"""Kinds of this prefix plant the same as without it, on machines whose laws are only nearly right."""


@dataclass(frozen=True)
class Case:
    """One case of the suite.

    Attributes:
        name: of its folder.
        kind: one of `COUNTS`.
        robot: one of `robots.BUILDERS`.
        effects: (effect, size) each; their joints are drawn.
        outside: a truth that is no effect, or empty.
        sensing: the recorder.
    """

    name: str
    kind: str
    robot: str
    effects: tuple[tuple[str, float], ...] = ()
    outside: str = ""
    sensing: Sensing = field(default_factory=Sensing)

    @property
    def family(self) -> str:
        """The kind without the laws."""
        return self.kind.removeprefix(NEARLY)

    @property
    def laws(self) -> str:
        """Whether the plant's laws are `exact` or `nearly` the list's: see `imperfections`."""
        return "nearly" if self.kind.startswith(NEARLY) else "exact"


def catalogue(kind: str, seed: int = 1) -> list[Case]:
    """The cases of one kind, in an order in which the first ones are already varied."""
    rng = np.random.default_rng([seed, zlib.crc32(kind.encode())])
    kinds = [*ONE_JOINT[:2], *TWO_LINKS, ONE_JOINT[2]]
    count, family = COUNTS[kind], kind.removeprefix(NEARLY)
    cases: list[Case] = []
    if family in ("single", "half"):
        turn = 0
        while len(cases) < count:
            for i, effect in enumerate(rng.permutation(list(planted.EFFECTS))):
                robot = kinds[(i + turn) % len(kinds)]
                while not _sits(effect, robot):
                    robot = kinds[int(rng.integers(len(kinds)))]
                size = (1.0, 1.5, 0.7)[turn % 3] * (0.5 if family == "half" else 1.0)
                sensing = Sensing(rate=100.0, effort=False) if family == "half" else Sensing()
                cases.append(_named(len(cases), kind, robot, ((str(effect), size),), sensing))
            turn += 1
    elif family in ("pair", "triple"):
        for k in range(count):
            robot = kinds[k % 4]
            while True:
                families = rng.permutation(len(FAMILIES))[: 2 if family == "pair" else 3]
                chosen = [str(rng.choice(FAMILIES[f])) for f in families]
                if all(_sits(e, robot) for e in chosen):
                    break
            cases.append(_named(k, kind, robot, tuple((e, float(rng.choice([1.0, 1.5]))) for e in chosen), Sensing()))
    elif family == "nothing":
        for k in range(count):
            noisy = (0.5, 1.0, 2.0, 4.0)[k % 4]
            sensing = Sensing(
                rate=200.0 if k % 3 else 100.0,
                position_noise=0.3 * noisy,
                velocity_noise=0.01 * noisy,
                effort_noise=0.03 * noisy,
                disturbance=0.008 * noisy,
                effort=k % 4 != 1,
                velocity="difference" if k % 8 == 5 else "measured",
            )
            cases.append(_named(k, kind, kinds[k % 5], (), sensing))
    else:
        for k in range(count):
            outside = list(planted.OUTSIDE)[k % 4]
            robot = kinds[(k + k // 4) % 4]
            cases.append(replace(_named(k, kind, robot, (), Sensing()), outside=outside))
    return cases[:count]


def _named(k: int, kind: str, robot: str, effects: tuple[tuple[str, float], ...], sensing: Sensing) -> Case:
    """A case whose name tells nothing about its truth."""
    return Case(f"{kind}_{k:03d}_{robot}", kind, robot, effects, "", sensing)


def _sits(effect: str, robot: str) -> bool:
    return planted.fits(effect, BUILDERS[robot](np.random.default_rng(0)))
