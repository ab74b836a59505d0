"""The recordings of `effort_driven` and `velocity_driven`, made anew: `python scenarios/effort_driven/make.py`.

Simulated with the planted friction at 0.1 ms in DART, then read like real ones: every 10 ms or so, by encoders with a
quantum and currents with noise.
"""

from pathlib import Path

import numpy as np
import realitygap_engines as engines
from realitygap.robot.effects.place import place
from realitygap.robot.plant import build_plant
from realitygap.scenario.file import load_scenario
from realitygap.scenario.schema import EffectSpec
from realitygap.simulate.commands import Commands
from realitygap.simulate.rollout import rollout
from realitygap.simulate.start import start_state
from realitygap.trace.trace import Array
from realitygap_engines import Physics

HERE = Path(__file__).parent
STEP, PERIOD, DURATION = 1e-4, 0.01, 5.0
QUANTUM, NOISE = 2 * np.pi / 4096, 0.01
PLANTED = {
    "effort_driven": EffectSpec(effect="coulomb_friction", target="elbow", torque=0.15),
    "velocity_driven": EffectSpec(effect="controller_gain", target="turn", gain=1.1),
}


def sines(time: Array, speeds: tuple[float, ...], sizes: tuple[float, ...]) -> Array:
    return np.asarray(sum(a * np.sin(w * time + k) for k, (w, a) in enumerate(zip(speeds, sizes, strict=True))))


TIME = np.arange(0.0, DURATION, PERIOD)
COMMANDS = {
    ("effort_driven", "sines"): [sines(TIME, (3.0, 7.0), (1.0, 0.6)), sines(TIME, (4.0, 9.0), (0.5, 0.3))],
    ("effort_driven", "chirp"): [1.2 * np.sin(1.5 * TIME**2), 0.6 * np.sin(2.0 * TIME**2 + 1.0)],
    ("velocity_driven", "sweep"): [2.5 * np.sin(1.2 * TIME**2)],
    ("velocity_driven", "steps"): [2.0 * np.sign(np.sin(2.2 * TIME)) * (np.arange(len(TIME)) % 90 > 20)],
}


def record(folder: str, name: str, command: Array, seed: int) -> None:
    """One recording as a table."""
    rng = np.random.default_rng(seed)
    file = load_scenario(HERE.parent / folder / "scenario.yaml")
    plant = place(build_plant(file), [PLANTED[folder]])
    n = len(plant.model.joints)
    with engines.load("dart").open(plant.machine(), Physics(STEP)) as simulation:
        trace = rollout(simulation, plant, Commands(TIME, command), start_state(plant, np.zeros(n)), DURATION).trace
    stamps = np.sort(TIME + rng.uniform(0.0, 0.2 * PERIOD, len(TIME)))
    seen = trace.at(stamps)
    assert seen.position is not None
    assert seen.velocity is not None
    assert seen.effort is not None
    factor = 1.25 if folder == "effort_driven" else 1.0
    columns = {
        "command": command,
        "position": np.round(seen.position / QUANTUM) * QUANTUM,
        "velocity": seen.velocity + 0.02 * rng.normal(size=seen.velocity.shape),
        "current" if folder == "effort_driven" else "effort": (seen.effort + NOISE * rng.normal(size=(len(TIME), n)))
        / factor,
    }
    joints = plant.model.joint_names
    names = [f"{signal}_{joint}" for signal in columns for joint in joints] if n > 1 else list(columns)
    table = np.column_stack([stamps, *columns.values()])
    header = ",".join(["time", *names])
    np.savetxt(HERE.parent / folder / f"{name}.csv", table, fmt="%.5g", delimiter=",", header=header, comments="")


def main() -> None:
    for seed, ((folder, name), command) in enumerate(COMMANDS.items()):
        record(folder, name, np.column_stack(command), seed)


if __name__ == "__main__":
    main()
