"""A UR10e with a load of 2.805 kg, by plain regression on the followed motion: `python tests/bench_ur10e.py`.

Shows that smoother, inverse dynamics and friction regressors find the load in every engine, before any diagnosis does.
On `free_1`: friction, offset and rotor of every joint, and mass and centre of mass of every link, as far as they show.
With those, the load's mass and place on `loaded_1`. What is printed: the load beside its published mass, how far apart
engines are, and the processor's time against an integration over time. Without the links' own masses and centres the
load comes out 12 % too heavy: the model's forearm and wrist are not the real ones. `--effects` prints what `free_1`
tells of the arm as the effects that `loaded.yaml` has. `--diagnose` does it as users do, by name: what is missing on
`free_1`, then, in the arm that this gives, what is missing on `loaded_1`.
"""

import sys
import tempfile
import time
from dataclasses import replace
from math import erf
from pathlib import Path

import numpy as np
import realitygap as rg
import realitygap_engines as engines
from realitygap.scenario.file import load_scenario
from realitygap.simulate.experiment import Experiment, experiments, simulate
from realitygap.simulate.rollout import rollout
from realitygap.trace.trace import Array
from realitygap_engines import Physics

SCENARIO = Path(__file__).parents[1] / "scenarios" / "ur10e" / "scenario.yaml"
MASS = 2.805
LINK = "wrist_3_link"
STEP = 1e-5
"""Difference of a derivative [kg or kg·m]."""
RIDGE, TIGHT = 1e-3, 20.0
"""Holds what the motion does not show near the model's own values, in the unit of a weighted sample per kg or kg·m: as
little as makes it solvable, and enough that every link keeps a mass that a link can have."""


def measured(e: Experiment) -> Array:
    assert e.recording is not None
    assert e.recording.trace.effort is not None
    return e.recording.trace.effort


def effort(e: Experiment, engine: str, link: str = "", mass: float = 0.0, moment: Array | None = None) -> Array:
    """What the motion takes with so much more mass [kg] and first moment (3,) [kg·m] on a link. Shape (t, n)."""
    plant = e.plant.copy()
    links = list(plant.model.links)
    for i, own in enumerate(links):
        if own.name == link:
            total = own.mass + mass
            com = (own.mass * own.com + (np.zeros(3) if moment is None else moment)) / total
            about = own.inertia + own.mass * _spread(own.com) - total * _spread(com)
            links[i] = replace(own, mass=total, com=com, inertia=about)
    plant.model = replace(plant.model, links=tuple(links))
    found = simulate(e.with_plant(plant), engine).trace.effort
    assert found is not None
    return found


def _spread(com: Array) -> Array:
    return np.asarray(com @ com * np.eye(3) - np.outer(com, com))


def friction(e: Experiment) -> Array:
    """What opposes the motion, an offset and a rotor, each at one joint. Shape (4 n, t, n)."""
    assert e.followed is not None
    motion = e.followed.smoothed
    _, v, a = motion.value
    columns = [np.vectorize(erf)(v / (np.sqrt(2) * motion.error[1])), v, np.ones_like(v), a]
    return np.array([np.where(np.arange(v.shape[1]) == j, c, 0.0) for c in columns for j in range(v.shape[1])])


def weights(e: Experiment, engine: str, links: list[str]) -> Array:
    """The effort per mass [kg] and first moment [kg·m] of links, in which it is linear. Shape (4 links, t, n)."""
    base, unit = effort(e, engine), np.eye(3) * STEP
    columns = [effort(e, engine, k, *m) for k in links for m in [(STEP, None), *((0.0, u) for u in unit)]]
    return np.array([(c - base) / STEP for c in columns])


def load(free: Experiment, loaded: Experiment, engine: str) -> tuple[float, float, Array, float]:
    """The load's mass, its standard error, its centre, and how much of the loaded effort's spread is left."""
    links = [link.name for link in free.plant.model.links[1:]]
    own, level = unloaded(free, engine, links, RIDGE)
    second = np.concatenate([friction(loaded), weights(loaded, engine, links)])
    target = measured(loaded) - effort(loaded, engine) - np.tensordot(own, second, 1)
    columns = second[-4:] if links[-1] == LINK else weights(loaded, engine, [LINK])
    found, error = _regress(columns, target, level, np.full(4, RIDGE))
    left = np.std(target - np.tensordot(found, columns, 1), axis=0) / np.std(measured(loaded), axis=0)
    return float(found[0]), float(error[0]), found[1:] / found[0], float(left.mean())


def unloaded(free: Experiment, engine: str, links: list[str], ridge: float) -> tuple[Array, Array]:
    """What `friction` and `weights` of the free run come to, and by what every joint is weighed. Shapes (c,), (n,)."""
    columns = np.concatenate([friction(free), weights(free, engine, links)])
    target = measured(free) - effort(free, engine)
    level = np.ones(target.shape[1])
    hold = np.append(np.full(4 * len(level), RIDGE), np.full(4 * len(links), ridge))
    for _ in range(3):  # every joint counts by what is left of it
        own, _ = _regress(columns, target, level, hold)
        level = 1 / np.std(target - np.tensordot(own, columns, 1), axis=0)
    return own, level


def effects(free: Experiment) -> str:
    """What the free run tells of the unloaded arm, as effects of a scenario."""
    links, joints = free.plant.model.links[1:], free.plant.model.joint_names
    own, _ = unloaded(free, "mujoco", [link.name for link in links], TIGHT)
    lines = []
    for joint, (dry, viscous, offset, rotor) in zip(joints, own[: 4 * len(joints)].reshape(4, -1).T, strict=True):
        for name, parameter, value in (
            ("coulomb_friction", "torque", dry),
            ("viscous_friction", "coefficient", viscous),
            ("constant_effort", "effort", -offset),
            ("rotor_inertia", "armature", rotor),
        ):
            lines.append(f"  - {{effect: {name}, target: {joint}, {parameter}: {value:.4g}}}")
    for link, (mass, *moment) in zip(links, own[4 * len(joints) :].reshape(-1, 4), strict=True):
        total = link.mass + mass
        x, y, z = (link.mass * link.com + moment) / total
        lines.append(f"  - {{effect: link_mass, target: {link.name}, mass: {total:.4g}}}")
        lines.append(f"  - {{effect: center_of_mass, target: {link.name}, x: {x:.4g}, y: {y:.4g}, z: {z:.4g}}}")
    return "\n".join(["effects:", *lines])


def _regress(columns: Array, target: Array, level: Array, hold: Array) -> tuple[Array, Array]:
    """Weighted least squares over all samples and joints: values and their standard errors."""
    matrix, rest = (columns * level).reshape(len(columns), -1).T, (target * level).ravel()
    normal = np.linalg.inv(matrix.T @ matrix + np.diag(hold**2))
    found = normal @ (matrix.T @ rest)
    return found, np.sqrt(np.diag(normal) * np.mean((rest - matrix @ found) ** 2))


def integrated(e: Experiment, engine: str) -> float:
    """Seconds of the processor for an integration of the same length at the scenario's rate."""
    with engines.load(engine).open(e.plant.machine(), Physics(e.scenario.timestep)) as simulation:
        start = time.process_time()
        rollout(simulation, e.plant, e.commands, e.start(), 2.0)
        return (time.process_time() - start) * e.duration / 2.0


def diagnosed() -> None:
    """What is named on the arm alone, and in the arm that this gives, on the arm with its load."""
    path = SCENARIO
    with tempfile.TemporaryDirectory() as folder:
        for run in ("free_1", "loaded_1"):
            raw = load_scenario(path).raw
            runs = [{"path": f"${{REALITYGAP_DATA}}/ur10e/{run}.csv"}]
            scenario = {**raw, "recordings": {**raw["recordings"], "runs": runs}}
            start = time.perf_counter()
            found = rg.diagnose(rg.load_scenario(scenario, folder=path.parent))
            before, after = found.gap["held_out"]
            seconds = time.perf_counter() - start
            print(f"{run}: {found.verdict}, held out {before:.2f} -> {after:.2f} floors, {seconds:.0f} s")
            for finding in found.findings:
                within = ", ".join(
                    f"{n} {_short(low)} to {_short(high)}" for n, (low, high) in finding.intervals.items()
                )
                print(f"    {finding} 95 %: {within}")
            path = found.revised.save(Path(folder) / run)


def _short(end: object) -> str:
    """An end of an interval: of an effort without a law one for every value."""
    return f"{end:.4g}" if isinstance(end, float) else str(end)


def main() -> None:
    if "--diagnose" in sys.argv:
        diagnosed()
        return
    free, loaded = experiments(load_scenario(SCENARIO))
    if "--effects" in sys.argv:
        print(effects(free))
        return
    reference = effort(free, "mujoco")
    spread = np.ptp(reference, axis=0)
    for engine in engines.available():
        apart = float((np.abs(effort(free, engine) - reference) / spread).max())
        start = time.process_time()
        effort(free, engine)
        quick = time.process_time() - start
        mass, error, place, left = load(free, loaded, engine)
        print(
            f"{engine:9} mass {mass:.3f} ± {1.96 * error:.3f} kg ({100 * (mass / MASS - 1):+.1f} %), at "
            f"{', '.join(f'{p:.3f}' for p in place)} m; {100 * left:.0f} % of the effort is left; efforts "
            f"{apart:.1e} of their range from MuJoCo's; {integrated(free, engine) / quick:.0f} times faster than "
            f"integrating ({quick:.3f} s)"
        )


if __name__ == "__main__":
    main()
