"""Which cases there are: kind, robot, planted effects and their sizes, and how good the recordings are."""

import zlib
from dataclasses import dataclass, field, replace

import firmware
import numpy as np
import planted
from outside import OUTSIDE
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
SEVERAL = (
    ("coulomb_friction", "stribeck_friction", "load_dependent_friction", "direction_friction"),
    ("viscous_friction",),
    ("torque_constant", "controller_gain"),
    ("joint_offset", "cable_spring"),
    ("backlash", "joint_compliance"),
    ("rotor_inertia",),
    ("command_delay",),
)
"""What a robot lacks at every joint at once: one of each family at most."""
SHARED = {"command_delay": 0.8, "torque_constant": 0.6, "controller_gain": 0.6, "joint_offset": 0.0}
"""How often one value holds for all joints, where the same servo sits in each; of other effects, `SHARED_ELSE`."""
SHARED_ELSE = 0.4
ORDINARY = {"single": 78, "half": 44, "pair": 30, "triple": 12, "nothing": 24, "outside": 20, "several": 15}
NEARLY = "nearly_"
"""Kinds of this prefix plant the same as without it, on machines whose laws are only nearly right."""
FIRMWARE = {"single": 24, "half": 12, "nearly_single": 12, "nearly_half": 12}
"""So many of a kind, behind the others, have effects of firmware and fittings."""
LATER = {"single": 6, "half": 4, "nearly_single": 6, "nearly_half": 4}
"""So many of a kind, behind those, have `firmware.LATER`."""
HEARD = ("effort_hysteresis",)
"""Effects that only a recorded effort shows."""
COUNTS = ORDINARY | {"nearly_single": 48, "nearly_half": 20, "nearly_pair": 24, "nearly_triple": 12}
COUNTS |= {"nearly_nothing": 24, "nearly_outside": 12, "nearly_several": 15}
COUNTS |= {kind: COUNTS[kind] + more + LATER[kind] for kind, more in FIRMWARE.items()}


@dataclass(frozen=True)
class Case:
    """One case of the suite.

    Attributes:
        name: of its folder.
        kind: one of `COUNTS`.
        robot: one of `robots.BUILDERS`.
        effects: (effect, size) each; their joints are drawn, or are all of them (`several`).
        shared: effects that have one value for all joints.
        outside: a truth that is no effect, or empty.
        sensing: the recorder.
    """

    name: str
    kind: str
    robot: str
    effects: tuple[tuple[str, float], ...] = ()
    shared: frozenset[str] = frozenset()
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
        first, last = count - LATER[kind] - FIRMWARE[kind], count - LATER[kind]
        cases = _singles(kind, list(planted.EFFECTS), 0, first, rng)
        cases += _singles(kind, list(firmware.EFFECTS), first, last, rng)
        cases += _singles(kind, list(firmware.LATER), last, count, rng)
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
    elif family == "outside":
        for k in range(count):
            robot = kinds[(k + k // 4) % 4]
            cases.append(replace(_named(k, kind, robot, (), Sensing()), outside=list(OUTSIDE)[k % 4]))
    else:
        for k in range(count):
            cases.append(_several(k, kind, ("planar", "arm", "pendulum", "skew", "arm")[k % 5], rng))
    return cases


def _singles(kind: str, effects: list[str], first: int, last: int, rng: np.random.Generator) -> list[Case]:
    """Cases with one effect each, numbered from `first` to before `last`."""
    cases: list[Case] = []
    turn, half = 0, kind.endswith("half")
    effects = [e for e in effects if not half or e not in HEARD]
    kinds = [*ONE_JOINT[:2], *TWO_LINKS, ONE_JOINT[2]]
    while len(cases) < last - first:
        for i, effect in enumerate(rng.permutation(effects)):
            robot = kinds[(i + turn) % len(kinds)]
            while not _sits(effect, robot):
                robot = kinds[int(rng.integers(len(kinds)))]
            size = (1.0, 1.5, 0.7)[turn % 3] * (0.5 if half else 1.0)
            sensing = Sensing(rate=100.0, effort=False) if half else Sensing()
            cases.append(_named(first + len(cases), kind, robot, ((str(effect), size),), sensing))
        turn += 1
    return cases[: last - first]


def _several(k: int, kind: str, robot: str, rng: np.random.Generator) -> Case:
    """Three to five effects at every joint."""
    families = sorted(rng.permutation(len(SEVERAL))[: int(rng.integers(3, 6))])
    chosen = [str(rng.choice(SEVERAL[f])) for f in families]
    shared = frozenset(e for e in chosen if rng.random() < SHARED.get(e, SHARED_ELSE))
    return replace(_named(k, kind, robot, tuple((e, 1.0) for e in chosen), Sensing()), shared=shared)


def _named(k: int, kind: str, robot: str, effects: tuple[tuple[str, float], ...], sensing: Sensing) -> Case:
    """A case whose name tells nothing about its truth."""
    return Case(f"{kind}_{k:03d}_{robot}", kind, robot, effects, sensing=sensing)


def _sits(effect: str, robot: str) -> bool:
    return planted.fits(effect, BUILDERS[robot](np.random.default_rng(0)))
