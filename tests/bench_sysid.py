"""The same fit as `mujoco.sysid`: four parameters of one joint from three runs of 6.5 s, time and error side by side.

The recordings are of `mujoco.sysid`'s own model, stepped by plain MuJoCo, with noise. Both start from the same values,
use one core and take turns; processor time counts, the shortest of all turns, without reading files. What is timed here
holds the floors that a diagnosis judges by, and the intervals. `mujoco.sysid` needs packages that are not in the lock:

    python -m pip install --target /tmp/sysid 'mujoco[sysid]==4.0.0'
    PYTHONPATH=$PYTHONPATH:/tmp/sysid taskset -c 0 python tests/bench_sysid.py [--turns 3]
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pandas as pd
from mujoco import sysid
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.search.criterion import Criterion
from realitygap.robot.drive import Array
from realitygap.scenario.file import load_scenario

H, SECONDS, EVERY, NOISE = 1e-3, 6.5, 5, 5e-4
TRUTH = {"armature": 0.02, "frictionloss": 0.25, "damping": 0.4, "gain": 24.0}
FIRST = {"armature": 0.01, "frictionloss": 0.1, "damping": 0.2, "gain": 20.0}
EFFECTS = {  # the same parameter here
    "armature": ("rotor_inertia", "armature"),
    "frictionloss": ("coulomb_friction", "torque"),
    "damping": ("viscous_friction", "coefficient"),
    "gain": ("controller_gain", "gain"),
}
MJCF = """<mujoco><option timestep="{h}" integrator="implicitfast"><flag contact="disable"/></option>
<worldbody><body name="arm"><inertial pos="0 0 -0.15" mass="0.5" diaginertia="0.001 0.001 0.001"/>
<joint name="hinge" axis="0 1 0" armature="{armature}" damping="{damping}" frictionloss="{frictionloss}"
solreffriction="0.002 1"/></body></worldbody>
<actuator><position name="servo" joint="hinge" kp="{gain}"/></actuator>
<sensor><jointpos name="position" joint="hinge"/></sensor></mujoco>"""
URDF = """<robot name="bench"><link name="base"/><link name="arm"><inertial><origin xyz="0 0 -0.15"/><mass value="0.5"/>
<inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-9" upper="9" effort="99" velocity="99"/></joint></robot>"""
SCENARIO = """name: bench
robot: {{urdf: bench.urdf, base: fixed}}
servos: [{{joints: hinge, kind: pid, kp: {gain}, armature: {armature}, friction: {{coulomb: {frictionloss}, viscous: {damping}}}}}]
motion: {{recorded: command}}
ground: none
physics: {{step_rate: 1000}}
recordings:
  virtual: true
  runs: [{{path: run0.csv, use: train}}, {{path: run1.csv, use: train}}, {{path: run2.csv, use: train}}, {{path: run3.csv, use: held_out}}]
"""  # noqa: E501


def commands() -> list[Array]:
    """Sines, triangles, steps, and a chirp that is not fitted to [rad], each held between two samples. Shape (t,)."""
    t = np.arange(0, round(SECONDS / H), EVERY) * H
    told = [
        0.6 * np.sin(2 * np.pi * 0.5 * t) + 0.2 * np.sin(2 * np.pi * 1.7 * t),
        0.8 * (2 / np.pi) * np.arcsin(np.sin(2 * np.pi * 0.4 * t)),
        np.array([0.0, 0.7, -0.4, 0.2, 0.9, -0.8, 0.0])[t.astype(int)],
        0.5 * np.sin(2 * np.pi * (0.2 + 0.2 * t) * t),
    ]
    return [np.repeat(c, EVERY) for c in told]


def recorded(command: Array, seed: int) -> Array:
    """The joint's measured position at every step [rad], simulated in tenths of it. Shape (t,)."""
    model = mujoco.MjModel.from_xml_string(MJCF.format(h=H / 10, **TRUTH))
    data, out = mujoco.MjData(model), np.empty(len(command))
    for k, c in enumerate(command):
        out[k] = data.qpos[0]
        data.ctrl[0] = c
        mujoco.mj_step(model, data, 10)
    return out + np.random.default_rng(seed).normal(0.0, NOISE, len(out))


def fit_here(problem: Problem) -> dict[str, float]:
    """The parameters as a diagnosis fits them."""
    known = {s.effect: s for s in suspects(problem)}
    with Simulations(problem, 1) as simulations:
        found = Criterion(simulations, []).fit([guess(problem, known[effect]) for effect, _ in EFFECTS.values()])
    assert found is not None
    values = {(c.suspect.effect, name): value for c in found.fit.changes for name, value in c.parameters.items()}
    return {name: values[effect] for name, effect in EFFECTS.items()}


def fit_there(runs: list[tuple[Array, Array]]) -> dict[str, float]:
    """The parameters as `mujoco.sysid` fits them, with what its documentation does by default."""
    spec = mujoco.MjSpec.from_string(MJCF.format(h=H, **FIRST))
    model = spec.compile()
    start = sysid.create_initial_state(model, np.zeros(1), np.zeros(1), np.zeros(0))
    t = np.arange(round(SECONDS / H)) * H
    controls = [sysid.TimeSeries(t, c[:, None]) for c, _ in runs]
    # a sensor's value is of the state that a step began with, and has the time at which it ended
    sensed = [sysid.TimeSeries.from_names(t[::EVERY] + H, q[::EVERY, None], model) for _, q in runs]
    params = sysid.ParameterDict()
    for name in ("armature", "frictionloss", "damping"):

        def change(s: mujoco.MjSpec, p: sysid.Parameter, name: str = name) -> None:
            old = getattr(s.joint("hinge"), name)
            setattr(s.joint("hinge"), name, p.value[0] if np.isscalar(old) else [p.value[0], *old[1:]])

        params.add(sysid.Parameter(name, FIRST[name], 0.01 * FIRST[name], 20 * FIRST[name], modifier=change))

    def stiffen(s: mujoco.MjSpec, p: sysid.Parameter) -> None:
        sysid.apply_pgain(s, "servo", p.value[0])

    params.add(sysid.Parameter("gain", FIRST["gain"], 1.0, 100.0, modifier=stiffen))
    runs_of = sysid.ModelSequences("bench", spec, [f"run{k}" for k in range(3)], [start] * 3, controls, sensed)
    residual = sysid.build_residual_fn(models_sequences=[runs_of], n_threads=1)
    found, _ = sysid.optimize(initial_params=params, residual_fn=residual, verbose=False)  # it prints its steps
    return {name: float(found[name].value[0]) for name in TRUTH}


def main() -> None:
    """Print time and error of both."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--turns", type=int, default=3)
    options = parser.parse_args()
    runs = [(c, recorded(c, seed)) for seed, c in enumerate(commands())]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for k, (c, q) in enumerate(runs):
            frame = pd.DataFrame({"time": np.arange(len(c)) * H, "command": c, "position": q})
            frame[::EVERY].to_csv(folder / f"run{k}.csv", index=False)
        (folder / "bench.urdf").write_text(URDF)
        (folder / "scenario.yaml").write_text(SCENARIO.format(**FIRST))
        problem = build_problem(load_scenario(folder / "scenario.yaml"), "mujoco")
    fits: dict[str, Callable[[], dict[str, float]]] = {
        "realitygap": lambda: fit_here(problem),
        "mujoco.sysid": lambda: fit_there(runs[:3]),
    }
    took, values = dict.fromkeys(fits, np.inf), dict[str, dict[str, float]]()
    for _ in range(options.turns):
        for name, fit in fits.items():
            begin = time.process_time()
            values[name] = fit()
            took[name] = min(took[name], time.process_time() - begin)
    for name, found in values.items():
        errors = ", ".join(f"{p} {100 * (found[p] / TRUTH[p] - 1):+.2f} %" for p in TRUTH)
        print(f"{name}: {took[name]:.2f} s; {errors}")


if __name__ == "__main__":
    main()
