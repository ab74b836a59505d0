"""A humanoid with dc servos and friction in threads of one process: steps per second beside `mujoco.rollout` alone.

Both step the same compiled model (26 degrees of freedom, dry friction in every joint, two feet of four spheres on the
ground) along the same commands: the harness with its drive law and trace, `mujoco.rollout` with MuJoCo's own position
actuators of the same stiffness and damping. They take turns; wall time counts, the shortest of all turns.

    python tests/bench_threads.py [--threads 2] [--motions 4] [--turns 20]
"""

import argparse
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack

import mujoco
import numpy as np
import realitygap_engines as engines
from bare_loops import Case, H
from bench_overhead import FRICTION, SERVO, case, humanoid
from mujoco import rollout as native
from realitygap.simulate.commands import on_steps
from realitygap.simulate.rollout import rollout
from realitygap_engines import Physics
from realitygap_engines.mujoco import build_spec


def serviced(seconds: float) -> Case:
    """The humanoid with dc servos and friction, without that which grows with load: `mujoco.rollout` has none."""
    found = case(humanoid(), seconds, servo=True)
    found.plant.drive["load"] = 0.0
    return found


def harness(c: Case, threads: int, motions: int) -> tuple[Callable[[], object], ExitStack]:
    """The motions in the harness, each in a simulation of its own, and what closes them."""
    opened, physics = ExitStack(), Physics(H, ground=c.plant.ground)
    simulations = [
        opened.enter_context(engines.load("mujoco").open(c.plant.machine(), physics)) for _ in range(motions)
    ]
    pool = opened.enter_context(ThreadPoolExecutor(threads))
    commands, start = c.commands(), c.start()
    return (
        lambda: list(pool.map(lambda s: rollout(s, c.plant, commands, start, c.seconds), simulations)),
        opened,
    )


def alone(c: Case, threads: int, motions: int) -> tuple[Callable[[], object], native.Rollout]:
    """The motions by `mujoco.rollout`, and what closes it."""
    spec = build_spec(c.plant.machine(), Physics(H, ground=c.plant.ground))
    stiffness = SERVO["torque_constant"] / SERVO["resistance"] * SERVO["supply"] * SERVO["gain"]
    back_emf = SERVO["torque_constant"] ** 2 / SERVO["resistance"]
    for joint in c.plant.model.joints:
        actuator = spec.add_actuator(
            name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT, gainprm=[stiffness] + [0] * 9
        )
        actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
        actuator.biasprm = [0, -stiffness] + [0] * 8
    model = spec.compile()
    model.dof_damping[6:] = back_emf + FRICTION["viscous"]
    model.dof_frictionloss[6:] = FRICTION["coulomb"]
    data = [mujoco.MjData(model) for _ in range(threads)]
    start = c.start()
    data[0].qpos[:3], data[0].qpos[3:7], data[0].qpos[7:] = start.base_position, start.base_quaternion, start.position
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data[0], state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    command = on_steps(c.commands(), round(c.seconds / H), H, c.plant.delay)[: round(c.seconds / H)]
    runner = native.Rollout(nthread=threads)
    initial, control = np.tile(state, (motions, 1)), np.tile(command, (motions, 1, 1))
    return lambda: runner.rollout(model, data, initial, control), runner


def main() -> None:
    """Print steps per second of both, and their ratio."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--motions", type=int, default=4)
    parser.add_argument("--turns", type=int, default=20)
    options = parser.parse_args()
    c = serviced(1.0)
    ours, opened = harness(c, options.threads, options.motions)
    theirs, runner = alone(c, options.threads, options.motions)
    best = {"harness": np.inf, "mujoco.rollout": np.inf}
    with opened, runner:
        for _ in range(options.turns):
            for name, run in zip(best, (ours, theirs), strict=True):
                begin = time.perf_counter()
                run()
                best[name] = min(best[name], time.perf_counter() - begin)
    rate = {name: options.motions * round(c.seconds / H) / took for name, took in best.items()}
    for name, steps in rate.items():
        print(f"{name}: {steps:,.0f} steps/s on {options.threads} threads")
    print(f"harness / mujoco.rollout: {rate['harness'] / rate['mujoco.rollout']:.2f}")


if __name__ == "__main__":
    main()
