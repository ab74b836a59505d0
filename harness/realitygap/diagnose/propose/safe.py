"""Safety: no motion leaves a limit, whichever explanation is true and whichever engine simulates it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from realitygap_engines import Diverged, Failed, Unsupported

from realitygap.diagnose.data.changes import changed
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.propose.excitation import Excitation, experiment_of
from realitygap.diagnose.propose.keyframes import played
from realitygap.diagnose.propose.limits import Limits
from realitygap.diagnose.search.evidence import Scored
from realitygap.robot.drive import Array
from realitygap.robot.plant import Plant
from realitygap.simulate.experiment import Experiment, simulate
from realitygap.simulate.footing import lost_footing
from realitygap.simulate.motion import TICK
from realitygap.trace.trace import Trace

PHASES = 4
"""Times between two samples of a slow servo at which a motion is tried to begin: what it asks for at a sample then
differs by an eighth of a period at most from what was tried."""


def simulated(
    simulations: Simulations, explanations: Sequence[Scored], cases: Sequence[int], floors: Floors
) -> list[list[dict[str, Array] | None]]:
    """What every explanation says of each case, and how far a robot on its feet is from keeping them; None for what
    cannot be simulated.
    """
    on_feet, number = simulations.problem.plant.model.floating, len(explanations)
    asked = [simulations.query(e.fit.changes, c, coarse=floors.coarse) for c in cases for e in explanations]
    answers = simulations.ask([replace(q, footing=on_feet) for q in asked])
    return [answers[k * number : (k + 1) * number] for k in range(len(cases))]


def safe_cases(
    simulations: Simulations,
    explanations: Sequence[Scored],
    cases: Sequence[int],
    floors: Floors,
    limits: Limits,
) -> list[int]:
    """The cases that can be simulated under every explanation and stay within the limits, and on their feet, at the
    judged stamps.
    """
    problem, out = simulations.problem, []
    for case, here in zip(cases, simulated(simulations, explanations, cases, floors), strict=True):
        told = problem.cases[case].experiment.commands.value
        if asks_beyond(told, limits) or any(a is None for a in here):
            continue
        if any(a["footing"].max() > 0.0 for a in here if a is not None and "footing" in a):
            continue
        time = problem.cases[case].measured.time
        names = problem.plant.model.joint_names
        traces = [_trace(time, names, a) for a in here if a is not None]
        if all(limits.first(t) is None for t in traces if t is not None):
            out.append(case)
    return out


def asks_beyond(command: Array, limits: Limits) -> bool:
    """Whether a position is asked for that is out of reach."""
    return bool(np.nanmax(np.maximum(limits.lower - command, command - limits.upper)) > 0.0)


def _trace(time: Array, names: Sequence[str], signals: dict[str, Array]) -> Trace | None:
    """What a simulation says of positions and speeds; None where it says nothing of them."""
    if "position" not in signals:
        return None
    position = signals["position"]
    velocity = signals.get("velocity", np.gradient(position, time, axis=0))
    return Trace(time, tuple(names), position, velocity, signals.get("effort"))


@dataclass(frozen=True)
class Trial:
    """A way of performing a motion with a plant in an engine, and the limits that are to hold.

    Attributes:
        way: the motion.
        plant: the robot.
        engine: that simulates it.
        limits: of the robot.
    """

    way: Experiment
    plant: Plant
    engine: str
    limits: Limits

    def answer(self, _: object = None, /) -> list[float] | None:
        """When it leaves a limit [s]; None where the engine cannot simulate it."""
        try:
            trace = simulate(self.way.with_plant(self.plant), self.engine).trace
        except (Unsupported, Failed):
            return None
        except Diverged as error:
            return [error.time + self.way.begin]
        return _left(self.plant, trace.between(-TICK, np.inf), self.limits)  # from where keyframes begin


Tried = Callable[[list[Trial]], Iterable[list[float] | None]]
"""What comes of trials, in their order."""


def here(trials: list[Trial]) -> Iterator[list[float] | None]:
    """One after the other, each when it is asked for."""
    return (t.answer() for t in trials)


def left_in_engines(
    problem: Problem,
    motion: Excitation,
    explanations: Sequence[Scored],
    engines: Sequence[str],
    limits: Limits,
    tried: Tried = here,
) -> tuple[set[int], tuple[str, ...]]:
    """The same as `left_limits`, of every explanation's plant."""
    experiment = experiment_of(motion, problem.cases[0].experiment)
    plants = [changed(experiment.plant, e.fit.changes, problem.plant) for e in explanations]
    return left_limits(experiment, motion, plants, engines, limits, tried)


def left_limits(
    experiment: Experiment,
    motion: Excitation,
    plants: Sequence[Plant],
    engines: Sequence[str],
    limits: Limits,
    tried: Tried = here,
) -> tuple[set[int], tuple[str, ...]]:
    """The numbers of the segments that leave a limit, in the first engine in which any does in any plant; and the
    engines that can simulate the motion, where none does: as it was designed, and as its keyframes are played, whenever
    in between two samples of a slow servo it begins.
    """
    ends = np.cumsum([len(s.value) for s in motion.segments]) * motion.period
    ways = (experiment, played(motion, experiment))
    asked = [(later(way, late), plant) for way, plant in product(ways, plants) for late in phases(plant)]
    held = []
    for engine in engines:
        can, left = True, list[float]()
        for times in tried([Trial(way, plant, engine, limits) for way, plant in asked]):
            if times is None:
                can = False
                break
            left += times
            if left and len(ends) == 1:
                break
        if left:
            return {min(int(k), len(ends) - 1) for k in np.searchsorted(ends, left)}, ()
        if can:
            held.append(engine)
    return set(), tuple(held)


def _left(plant: Plant, trace: Trace, limits: Limits) -> list[float]:
    """When a motion is beyond a limit, or a robot on its feet does not keep them, behind which nothing counts [s]."""
    lost = lost_footing(plant.loaded(), trace)[:1] if plant.model.floating else np.zeros(0)
    left = limits.left(trace)
    return [*left[left < lost.min(initial=np.inf)].tolist(), *lost.tolist()]


def phases(plant: Plant) -> list[float]:
    """How much later than a servo's sample motions may begin [s]: at any time in between, for the slowest servo."""
    period = float(np.max(1.0 / plant.drive["servo_rate"], initial=0.0))
    return [k * period / PHASES for k in range(PHASES)] if period > 0.0 else [0.0]


def later(way: Experiment, late: float) -> Experiment:
    """A motion that begins later in its simulation [s]: its own clock stays."""
    commands = replace(way.commands, time=way.commands.time + late)
    return replace(way, commands=commands, begin=way.begin - late, duration=way.duration + late)
