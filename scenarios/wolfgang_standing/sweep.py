"""Can the Wolfgang of 2019 stand with the gains of its real servos? `python scenarios/wolfgang_standing/sweep.py`

Position and derivative gain from those of gazebo_ros_control.yaml to the real servos', with and without rotor inertia
and back-EMF, in every engine. The controller is that of ros_control: an explicit PD law, clipped to the URDF's effort.
Writes pid_sweep.csv (all cells) into results/reference, and the page (`page.py`). Needs REALITYGAP_DATA.
"""

from dataclasses import asdict, dataclass, replace
from fnmatch import fnmatchcase
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import realitygap_engines as engines
from page import write_page
from realitygap.files.progress import Progress
from realitygap.robot.plant import build_plant
from realitygap.scenario.file import load_scenario
from realitygap.simulate.commands import Commands
from realitygap.simulate.motion import first_goals, read_animation
from realitygap.simulate.rollout import rollout
from realitygap.simulate.start import start_state
from realitygap_engines import Diverged, Physics, State
from realitygap_engines.law.dynamics import Dynamics
from realitygap_engines.model.robot import Array, rotation_from_quaternion

HERE = Path(__file__).parent
OUT = HERE.parents[1] / "results" / "reference"
STEP, DURATION, JUDGED = 1e-3, 1.5, 0.5
SUPPLY = 15.0
MOTORS = {"MX-106": (2.19138, 2.96499, 0.026609), "MX-64": (1.62247, 3.94943, 0.011951)}
"""Torque constant [N·m/A], resistance [Ω] and armature [kg·m²] at the output shaft."""
SMALL = ("*Shoulder*", "*Elbow", "Head*")
"""Joints with an MX-64; the others have an MX-106."""
POSITION_GAINS = ("50 N·m/rad", "P 850", "P 1300", "850 N·m/rad")
"""The simulation's, those of the real servos, and the number of the latter taken for N·m/rad."""
DERIVATIVE_GAINS = (0.1, 0.4, 1.0, 5.0, 50.0)
"""N·m·s/rad; the first three are the simulation's."""
DAMPING = ("none", "back-EMF")
"""What damps a joint besides the controller, implicitly, in place of the URDF's 1 N·m·s/rad: nothing or kt²/R."""
SOLVERS = (("mujoco", None), ("dart", None), ("drake", None), ("pybullet", None), ("ode", None), ("ode", 50))
DROP = 0.02
"""Height [m] from which the robot is put down, as one that is spawned: at rest in its stance friction hides much."""
CALM = 0.1
"""A robot that stands is slower than this [rad/s], rms over all joints at the end."""
UPRIGHT = 20.0
"""and has not tilted by more than this [°]."""


@dataclass(frozen=True)
class Cell:
    """One way to stand and what became of it."""

    engine: str
    solver_iterations: int | None
    rotor: bool
    damping: str
    kp: str
    kp_mx64: float
    kp_mx106: float
    kd: float
    damping_number: float
    stability_number: float
    outcome: str
    speed: float
    tilt: float
    saturated: float
    why: str = ""


class Stance:
    """The robot in its stance with one set of motors."""

    def __init__(self, rotor: bool, damping: str) -> None:
        file = load_scenario(HERE / "scenario.yaml")
        self.rotor, self.damping = rotor, damping
        self.plant = plant = build_plant(file)
        names = plant.model.joint_names
        motors = [MOTORS["MX-64" if any(fnmatchcase(n, p) for p in SMALL) else "MX-106"] for n in names]
        constant, resistance, armature = np.array(motors).T
        self.per_duty = SUPPLY * constant / resistance
        plant.drive["armature"] = armature * rotor
        plant.drive["viscous"] = constant**2 / resistance * (damping == "back-EMF")
        self.limit = np.array([j.effort for j in plant.model.joints])
        animation = file.resolve(file.scenario.motion.keyframes, "motion.keyframes")
        self.goal = first_goals(animation, read_animation(animation), plant.model)
        self.start = start_state(plant, self.goal, stand_on=file.scenario.robot.stand_on)
        self.start.base_position[2] += DROP

    def stiffness(self, kp: str) -> Array:
        """The position gain in N·m/rad. Shape (n,). P counts 1/128 of a duty of 1/885 per 4096th of a turn."""
        if kp.startswith("P "):
            return float(kp[2:]) / 128 * 4096 / (2 * np.pi) / 885 * self.per_duty
        return np.full(len(self.goal), float(kp.split()[0]))

    def numbers(self, kp: str, kd: float) -> tuple[float, float]:
        """Largest eigenvalues of h M⁻¹ Kd, and of M⁻¹ (h (Kd + D) + h² Kp/2): beyond 2 a free robot is unstable.

        M holds the rotors, and h D of the damping D that is implicit; h² Kp/2 comes from the semi-implicit Euler step.
        """
        n, model = len(self.goal), self.plant.machine()
        dynamics, base = Dynamics(model), np.zeros(13)
        base[3:7] = self.start.base_quaternion
        dynamics.update(self.goal, np.zeros(n), base, np.zeros(3))
        damping, inertia = self.plant.drive["viscous"], dynamics.inertia.copy()
        joints = np.arange(6, 6 + n)
        inertia[joints, joints] += model.armature + STEP * damping
        free = np.linalg.inv(inertia)[6:, 6:]
        explicit = STEP * np.full(n, kd)
        whole = explicit + STEP * damping + STEP**2 * self.stiffness(kp) / 2
        return tuple(float(np.linalg.eigvals(free * x).real.max()) for x in (explicit, whole))

    def stand(self, engine: str, iterations: int | None, kp: str, kd: float, limit: Array | None = None) -> Cell:
        """Stand for a while."""
        limit = self.limit if limit is None else limit
        stiffness, full = self.stiffness(kp), [0, 0]

        def controller(_: float, q: Array, w: Array) -> Array:
            effort = stiffness * (self.goal - q) - kd * w
            full[0] += int((np.abs(effort) > limit).sum())
            full[1] += len(effort)
            return np.clip(effort, -limit, limit)

        plant = self.plant.copy()
        plant.efforts = [controller]
        off = Commands(np.zeros(1), np.full((1, len(self.goal)), np.nan))
        outcome, speed, tilt = "explodes", np.inf, np.inf
        try:
            with engines.load(engine).open(plant.machine(), Physics(STEP, iterations, plant.ground)) as simulation:
                trace = rollout(simulation, plant, off, self.start, DURATION).trace
        except Diverged:
            pass
        else:
            last = trace.time > DURATION - JUDGED
            speed = float(np.sqrt((trace.velocity[last] ** 2).mean()))
            tilt = max(_tilt(self.start, q) for q in trace.base_quaternion[last][::50])
            outcome = "falls" if tilt > UPRIGHT else "shakes" if speed > CALM else "stands"
        gains = (kp, float(stiffness.min()), float(stiffness.max()), kd)
        made = (outcome, speed, tilt, full[0] / max(full[1], 1))
        return Cell(engine, iterations, self.rotor, self.damping, *gains, *self.numbers(kp, kd), *made)


def _tilt(start: State, quaternion: Array) -> float:
    """The angle between the base's vertical axis and the one it started with [°]."""
    up = rotation_from_quaternion(start.base_quaternion)[2] @ rotation_from_quaternion(quaternion)[2]
    return float(np.degrees(np.arccos(np.clip(up, -1, 1))))


def _why(cell: Cell, cells: dict[tuple, Cell], stances: dict[tuple[bool, str], Stance]) -> str:
    """What lets the robot stand in this cell's place: each cause is one that was taken away in a simulation."""
    if cell.outcome == "stands":
        return ""
    causes = []
    if cell.damping_number > 2:
        causes.append("explicit damping")
    elif cell.stability_number > 2:
        causes.append("explicit stiffness")
    if not cell.rotor and cells[_key(replace(cell, rotor=True))].outcome == "stands":
        causes.append("missing rotor inertia")
    if cell.solver_iterations is not None and cells[_key(replace(cell, solver_iterations=None))].outcome == "stands":
        causes.append(f"only {cell.solver_iterations} iterations")
    if cell.stability_number <= 2:
        stance = stances[cell.rotor, cell.damping]
        free = stance.stand(cell.engine, cell.solver_iterations, cell.kp, cell.kd, np.full_like(stance.limit, np.inf))
        if free.outcome == "stands":
            causes.append("effort limit")
    return "; ".join(causes) or "not found"


def _key(cell: Cell) -> tuple:
    return cell.engine, cell.solver_iterations, cell.rotor, cell.damping, cell.kp, cell.kd


def main() -> None:
    stances = {pair: Stance(*pair) for pair in product((False, True), DAMPING)}
    solvers = [(e, i) for e, i in SOLVERS if e in engines.available()]
    grid = list(product(solvers, stances.values(), POSITION_GAINS, DERIVATIVE_GAINS))
    cells: dict[tuple, Cell] = {}
    progress = Progress()
    with progress.task("standing", len(grid)) as advance:
        for (engine, iterations), stance, kp, kd in grid:
            cell = stance.stand(engine, iterations, kp, kd)
            cells[_key(cell)] = cell
            advance(f"{engine} {iterations or ''} {kp} {kd}: {cell.outcome}")
    rows = [replace(cell, why=_why(cell, cells, stances)) for cell in cells.values()]
    table = pd.DataFrame(map(asdict, rows))
    table["solver_iterations"] = table["solver_iterations"].astype("Int64")
    OUT.mkdir(parents=True, exist_ok=True)
    table.to_csv(OUT / "pid_sweep.csv", index=False, float_format="%.4g", lineterminator="\n")
    write_page(OUT)


if __name__ == "__main__":
    main()
