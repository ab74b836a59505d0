"""Where the processor time of a diagnosis goes: by phase, with the simulations and engine steps of each.

    [REALITYGAP_DATA=...] python tests/bench_diagnosis.py [SCENARIO] [--engine mujoco] [--until 600]

Every few milliseconds of processor time a timer looks at which functions are running: the innermost that stands in
`PHASES` has the time since the last look. Nothing in the product knows of it. All is in one process (`-j 1`), as a
timer does not see others; `--until` interrupts a long one after so many seconds of the processor, and tells those.
"""

import argparse
import signal
import sys
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from types import FrameType

SCENARIO = Path(__file__).parents[1] / "scenarios" / "demo" / "scenario.yaml"
EVERY = 0.002
"""Processor time between two looks [s]."""
REST = "the rest"
PHASES = {
    "imports": ["importlib._bootstrap"],
    "compiled code, loading or compiling": ["numba"],
    "reading and checking": ["realitygap.diagnose.data.problem:build_problem", "realitygap.check"],
    "floors": ["realitygap.diagnose.likelihood.floors:measure"],
    "responses of suspects": ["realitygap.diagnose.fit.responses:respond"],
    "suspects where lines lead": ["realitygap.diagnose.search.round:_followed"],
    "derivatives of fits": ["realitygap.diagnose.fit.fit:slope"],
    "steps of fits": ["realitygap.diagnose.fit.fit:fit", "realitygap.diagnose.fit.fit:residual_near"],
    "evidence and moves": ["realitygap.diagnose.search", "realitygap.diagnose.candidates"],
    "engines and held-out runs": ["realitygap.diagnose.judge.gaps:shown"],
    "judging": ["realitygap.diagnose.judge", "realitygap.diagnose.result.workflow:diagnose"],
    "model and page": ["realitygap.diagnose.result"],
}
"""By phase: modules, or functions of them. The innermost frame that is one of them tells."""
STEPPING, SIMULATING = ("realitygap.simulate.steps", "take"), ("realitygap.diagnose.data.worker", "answer")


def outwards(frame: FrameType | None) -> Iterator[tuple[str, str]]:
    """Module and function of a frame and of all that called it."""
    while frame is not None:
        yield str(frame.f_globals.get("__name__", "")), frame.f_code.co_name
        frame = frame.f_back


def phase_of(frame: FrameType | None) -> str:
    """What is being done."""
    for module, function in outwards(frame):
        for phase, places in PHASES.items():
            for place in places:
                where, _, name = place.partition(":")
                inside = module == where if name else f"{module}.".startswith(f"{where}.")
                if inside and name in ("", function):
                    return phase
    return REST


class Looks:
    """Processor time by phase, and what of it engines' steps and what is around them take [s]; steps and motions."""

    def __init__(self, until: float) -> None:
        self.spent, self.stepping, self.around = (defaultdict[str, float](float) for _ in range(3))
        self.simulations, self.steps = Counter[str](), Counter[str]()
        self._until, self._last = until, 0.0

    def look(self, _: int, frame: FrameType | None) -> None:
        """Give the time since the last look to what is running now."""
        now, phase = time.process_time(), phase_of(frame)
        running = set(outwards(frame))
        self.spent[phase] += now - self._last
        if STEPPING in running:
            self.stepping[phase] += now - self._last
        elif SIMULATING in running:
            self.around[phase] += now - self._last
        self._last = now
        if now > self._until:
            self._until = float("inf")
            raise KeyboardInterrupt

    def count(self, begins: bool, steps: int) -> None:
        """Count steps that are about to be taken."""
        phase = phase_of(sys._getframe(1))
        self.simulations[phase] += begins
        self.steps[phase] += steps


def diagnosed(looks: Looks, arguments: list[str]) -> None:
    """The command, looked at."""
    signal.signal(signal.SIGPROF, looks.look)
    signal.setitimer(signal.ITIMER_PROF, EVERY, EVERY)
    with suppress(SystemExit, KeyboardInterrupt):
        counted(looks)
        from realitygap.cli.main import main

        main(arguments)
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    signal.signal(signal.SIGPROF, signal.SIG_IGN)


def counted(looks: Looks) -> None:
    """Have steps counted before they are taken."""
    from realitygap.robot.drive import Array
    from realitygap.simulate.steps import Held, Steps

    take = Steps.take

    def counting(self: Steps, held: Held, at: int, command: Array, volts: Array) -> tuple[int, float]:
        looks.count(held.first + at == 0, len(volts))
        return take(self, held, at, command, volts)

    Steps.take = counting  # type: ignore[method-assign]


def main() -> None:
    """Print a row per phase."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", type=Path, default=SCENARIO)
    parser.add_argument("--until", type=float, default=float("inf"), help="seconds of the processor")
    parser.add_argument("--engine", action="append", default=[], help="as of the command")
    options = parser.parse_args()
    looks = Looks(options.until)
    engines = [word for name in options.engine for word in ("--engine", name)]
    with tempfile.TemporaryDirectory() as out:
        diagnosed(looks, ["diagnose", str(options.scenario), "-j", "1", "--out", out, *engines])
    row = "{:36}" + "{:>12}" * 5
    print(row.format("processor time [s]", "all", "stepping", "around it", "motions", "1000 steps"))
    for phase in (*PHASES, REST):
        times = [f"{of[phase]:.1f}" for of in (looks.spent, looks.stepping, looks.around)]
        print(row.format(phase, *times, looks.simulations[phase], f"{looks.steps[phase] / 1e3:,.0f}"))
    times = [f"{sum(of.values()):.1f}" for of in (looks.spent, looks.stepping, looks.around)]
    print(row.format("", *times, looks.simulations.total(), f"{looks.steps.total() / 1e3:,.0f}"))


if __name__ == "__main__":
    main()
