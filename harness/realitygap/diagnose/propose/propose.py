"""`realitygap propose`: motions that tell apart what the recordings cannot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from realitygap.check import certain
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.likelihood.floors import Floors, measure
from realitygap.diagnose.propose.design import ENOUGH, Answer, Goal, answer, separable, settling, sharper
from realitygap.diagnose.propose.evolve import Part, evolved
from realitygap.diagnose.propose.excitation import Excitation, expected_floors, pose_of, with_motions
from realitygap.diagnose.propose.explanations import Open, shown
from realitygap.diagnose.propose.foreseen import Foreseen
from realitygap.diagnose.propose.limits import as_recorded, limits_of
from realitygap.diagnose.propose.odds import Belief
from realitygap.diagnose.propose.pool import TRIED, by_condition, motions_of, pool_of, stands, within
from realitygap.diagnose.propose.predict import Predictions, predict
from realitygap.diagnose.propose.predicted_discrepancy import PredictedDiscrepancy, predicted_discrepancy
from realitygap.diagnose.propose.proposal import Proposal, Proposed
from realitygap.diagnose.propose.safe import safe_cases
from realitygap.diagnose.propose.screening import screen
from realitygap.diagnose.propose.telling import telling
from realitygap.diagnose.propose.told import mended, opened, origin_of
from realitygap.diagnose.propose.weak import weak
from realitygap.diagnose.result.workflow import SEARCH
from realitygap.diagnose.search.round import Say
from realitygap.diagnose.search.search import needed
from realitygap.files.errors import InputError
from realitygap.files.interrupted import Interrupted
from realitygap.files.progress import Progress
from realitygap.robot.drive import Array
from realitygap.scenario.engine_names import engine_names
from realitygap.scenario.file import ScenarioFile, load_scenario
from realitygap.scenario.propose import ProposeSpec

NARROWER = 0.9
"""An interval that keeps this share of its width is not what one records for."""
SHORTEST = 4.0
"""A motion shorter than this has no room for a single segment [s]."""


def run_proposal(
    path: Path, names: Sequence[str], seconds: float, motions: int, progress: Progress, workers: int | None = None
) -> Proposal:
    """Propose motions.

    Args:
        path: a scenario, or a diagnosis.
        names: engines: the first one searches, and in all of them motions are to stay within the limits; empty: MuJoCo
            searches, and all that are installed count.
        seconds: that a motion may take.
        motions: how many at most.
        progress: told what is being done.
        workers: processes; None for one per core.

    Raises:
        InputError: for a scenario or diagnosis that cannot be used.
    """
    if not seconds >= SHORTEST:
        raise InputError(f"--seconds: found {seconds:g}, expected at least {SHORTEST:g}")
    origin = origin_of(path)
    file = load_scenario(origin.scenario)
    engines = engine_names(names)
    first = engines[0] if names else origin.engine or (SEARCH if SEARCH in engines else engines[0])
    _refuse_undriven(file)
    if not (file.scenario.recordings and file.scenario.recordings.runs):
        return screen(file, engines, first, seconds, motions, progress.say, workers)
    warnings = certain(file)
    problem = build_problem(file, first)
    changes = mended(problem, origin, path)
    with Simulations(problem, workers) as simulations:
        open_, floors = opened(simulations, changes, progress.say)
    result = propose(problem, open_, floors, engines, seconds, motions, progress.say, workers)
    result.notes[:0] = [f"likely a mistake: {m.text}" for m in warnings]
    return result


def propose(
    problem: Problem,
    open_: Open,
    floors: Floors,
    engines: Sequence[str],
    seconds: float,
    motions: int,
    say: Say,
    workers: int | None = None,
) -> Proposal:
    """Design motions for what is left open.

    Args:
        problem: the recordings.
        open_: what they leave open.
        floors: of the named model.
        engines: in which motions have to stay within the limits.
        seconds: that each may take.
        motions: how many at most.
        say: told what is being done.
        workers: processes; None for one per core.
    """
    spec = problem.file.scenario.propose or ProposeSpec()
    recorded = np.concatenate([c.value("position") for c in problem.cases])
    limits = limits_of(problem.plant.model, spec, recorded, problem.plant.reached)
    already = shown(open_, needed(len(suspects(problem))))
    open_ = open_.within(ENOUGH)
    result = Proposal(problem, open_, limits, pose_of(problem, spec.pose))
    values = len(open_.explanations[0].fit.names)
    if already:
        told = ", ".join(already)
        result.notes.append(
            f"the recordings show {told} already, and no motion is made for that: a diagnosis that is not cut short "
            "(--minutes inf) says whether to name it"
        )
    if not open_.questions:
        result.notes.append("nothing is left open: no other explanation comes near the findings")
    if not open_.questions and not values:
        return result
    if problem.plant.model.floating and not stands(result):
        result.notes.append(
            "the robot does not keep its feet in the pose where motions start and end; say one in propose.pose"
        )
        return result
    try:
        design(result, spec, floors, engines, seconds, motions, say, workers)
        if result.proposed and result.ended is None:
            _judge(result, say, workers)
            result.proposed = [p for p in result.proposed if _tells(result, p)][:motions]
    except Interrupted as end:
        if not result.proposed:
            raise
        result.ended = end
    if result.ended is not None:
        result.notes.append("ended early: the best so far, with odds as if laws were exact")
    if not result.proposed:
        result.notes.append("no motion within these limits tells more than is known")
        if not open_.questions:
            result.notes[-1] += "; what is left of the intervals is what laws themselves may be off by"
    if result.hopeless and as_recorded(problem.plant.model, spec):
        result.notes.append(
            "what is out of reach may come within it where `propose.limits` lets joints go further or faster than "
            "they went in the recordings"
        )
    return result


def _refuse_undriven(file: ScenarioFile) -> None:
    """Nothing is proposed for what no servos move, or what does not stand.

    Raises:
        InputError: for a scenario of such a robot.
    """
    scenario, what = file.scenario, ""
    if scenario.follows:
        what = "motion: {followed: true}"
    elif scenario.robot.base == "free":
        what = "robot.base: free"
    elif scenario.robot.base == "floating" and scenario.ground_spec is None:
        what = "robot.base: floating with ground: none"
    if what:
        raise InputError(
            f"{file.path}: found {what}; motions are proposed for robots with servos, on a fixed base or on their feet"
        )


def _tells(result: Proposal, proposed: Proposed) -> bool:
    """Whether a motion moves any odds, or makes any interval narrower that is worth a recording."""
    return bool(result.reached(proposed)) or any(w.then < NARROWER * w.now for w in proposed.weak)


def design(
    result: Proposal,
    spec: ProposeSpec,
    floors: Floors,
    engines: Sequence[str],
    seconds: float,
    motions: int,
    say: Say,
    workers: int | None,
) -> None:
    """The best motions of segments that stay within the limits, as if laws were exact."""
    on_feet = result.problem.plant.model.floating

    def steady(motions: list[Excitation]) -> list[Excitation]:  # with many joints side by side, and coarsely
        return _steady(result, motions, floors, workers)

    open_, pool = result.open, pool_of(result, spec, steady if on_feet else None)
    say(f"{len(pool)} pieces of motion within the limits, each under {len(open_.explanations)} explanations")
    parts, beliefs = _parts(result, pool, floors, workers)
    if not parts:
        result.hopeless = open_.questions
        return
    apart = separable(open_.questions, [gram for _, gram in parts], beliefs)
    result.hopeless = tuple(q for q in open_.questions if q not in apart)
    values = len(open_.explanations[0].fit.names)
    if not apart and not values:
        return
    goal: Goal = partial(sharper, beliefs[0], values)
    if apart:
        goal = settling(apart, beliefs, by_condition(parts), seconds)

    def told(motions: list[Excitation]) -> list[Part]:
        good = motions if on_feet else within(result, motions)  # `_parts` asks as `steady` does
        return _parts(result, good, floors, workers)[0]

    more = 0 if on_feet else min(len({id(m.condition) for m in pool}), TRIED)  # a look takes a humanoid minutes
    most, better = max(motions, more), list[Part]()
    try:
        better = evolved(parts, goal, told, np.random.default_rng(0))
        say(f"{len(better)} multisines that were fitted tell more than those that were drawn")
    except Interrupted as end:
        most, result.ended = 1, end
    with Simulations(result.problem, workers) as simulations:
        every = motions_of(result, [*parts, *better], goal, engines, seconds, most, simulations.each)
        for motion, held, gram in every:
            result.proposed.append(_proposed(result, motion, held, gram, beliefs))
            inside = f"stays within the limits in {len(held)} of {len(engines)} engines"
            say(f"{motion.name}, {motion.seconds:.1f} s: {inside}")


def _steady(result: Proposal, motions: Sequence[Excitation], floors: Floors, workers: int | None) -> list[Excitation]:
    """The motions in which a robot stays within the limits and on its feet in the named model."""
    own, wide = len(result.problem.cases), with_motions(result.problem, motions)
    with Simulations(wide, workers) as simulations:
        rough = expected_floors(wide, floors, own)
        cases = range(own, len(wide.cases))
        return [
            motions[c - own] for c in safe_cases(simulations, result.open.explanations[:1], cases, rough, result.limits)
        ]


def _parts(
    result: Proposal, pool: Sequence[Excitation], floors: Floors, workers: int | None
) -> tuple[list[Part], tuple[Belief, ...]]:
    """The segments that stay within the limits, with what they tell as if laws were exact; and the explanations."""
    if not pool:
        return [], ()
    own, wide = len(result.problem.cases), with_motions(result.problem, pool)
    explanations = result.open.explanations
    with Simulations(wide, workers) as simulations:
        rough = expected_floors(wide, floors, own)
        likely = telling(simulations, result.open, range(own, len(wide.cases)), rough)
        good = safe_cases(simulations, explanations, likely, rough, result.limits)
        predictions = predict(simulations, explanations, good, rough) if good else None
    if predictions is None:
        return [], ()
    return [(pool[c - own], g) for c, g in zip(predictions.cases, predictions.grams, strict=True)], predictions.beliefs


def _proposed(
    result: Proposal, motion: Excitation, held: tuple[str, ...], gram: Array, beliefs: Sequence[Belief], case: int = -1
) -> Proposed:
    """A motion with what it does to every question, and to every value of the named model."""
    answers = tuple(answer(q, gram, beliefs) for q in result.open.questions)
    told = weak(result.problem, result.open.explanations[0], beliefs[0], gram, motion.seconds)
    return Proposed(motion, case, answers, held, told)


def _judge(result: Proposal, say: Say, workers: int | None) -> None:
    """The motions as a whole, with all that a diagnosis counts with; the best first."""
    designed, explanations = result.proposed, result.open.explanations
    problem = with_motions(result.problem, [p.motion for p in designed])
    cases = range(len(result.problem.cases), len(problem.cases))
    say(f"{len(designed)} motions as a whole, with what laws may be off by")
    with Simulations(problem, workers) as simulations:
        floors = measure(simulations, explanations[0].fit.changes)
        discrepancy = predicted_discrepancy(simulations, explanations, suspects(problem), cases, floors)
        predictions = predict(simulations, explanations, cases, floors, discrepancy)
        answers = [] if predictions is None else _answers(simulations, result, predictions, floors, discrepancy)
    if predictions is None:
        result.notes.append("the motions could not be simulated as a whole: odds are as if laws were exact")
        return
    beliefs = predictions.beliefs
    whole = [
        replace(_proposed(result, p.motion, p.engines, gram, beliefs, case), answers=told)
        for case, p, gram, told in zip(cases, designed, predictions.grams, answers, strict=True)
    ]
    moved = {q for p in whole for q, a in zip(result.open.questions, p.answers, strict=True) if a.moves(q)}
    result.hopeless = tuple(q for q in result.open.questions if q in result.hopeless or q not in moved)
    result.proposed = whole
    result.proposed = result.ranked()
    result.problem, result.predictions = problem, predictions


def _answers(
    simulations: Simulations,
    result: Proposal,
    predictions: Predictions,
    floors: Floors,
    discrepancy: PredictedDiscrepancy | None,
) -> list[tuple[Answer, ...]]:
    """What every motion does to every question, as a diagnosis would tell it where it may be moved at all; of several
    motions side by side.
    """
    asked = [q for q in result.open.questions if q not in result.hopeless]

    def told(case: int) -> tuple[Answer, ...]:
        foreseen = {}
        if discrepancy is not None:
            answers = Foreseen(simulations, result.open, predictions, floors, discrepancy, case).answers(asked)
            foreseen = {q: a for q, a in zip(asked, answers, strict=True) if a is not None}
        gram = predictions.grams[predictions.cases.index(case)]
        return tuple(foreseen.get(q) or answer(q, gram, predictions.beliefs) for q in result.open.questions)

    return simulations.side_by_side(told, predictions.cases)
