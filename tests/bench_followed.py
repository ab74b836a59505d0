"""Motions that are followed: how far the engines are apart, and how much faster it is than integrating the motion.

    REALITYGAP_DATA=... python tests/bench_followed.py [SCENARIO]

The same motion is integrated with servos that hold it (at 1 ms, as scenarios are); what it takes is asked of every
engine along the measured stamps, the least of three times. Times are of the processor, as machines are never idle.
"""

import argparse
import sys
import time
from collections.abc import Callable
from itertools import combinations
from pathlib import Path

import numpy as np
import realitygap_engines as engines
from realitygap.robot.drive import PID
from realitygap.scenario.file import load_scenario
from realitygap.simulate.commands import Commands
from realitygap.simulate.experiment import Experiment, experiments, simulate
from realitygap.simulate.rollout import rollout
from realitygap_engines import Physics

SCENARIO = Path(__file__).parents[1] / "scenarios" / "ur10e" / "scenario.yaml"
BEST_OF = 3


def apart(experiment: Experiment) -> float:
    """The largest difference of any two engines' efforts, in shares of the range of the joint's effort."""
    efforts = [simulate(experiment, name).trace.effort for name in engines.available()]
    known = [e for e in efforts if e is not None]
    reach = np.ptp(known[0], axis=0)
    return max(float((np.abs(a - b) / reach).max()) for a, b in combinations(known, 2))


def seconds(experiment: Experiment, engine: str) -> tuple[float, float]:
    """Processor time of following and of integrating a motion in one engine [s]."""
    assert experiment.followed is not None
    _ = experiment.followed.smoothed  # of the recording, once for all engines and candidates
    followed = min(_timed(lambda: simulate(experiment, engine)) for _ in range(BEST_OF))
    return followed, _timed(lambda: integrated(experiment, engine))


def integrated(experiment: Experiment, engine: str) -> None:
    """The motion simulated under servos stiff enough to hold it."""
    assert experiment.followed is not None
    plant, motion = experiment.plant.copy(), experiment.followed
    plant.drive["kind"], plant.drive["kp"], plant.drive["kd"] = PID, 500.0, 20.0
    plant.drive["effort_limit"], plant.drive["velocity_limit"] = np.inf, np.inf
    plant.drive["armature"] = np.maximum(plant.drive["armature"], 0.5)
    commands, start = Commands(motion.time - motion.time[0], motion.position), experiment.start()
    with engines.load(engine).open(plant.machine(), Physics(1e-3)) as simulation:
        rollout(simulation, plant, commands, start, float(np.ptp(motion.time)))


def _timed(work: Callable[[], object]) -> float:
    began = time.process_time()
    work()
    return time.process_time() - began


def main() -> None:
    """A line per run on how far engines are apart, and one per engine on time."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", type=Path, default=SCENARIO)
    found = experiments(load_scenario(parser.parse_args().scenario))
    for experiment in found:
        sys.stdout.write(f"{experiment.name}: engines are {apart(experiment):.2g} of the torque's range apart\n")
    for engine in engines.available():
        followed, whole = seconds(found[0], engine)
        sys.stdout.write(
            f"{engine:9} {found[0].name}: followed {followed:.3f} s, integrated {whole:.2f} s: "
            f"{whole / followed:.0f} times as fast\n"
        )
        sys.stdout.flush()


if __name__ == "__main__":
    main()
