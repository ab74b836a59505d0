"""The cases of the closed loop from diagnosis to motion: recordings that leave two explanations or more."""

from typing import NamedTuple


class Planted(NamedTuple):
    """A case: what is planted, and what is recorded of it. `swing` is how far the motion goes, as a share of the usual:
    small motions are what leaves much open.
    """

    robot: str
    effect: str
    motion: str
    seed: int
    swing: float = 0.25
    effort: bool = False


CASES = [  # those that a diagnosis leaves open; what it settles at once counts for nothing, and is told as skipped
    Planted("pendulum", "coulomb_friction", "sine", 21, 0.2),
    Planted("pendulum", "joint_offset", "sine", 21, 0.2),
    Planted("geared", "controller_gain", "sine", 21, 0.2),
    Planted("pendulum", "joint_offset", "triangle", 21, 0.2),
    Planted("pendulum", "link_mass", "sine", 21, 0.2),
    Planted("geared", "constant_effort", "sine", 21, 0.2),
    Planted("pendulum", "link_mass", "triangle", 21, 0.2),
    Planted("geared", "joint_offset", "triangle", 21, 0.2),
    Planted("pendulum", "load_dependent_friction", "sine", 21, 0.2),
    Planted("geared", "center_of_mass", "triangle", 21, 0.2),
    Planted("pendulum", "rotor_inertia", "sine", 21, 0.2),
    Planted("pendulum", "supply_voltage", "triangle", 21, 0.2),
    Planted("geared", "rotor_inertia", "sine", 22),
    Planted("pendulum", "joint_offset", "sine", 22),
    Planted("geared", "load_dependent_friction", "sine", 22),
    Planted("pendulum", "joint_offset", "triangle", 22),
    Planted("pendulum", "rotor_inertia", "sine", 22),
    Planted("geared", "constant_effort", "sine", 22),
    Planted("pendulum", "supply_voltage", "sine", 22),
    Planted("geared", "joint_offset", "sine", 22),
    Planted("pendulum", "controller_gain", "sine", 22),
    Planted("geared", "joint_offset", "triangle", 22),
    Planted("geared", "controller_gain", "triangle", 22),
    Planted("pendulum", "joint_offset", "triangle", 1, 1.0),
    Planted("pendulum", "backlash", "triangle", 3, 1.0),
    Planted("geared", "coulomb_friction", "triangle", 4, 1.0),
    Planted("planar", "joint_offset", "sine", 41),
    Planted("planar", "controller_gain", "sine", 42),
    Planted("skew", "controller_gain", "sine", 42),
    Planted("planar", "supply_voltage", "triangle", 42),
    Planted("skew", "joint_offset", "triangle", 42),
    Planted("planar", "rotor_inertia", "sine", 43),
    Planted("skew", "link_mass", "sine", 43),
    Planted("arm", "controller_gain", "sine", 51),
    Planted("arm", "supply_voltage", "sine", 52),
    Planted("arm", "controller_gain", "triangle", 53),
]
