"""What the harness costs: its time loop against a bare loop over the same engine, and a full servo against a plain one.

The cost of a step is that of a long motion less that of a short one, over the steps between. Both take milliseconds.
Bare and harness stand beside each other in every turn, now one first and now the other. Processor time counts, and of
all turns the least, since a busy machine only adds to it; the error is that of the mean of four such quarters.

    python tests/bench_overhead.py [--turns 200] [--engine NAME ...] [--write FILE]
"""

import argparse
import gc
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import realitygap_engines as engines
from bare_loops import LOOPS, Case, H, Tape
from realitygap.robot.drive import DC, PID, neutral_drive
from realitygap.robot.drive_law import drive_effort
from realitygap.robot.plant import Plant
from realitygap.simulate.rollout import rollout
from realitygap_engines import Ground, Physics
from realitygap_engines.model.robot import Array, Joint, Link, Model, Sphere

SERVO = {"torque_constant": 2.19, "resistance": 2.96, "supply": 15.0, "gain": 5.056, "duty_limit": 0.9625}
FRICTION = {"static": 0.15, "coulomb": 0.1, "stribeck_velocity": 0.2, "viscous": 0.035, "load": 0.05}


def pendulum() -> Model:
    base = Link("base", 1.0, np.zeros(3), np.eye(3) * 1e-3)
    bob = Link("bob", 0.5, np.array([0.0, 0.0, -0.1]), np.eye(3) * 1e-4)
    return Model("pendulum", (base, bob), (Joint("hinge", False, 0, np.eye(4), np.array([0.0, 1.0, 0.0])),), False)


def humanoid() -> Model:
    """Twenty joints, 6.2 kg, on two feet of four corner spheres each."""
    links = [Link("torso", 2.4, np.array([0.0, 0.0, 0.08]), np.diag([0.02, 0.015, 0.012]))]
    joints: list[Joint] = []

    def add(name: str, parent: int, at: tuple[float, float, float], axis: int, mass: float, drop: float) -> int:
        origin = np.eye(4)
        origin[:3, 3] = at
        joints.append(Joint(name, False, parent, origin, np.eye(3)[axis]))
        links.append(
            Link(name, mass, np.array([0.0, 0.0, -drop / 2]), np.diag([1.0, 1.0, 0.5]) * max(mass, 0.1) * 2e-3)
        )
        return len(links) - 1

    for side, y in (("left", 0.06), ("right", -0.06)):
        yaw = add(f"{side}_hip_yaw", 0, (0, y, -0.02), 2, 0.1, 0.02)
        roll = add(f"{side}_hip_roll", yaw, (0, 0, -0.02), 0, 0.2, 0.02)
        pitch = add(f"{side}_hip_pitch", roll, (0, 0, 0), 1, 0.45, 0.15)
        knee = add(f"{side}_knee", pitch, (0, 0, -0.15), 1, 0.3, 0.15)
        ankle = add(f"{side}_ankle_pitch", knee, (0, 0, -0.15), 1, 0.1, 0.02)
        foot = add(f"{side}_ankle_roll", ankle, (0, 0, -0.02), 0, 0.25, 0.03)
        corners = [Sphere(np.array([x, s * 0.04, -0.03]), 1e-3) for x in (-0.08, 0.1) for s in (-1, 1)]
        links[foot] = replace(links[foot], spheres=tuple(corners))
        shoulder = add(f"{side}_shoulder_pitch", 0, (0, 2 * y, 0.15), 1, 0.15, 0.02)
        arm = add(f"{side}_shoulder_roll", shoulder, (0, 0, 0), 0, 0.2, 0.12)
        add(f"{side}_elbow", arm, (0, 0, -0.12), 1, 0.15, 0.12)
    neck = add("head_yaw", 0, (0, 0, 0.2), 2, 0.1, 0.02)
    add("head_pitch", neck, (0, 0, 0.04), 1, 0.3, -0.05)
    return Model("humanoid", tuple(links), tuple(joints), True)


def case(model: Model, seconds: float, *, servo: bool) -> Case:
    """The robot with a plain PID on every joint, or a dc servo with Stribeck, viscous and load-dependent friction."""
    n = len(model.joints)
    drive = neutral_drive(n)
    if servo:
        drive["kind"], drive["armature"] = DC, 0.0266
        for name, value in (SERVO | FRICTION).items():
            drive[name] = value
    else:
        drive["kind"], drive["kp"], drive["kd"] = PID, 30.0, 0.3
    ground = Ground() if model.floating else None
    plant = Plant(model, drive, ground, np.zeros(n), np.zeros(n), np.ones(n), np.zeros(2))
    return Case(model.name, plant, seconds)


def timed(run: Callable[[], object]) -> float:
    """Processor seconds: another process on the same core does not count."""
    begin = time.process_time()
    run()
    return time.process_time() - begin


Loop = Callable[[engines.Simulation, Case], object]


def loops(name: str) -> dict[str, Loop]:
    """The two that are compared; each starts a motion anew."""

    def bare(simulation: engines.Simulation, c: Case) -> None:
        tape = Tape(c)
        simulation.reset(c.start())
        LOOPS[name](simulation, tape)

    def harness(simulation: engines.Simulation, c: Case) -> None:
        rollout(simulation, c.plant, c.commands(), c.start(), c.seconds)

    return {"bare": bare, "harness": harness}


def turns(simulation: engines.Simulation, motions: list[Case], name: str, count: int) -> Array:
    """Processor seconds of the motions, bare and in the harness, turn by turn. Shape (count, 2, motions)."""
    out = np.empty((count, 2, len(motions)))
    both = list(enumerate(loops(name).values()))
    gc.collect()
    gc.disable()  # a collection hits one of the two
    for turn in out:
        both.reverse()
        for i, loop in both:
            turn[i] = [timed(partial(loop, simulation, motion)) for motion in motions]
    gc.enable()
    return out


def measure(name: str, model: Model, steps: tuple[int, int], count: int) -> dict[str, float | str]:
    """Microseconds per step of the bare loop and of the harness, each with a plain PID and with the full servo."""
    row: dict[str, float | str] = {"engine": name, "robot": model.name}
    for kind, servo in (("pid", False), ("servo", True)):
        motions = [case(model, k * H, servo=servo) for k in steps]
        plant = motions[0].plant
        with engines.load(name).open(plant.machine(), Physics(H, ground=plant.ground)) as simulation:
            assert_same(motions[0], simulation, name)  # and all is compiled
            took = turns(simulation, motions, name, count)
        bare, harness = least(took) / (steps[0] - steps[1]) * 1e6
        quarters = [np.divide(*least(took[k::4])) for k in range(4)]
        row |= {f"bare_{kind}": round(bare, 2), f"harness_{kind}": round(harness, 2)}
        row |= {f"overhead_{kind}": round(harness / bare - 1, 3)}
        row |= {f"error_{kind}": round(float(np.std(quarters, ddof=1)) / 2, 3)}
    return row


def least(took: Array) -> Array:
    """The least seconds of the long motion less those of the short one, bare and in the harness. Shape (2,)."""
    best = took.min(axis=0)
    return np.asarray(best[:, 0] - best[:, 1])


def assert_same(c: Case, simulation: engines.Simulation, name: str) -> None:
    """The two loops did the same: their joint positions agree to the last bit but few."""
    tape = Tape(c)
    simulation.reset(c.start())
    LOOPS[name](simulation, tape)
    found = rollout(simulation, c.plant, c.commands(), c.start(), c.seconds).trace.position
    assert found is not None
    np.testing.assert_allclose(found, tape.q[: len(found)], rtol=0, atol=1e-9)


def law(repeats: int = 20, calls: int = 1000) -> dict[str, float]:
    """Microseconds per call of the control law for twenty joints, plain and full."""
    out = {}
    for kind, servo in (("pid", False), ("servo", True)):
        tape = Tape(case(humanoid(), 0.1, servo=servo))
        tape.q[:], tape.w[:] = 0.05, 0.1
        c, c1, q, w, dry, log, *_ = next(iter(tape.rows()))

        def run(tape: Tape = tape, row: tuple[Array, ...] = (c, c1, q, w, dry), log: Array = log) -> None:
            for _ in range(calls):
                drive_effort(
                    tape.drive, tape.state, *row, tape.inertia, 0.0, 0.0, H,
                    tape.effort, tape.damping, tape.friction, log,
                )  # fmt: skip

        run()
        out[kind] = min(timed(run) for _ in range(repeats)) / calls * 1e6
    return out


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--turns", type=int, default=200)
    parser.add_argument("--engine", action="append", choices=sorted(LOOPS))
    parser.add_argument("--write", type=Path, help="also write the table to this file")
    options = parser.parse_args()
    rows = [
        measure(name, model, steps, options.turns)
        for name in options.engine or sorted(set(LOOPS) & set(engines.available()))
        for model, steps in ((pendulum(), (550, 50)), (humanoid(), (90, 10)))
    ]
    found = pd.DataFrame(rows)
    print("Microseconds per step; overhead of the harness over the bare loop, with its standard error:")
    print(found.to_string(index=False))
    print("Control law, twenty joints, µs per step:", {k: round(v, 2) for k, v in law().items()})
    if options.write:
        found.to_csv(options.write, index=False)


if __name__ == "__main__":
    main()
