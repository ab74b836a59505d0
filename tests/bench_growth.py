"""What a simulation leaves in memory: how one process grows over many rollouts, per engine.

    python tests/bench_growth.py [--rollouts 200] [--warm 20] [--seconds 0.2] [--engine NAME ...]

Every engine has a process of its own for each robot, a pendulum and a humanoid on a floor, and opens it anew for every
rollout. What the process holds (RSS) after the first ones is compared with what it holds after the counted ones. Exits
with 1 where a rollout leaves more than 10 kB.
"""

import argparse
import gc
import subprocess
import sys
from pathlib import Path

import realitygap_engines as engines
from bare_loops import Case, H
from bench_overhead import case, humanoid, pendulum
from realitygap.simulate.rollout import rollout
from realitygap_engines import Physics

MOST = 10.0
"""kB that a rollout may leave."""
ROBOTS = {"pendulum": pendulum, "humanoid": humanoid}


def rolled(engine: str, c: Case) -> None:
    """One simulation from its opening to its end."""
    with engines.load(engine).open(c.plant.machine(), Physics(H, 50, c.plant.ground)) as simulation:
        rollout(simulation, c.plant, c.commands(), c.start(), c.seconds)


def held() -> float:
    """What this process holds in memory [kB]."""
    gc.collect()
    status = Path("/proc/self/status").read_text()
    return float(next(line.split()[1] for line in status.splitlines() if line.startswith("VmRSS")))


def growth(engine: str, c: Case, rollouts: int, warm: int) -> float:
    """kB per rollout."""
    for _ in range(warm):
        rolled(engine, c)
    before = held()
    for _ in range(rollouts):
        rolled(engine, c)
    return (held() - before) / rollouts


def apart(engine: str, robot: str, args: argparse.Namespace) -> float:
    """The same in a process of its own."""
    numbers = [f"--{key}={getattr(args, key)}" for key in ("rollouts", "warm", "seconds")]
    command = [sys.executable, __file__, *numbers, "--engine", engine, "--robot", robot]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    return float(done.stdout.splitlines()[-1])


def main() -> int:
    """A line per engine."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rollouts", type=int, default=200)
    parser.add_argument("--warm", type=int, default=20, help="rollouts that are not counted")
    parser.add_argument("--seconds", type=float, default=0.2, help="that a rollout simulates")
    parser.add_argument("--engine", nargs="+", default=list(engines.available()))
    parser.add_argument("--robot", choices=list(ROBOTS), help="this one, with the first engine, in this process")
    args = parser.parse_args()
    if args.robot:
        found = growth(args.engine[0], case(ROBOTS[args.robot](), args.seconds, servo=True), args.rollouts, args.warm)
        sys.stdout.write(f"{found}\n")
        return 0
    worst = 0.0
    for engine in args.engine:
        each = {robot: apart(engine, robot, args) for robot in ROBOTS}
        worst = max(worst, *each.values())
        told = ", ".join(f"{robot} {value:.1f} kB" for robot, value in each.items())
        sys.stdout.write(f"{engine}: {told} per rollout\n")
        sys.stdout.flush()
    return int(worst > MOST)


if __name__ == "__main__":
    sys.exit(main())
