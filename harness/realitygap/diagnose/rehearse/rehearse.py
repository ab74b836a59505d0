"""`realitygap rehearse`: which effects show in recordings, from which size on, what is named and what confused.

Every effect is planted in the scenario itself, with its own noise, motions and held-out split.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from realitygap_engines import Diverged, Failed, Unsupported

from realitygap.check import certain
from realitygap.diagnose.candidates.suspects import acting, suspects
from realitygap.diagnose.candidates.told import told_by_recordings
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.demanded import demanded
from realitygap.diagnose.judge.gaps import CLEAR, cost
from realitygap.diagnose.likelihood.floors import Floors, measure
from realitygap.diagnose.rehearse.planting import plant_recordings, planted
from realitygap.diagnose.rehearse.visible import Confusable, Visible, confusables, visible
from realitygap.diagnose.result.workflow import SEARCH
from realitygap.diagnose.search.search import needed, search
from realitygap.files.errors import InputError
from realitygap.files.progress import Progress
from realitygap.page.style import engine_label
from realitygap.robot.effects import EFFECTS
from realitygap.scenario.engine_names import engine_names
from realitygap.scenario.file import load_scenario

FIRST, SMALLER, LARGER = 2.0, 1.0, 4.0
"""Sizes at which a search is tried, in the smallest that should be seen: first, after success, after failure."""
FEW = 6
"""With more joints than this, only patterns and the joints that move most are planted ..."""
MOST_MOVED = 3
"""... this many of them."""
SIMULATED = 5
"""Simulations of every run that an effect needs, about."""
CHEAP = 0.5
"""The share of the time that signatures may take on a robot with many joints."""


@dataclass(frozen=True)
class Tried:
    """One full search on planted recordings.

    Attributes:
        planted: what was planted; None for the check with nothing planted.
        factor: its size in first sizes.
        named: what the search named, in the order of acceptance.
        listed: what it said could stand in place of what it named.
    """

    planted: Change | None
    factor: float
    named: tuple[Suspect, ...]
    listed: tuple[Suspect, ...]

    @property
    def outcome(self) -> str:
        """named, listed (as what could stand in place of what was named), nothing, or other."""
        if self.planted is None:
            return "nothing" if not self.named else "other"
        if self.planted.suspect in self.named:
            return "named"
        if self.planted.suspect in self.listed:
            return "listed"
        return "other" if self.named else "nothing"

    @property
    def right(self) -> bool:
        """Whether a reader learns of what was planted; that nothing is there, where nothing was."""
        return self.outcome in ("named", "listed") or (self.planted is None and not self.named)


@dataclass
class Rehearsal:
    """What the recordings of a scenario could reveal.

    Attributes:
        problem: of the scenario.
        robot: the engine that played the robot; the problem's own is the one that searched.
        quiet: mean squared residual with nothing planted, on training and on held-out runs.
        floors: of the scenario's model.
        found: every effect and target with the smallest size that is seen, as signatures tell.
        confusables: what could be taken for what.
        tried: full searches, the first with nothing planted.
        left_out: targets that were not planted, for time.
        impossible: effects that cannot act in this scenario, with the reason.
        notes: sentences on how it was done.
    """

    problem: Problem
    robot: str
    quiet: tuple[float, float]
    floors: Floors
    found: list[Visible] = field(default_factory=list)
    confusables: list[Confusable] = field(default_factory=list)
    tried: list[Tried] = field(default_factory=list)
    left_out: int = 0
    impossible: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


def run_rehearsal(
    path: Path, names: Sequence[str], progress: Progress, budget: float = 300.0, workers: int | None = None
) -> Rehearsal:
    """Rehearse a scenario.

    Args:
        path: the scenario file.
        names: engines: the first searches, the second plays the robot; empty: MuJoCo searches, another one plays.
        progress: told what is being done.
        budget: seconds that it may take, about.
        workers: processes; None for one per core.

    Raises:
        InputError: for a scenario that cannot be diagnosed, or a budget that is no time.
    """
    if not budget > 0:
        raise InputError(f"--budget: found {budget:g}, expected seconds above 0")
    chosen = engine_names(names)
    first = chosen[0] if names or SEARCH not in chosen else SEARCH
    file = load_scenario(path)
    warnings = certain(file)
    problem = build_problem(file, first)
    with Simulations(problem, workers) as simulations:
        result = rehearse(simulations, [e for e in chosen if e != first], budget, progress.say)
    result.notes[:0] = [f"likely a mistake: {m.text}" for m in warnings]
    return result


def rehearse(
    simulations: Simulations, others: Sequence[str], budget: float, say: Callable[[str], None] = lambda _: None
) -> Rehearsal:
    """Plant, look, search and compare, within a budget [s]; `others` are engines that may play the robot."""
    began = time.monotonic()
    problem = simulations.problem
    demanded(simulations, [], problem.of("train"))  # before another engine plays what this one cannot
    say(f"floors of {len(problem.cases)} motions")
    floors = measure(simulations, [])
    result = _quiet(problem, others, floors)
    took = time.monotonic() - began
    everyone, result.left_out = _chosen(problem, budget, took / 4, simulations.workers)
    result.impossible = _impossible(problem)
    say(f"planting {len(everyone)} effects and targets: looking for the smallest size of each that is seen")
    result.found = visible(simulations, floors, everyone, needed(len(acting(problem))), say)
    result.confusables = confusables(result.found)
    seen = [v for v in result.found if v.seen]
    say(f"{len(seen)} of {len(everyone)} show beside the floors; trying what full searches name")
    _search_all(simulations, result, began + budget, say)
    return result


def _quiet(problem: Problem, others: Sequence[str], floors: Floors) -> Rehearsal:
    """The check with nothing planted, in another engine where one agrees within the floors."""
    notes = []
    for engine in [*others, problem.engine]:
        try:
            still = plant_recordings(problem, floors, [], engine)
        except (Diverged, Failed, Unsupported) as error:
            notes.append(f"{engine_label(engine)} could not play the robot: {error}")
            continue
        with Simulations(still, 1) as own:
            answers = own.of([], range(len(still.cases)))
        every = [cost(still, floors, i, a) for i, a in enumerate(answers)]
        quiet = [float(np.mean([every[i] for i in problem.of(use)])) for use in USES]
        if engine != problem.engine and max(quiet) > CLEAR**2:
            notes.append(
                f"{engine_label(engine)} and {engine_label(problem.engine)} differ by {np.sqrt(max(quiet)):.2g} floors "
                "in this scenario with nothing planted, which would hide what is planted"
            )
            continue
        if engine == problem.engine:
            notes.append(
                f"{engine_label(engine)} plays the robot itself, with a finer step: real robots differ more than that"
            )
        return Rehearsal(problem, engine, (quiet[0], quiet[1]), floors, notes=notes)
    raise InputError(f"{problem.file.path}: cannot be rehearsed: {'; '.join(notes)}")


USES = ("train", "held_out")


def _chosen(problem: Problem, budget: float, cost: float, workers: int) -> tuple[list[Suspect], int]:
    """What is planted, and how many targets are left out.

    On a robot with many joints: patterns, the joints that move most and their links, as many as the time allows.
    `cost` is about what simulating every run once takes [s].
    """
    everyone = acting(problem)
    if int(problem.judged.sum()) <= FEW:
        return everyone, 0
    reach = np.max([np.ptp(np.nan_to_num(c.value("position")), axis=0) for c in problem.cases], axis=0)
    moved = [int(j) for j in np.argsort(-np.where(problem.judged, reach, -1.0))[:MOST_MOVED]]

    def priority(s: Suspect) -> int:
        if EFFECTS[s.effect].sits_at in ("ground", "base"):
            return 0
        if len(s.indices) > 1:
            return 1 if s.target == "*" else 2
        joint = s.indices[0] - (EFFECTS[s.effect].sits_at == "link")
        return 3 + moved.index(joint) if joint in moved else 100

    wanted = sorted((s for s in everyone if priority(s) < 100), key=priority)
    room = max(int(CHEAP * budget * workers / (SIMULATED * max(cost, 1e-3))), 10)
    kept = wanted[:room]
    return [s for s in everyone if s in kept], len(everyone) - len(kept)


def _impossible(problem: Problem) -> dict[str, str]:
    """Effects that can act nowhere in this scenario, with the reason at the first place."""
    there = {s.effect for s in acting(problem)}
    return {e.name: e.possible(problem.plant, 0) or "no place" for e in EFFECTS.values() if e.name not in there}


def _search_all(simulations: Simulations, result: Rehearsal, deadline: float, say: Callable[[str], None]) -> None:
    """Full searches: nothing planted in any case, then while there is time every effect, and the sizes around."""
    took: list[float] = []

    def attempt(seen: Visible | None, times: float) -> Tried | None:
        began = time.monotonic()
        if seen is not None and began + (float(np.median(took)) if took else 0.0) > deadline:
            return None
        factor = seen.factor * times if seen else 0.0
        change = planted(result.problem, seen.suspect, factor) if seen else None
        tried = searched(simulations.workers, result, change, factor)
        if tried is not None:
            result.tried.append(tried)
            took.append(time.monotonic() - began)
            left = max(deadline - time.monotonic(), 0.0)
            say(f"{said(tried)} ({left:.0f} s left)")
        return tried

    attempt(None, 0.0)
    order = _round_robin([v for v in result.found if v.seen])
    first = [(v, attempt(v, FIRST)) for v in order]
    for v, tried in first:
        if tried is not None:
            attempt(v, SMALLER if tried.right else LARGER)


def _round_robin(seen: Sequence[Visible]) -> list[Visible]:
    """One target of every effect first, the one that is seen at the smallest size, then the others."""
    groups: dict[str, list[Visible]] = {}
    for v in sorted(seen, key=lambda v: v.factor):
        groups.setdefault(v.suspect.effect, []).append(v)
    rows = [[g[k] for e in EFFECTS if (g := groups.get(e)) and k < len(g)] for k in range(len(seen))]
    return [v for row in rows for v in row]


def searched(workers: int, result: Rehearsal, change: Change | None, factor: float) -> Tried | None:
    """One full search on planted recordings; None where they cannot be simulated."""
    planted_changes = [change] if change else []
    try:
        recorded = plant_recordings(
            result.problem, result.floors, planted_changes, result.robot, seed=len(result.tried)
        )
    except (Diverged, Failed, Unsupported):
        return None
    everyone = suspects(recorded)
    with Simulations(recorded, workers) as own:
        found = search(own, everyone, told_by_recordings(recorded, everyone), lambda _: None)
    named = tuple(c.suspect for c in found.best.fit.changes)
    other = change is not None and bool(named) and change.suspect not in named
    listed = tuple(s for rest in found.rivals.values() for r in rest if r.open for s in r.suspects) if other else ()
    return Tried(change, factor, named, listed)


def said(tried: Tried) -> str:
    """One line on a search."""
    what = "nothing planted" if tried.planted is None else f"{tried.planted.suspect} ×{tried.factor:.2g}"
    named = ", ".join(map(str, tried.named)) or "nothing"
    return f"{what}: named {named}"
