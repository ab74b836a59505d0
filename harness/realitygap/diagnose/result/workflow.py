"""`realitygap diagnose`: from a scenario to `diagnosis.json`, the page and the mended model."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from realitygap.check import blamed_joints, certain
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.candidates.told import deviations, told_by_recordings
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.processes import Process
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.adjust import adjusted
from realitygap.diagnose.judge.again import told_after_all, untold_after_all, usual_after_all
from realitygap.diagnose.judge.closest import closest
from realitygap.diagnose.judge.gaps import CLEAR, artefacts, costs, held_out_gap, shown
from realitygap.diagnose.judge.held_out import Verdict, certain_of, predicted, supported
from realitygap.diagnose.judge.joined import joined
from realitygap.diagnose.judge.locate import locate
from realitygap.diagnose.judge.ordinary import tolerated
from realitygap.diagnose.judge.plainer import plainer, told_plainly
from realitygap.diagnose.judge.renamed import retold
from realitygap.diagnose.judge.steps import steps, steps_of
from realitygap.diagnose.judge.worsened import InUnits, in_units, worsened
from realitygap.diagnose.result import not_named
from realitygap.diagnose.result.derivative_on_speed import derivative_on_speed
from realitygap.diagnose.result.diagnosis import Diagnosis
from realitygap.diagnose.result.odds import odds
from realitygap.diagnose.result.replaced import replaced
from realitygap.diagnose.result.revise import MJCF, REVISED, write_revised
from realitygap.diagnose.result.story import write_story
from realitygap.diagnose.search.found import Found
from realitygap.diagnose.search.search import search
from realitygap.diagnose.search_budget import UNLIMITED, SearchBudget
from realitygap.files.errors import spared
from realitygap.files.interrupted import last
from realitygap.files.own_files import content, own, remove
from realitygap.files.progress import Progress
from realitygap.files.whole import write_whole
from realitygap.page.style import number
from realitygap.page.style import quantity as in_unit
from realitygap.recording.faults import faults
from realitygap.robot.drive import Array
from realitygap.scenario.engine_names import engine_names
from realitygap.scenario.file import ScenarioFile, load_scenario

SEARCH = "mujoco"
"""The engine to search in where none is asked for: the fastest."""
NOT_REPEATED = (
    "no motion was recorded twice: how much the robot itself differs from one time to the next is not known, and less "
    "is named; record one motion three times"
)
NOT_SOUGHT = (
    "nothing was looked for at {}, where a mistake is likely: mend it, or say that it is none by `accept: [{}]`, and "
    "diagnose again"
)
CUT = (
    "the search stopped when its simulations or its time were used up: more may be missing than what was found; "
    "--minutes inf searches to the end"
)
Say = Callable[[str], None]


def run_diagnosis(
    path: Path,
    names: Sequence[str],
    out: Path,
    progress: Progress,
    workers: int | None = None,
    ahead: list[Process] | None = None,
    minutes: float | None = None,
) -> Diagnosis:
    """Diagnose a scenario and write what was found.

    Args:
        path: the scenario file.
        names: engines: the first one searches, all confirm; empty: MuJoCo searches and all installed confirm.
        out: the result folder.
        progress: told what is being done.
        workers: processes; None for one per core.
        ahead: those of them that were started already.
        minutes: after which nothing more is looked for; None for as long as the robot's joints take.

    Raises:
        InputError: for a scenario that cannot be diagnosed; nothing is written then.
    """
    result = diagnosed(load_scenario(path), names, progress, workers, ahead, minutes)
    with last():
        write_diagnosis(result, out)
    return result


def diagnosed(
    file: ScenarioFile,
    names: Sequence[str],
    progress: Progress,
    workers: int | None = None,
    ahead: list[Process] | None = None,
    minutes: float | None = None,
) -> Diagnosis:
    """The same without writing anything."""
    began = time.monotonic()
    chosen = engine_names(names)
    warnings = certain(file)
    first = chosen[0] if names or SEARCH not in chosen else SEARCH
    problem = build_problem(file, first)
    budget = SearchBudget.of(int(problem.judged.sum()), minutes, began)
    with Simulations(problem, workers, ahead) as simulations:
        result = diagnose(simulations, chosen, progress.say, blamed_joints(warnings), budget)
    result.notes[:0] = [f"likely a mistake: {m.text}" for m in warnings]
    if result.blamed:
        kinds = dict.fromkeys(m.kind for m in warnings if m.joints)
        result.notes.insert(len(warnings), NOT_SOUGHT.format(", ".join(result.blamed), ", ".join(kinds)))
    return result


def diagnose(
    simulations: Simulations,
    names: Sequence[str],
    say: Say = lambda _: None,
    blamed: Collection[str] = (),
    budget: SearchBudget = UNLIMITED,
) -> Diagnosis:
    """Find, name, add and prove.

    Args:
        simulations: of the problem, which says in which engine to search.
        names: engines in which findings are confirmed; the searching one may be among them.
        say: told what is being done.
        blamed: joints where a mistake of the recordings is likely: no physics is named there.
        budget: how long to look for more.
    """
    problem = simulations.problem
    engines = [problem.engine, *(e for e in names if e != problem.engine)]
    joints = problem.plant.model.joint_names
    everyone = [s for s in suspects(problem) if not _at(s, joints) & set(blamed)]
    notes = [*problem.notes, *dict.fromkeys(n for c in problem.cases for n in c.experiment.notes)]
    told = told_by_recordings(problem, everyone)
    found, why_not = _searched(simulations, everyone, told, say, budget)
    changes = _ordered(found, told)
    proofs = shown(simulations, found.floors, steps(found, [c.suspect for c in changes]), engines)
    while mended := [s for s in artefacts(proofs) if s in everyone]:
        notes += [
            f"{s} helps in {problem.engine} far more than in any other engine: it mends that engine, and is not named"
            for s in mended
        ]
        everyone, told = [s for s in everyone if s not in mended], [c for c in told if c.suspect not in mended]
        anew = replace(budget, steps=budget.steps + simulations.steps)
        found, why_not = _searched(simulations, everyone, told, say, anew)
        changes = _ordered(found, told)
        proofs = shown(simulations, found.floors, steps(found, [c.suspect for c in changes]), engines)
    notes += why_not
    if found.cut:
        notes.append(CUT)
    judge = problem.of("held_out")
    before, after = _signals(simulations, []), _signals(simulations, changes)
    judged = predicted(simulations, found.floors, changes)
    against = _against_all(simulations, found, changes, judged, in_units(problem, judge, before, after))
    if against:
        notes.append(against)
        changes, proofs, after = (), {}, before
    if not problem.repeated and not any(case.recorded > 1 for case in problem.cases):
        notes.append(NOT_REPEATED)
    every = range(len(problem.cases))
    gaps = costs(simulations, found.floors, [], every), costs(simulations, found.floors, changes, every)
    result = Diagnosis(
        problem=problem,
        engines=engines,
        found=found,
        changes=tuple(c for c in changes if c.suspect not in found.adjusted),
        adjusted=tuple(c for c in changes if c.suspect in found.adjusted),
        floors=found.floors,
        costs=gaps,
        shown=proofs,
        predicted=judged,
        where=locate(problem, found.floors, before),
        left=[],
        worsened=worsened(problem, found.floors, judge, before, after) if changes else [],
        units=in_units(problem, judge, before, after),
        faults=_sensor_faults(problem),
        closest=closest(simulations, found, changes),
        before=before,
        after=after,
        notes=[*notes, *replaced(problem, changes)],
        deviations={c.suspect: deviations(problem, c) for c in told},
        blamed=tuple(sorted(blamed)),
    )
    result.notes.extend(derivative_on_speed(problem, result.changes, result.interval))
    rest = result.verdict in ("partly explained", "unexplained")
    return replace(result, left=locate(problem, found.floors, after)) if rest else result


def _searched(
    simulations: Simulations, everyone: Sequence[Suspect], told: Sequence[Change], say: Say, budget: SearchBudget
) -> tuple[Found, list[str]]:
    """What a search finds, and neither held-out runs nor its interval speak against; why what else it found is not
    named.

    Held-out runs are asked first, of the models that the search compared: what is left out changes the values of all
    others by more than a finding is worth. On the SO-101 held-out runs spoke for all 18 findings, and once one of them
    had been left out for its interval, against three of the others.
    """
    keep = {c.suspect for c in told}
    found = search(simulations, everyone, told, say, budget)
    say("looking at held-out runs and other engines")
    found, against = supported(simulations, joined(simulations, found, everyone, keep), keep)
    if against:  # what they leave as it is has no more to join
        found = joined(simulations, found, everyone, keep)
    found = retold(simulations, plainer(simulations, found, everyone, keep), found)
    rivals = found.rivals
    found, vague = certain_of(simulations, found, keep)
    found = adjusted(simulations, tolerated(simulations, found, keep), set(against))
    found = told_plainly(simulations, found, everyone, keep)
    found = told_after_all(simulations, found, rivals)
    found, wide = untold_after_all(simulations, found, keep)
    found, small = usual_after_all(simulations, found, keep)
    named = {c.suspect for c in found.best.fit.changes}.difference(found.adjusted)
    why_not = [not_named.held_out_against(s, told) for s, told in against.items()]
    why_not += [not_named.vague(s, found.adjusted) for s in vague if s not in {*named, *wide, *small}]
    why_not += [*(not_named.wide(s) for s in wide), *(not_named.usual(s) for s in small)]
    return found, [*why_not, *(not_named.beaten(s) for s in found.adjusted if s in found.beaten)]


def _against_all(
    simulations: Simulations, found: Found, changes: Sequence[Change], judged: Verdict, units: Sequence[InUnits]
) -> str:
    """Why held-out runs speak against all that was found; empty where they do not.

    A push that comes and goes was a constant effort: with its floors, which grew, the gap shrank by a tenth, and every
    signal was further off. With an offset that a joint has, every signal came closer, by 3 to 26 %, and the gap grew by
    4 %, which a few samples with small floors rule: it speaks against what takes some signal further off. On the whole,
    as the mean of the logarithms says, none may be: with an offset of 11° that stood for a push, positions were 11 %
    further off and the others 1 % closer.
    """
    if judged.worse:
        how = "more probable, which may be chance" if judged.gain > 0.0 else "less probable"
        return (
            f"with what was found on training runs, held-out runs are {odds(abs(judged.gain))} times {how} "
            f"(in logarithms {judged.gain:.1f} ± {judged.error:.1f}): nothing is named"
        )
    without, with_ = (held_out_gap(simulations, found.floors, c) for c in ((), changes))
    closer = bool(units) and all(u.after < u.before for u in units)
    if with_ > max(without, CLEAR) and not closer:
        return (
            f"what was found widens the held-out gap, from {number(without)} to {number(with_)} floors, however much "
            "more probable it makes these runs: not named"
        )
    further = float(np.mean([u.logarithm for u in units])) if changes and units else 0.0
    if further > 0.0:
        said = ", ".join(f"{u.signal} from {number(u.before)} to {in_unit(u.after, u.unit)}" for u in units)
        said += f"; in the mean by {number(100.0 * np.expm1(further), 2)} %"
        return f"what was found takes held-out runs further off on the whole ({said}): not named"
    return ""


def _at(suspect: Suspect, joints: Sequence[str]) -> set[str]:
    """The joints that an effect sits at, or the joint that carries its link."""
    if suspect.kind.sits_at == "joint":
        return {joints[i] for i in suspect.indices}
    return {joints[i - 1] for i in suspect.indices if suspect.kind.sits_at == "link" and i > 0}


def _ordered(found: Found, told: Sequence[Change]) -> tuple[Change, ...]:
    """What was found by steps: what the recordings told first, then what explains most, what laws are off by last."""
    first: list[Suspect] = [c.suspect for c in told]

    def place(change: Change) -> tuple[bool, float]:
        return change.suspect not in first, -found.gains.get(change.suspect, np.inf)

    by_suspect = {c.suspect: c for c in sorted(found.best.fit.changes, key=place)}
    return tuple(by_suspect[s] for step in steps_of(found, list(by_suspect)) for s in step)


def _signals(simulations: Simulations, changes: Sequence[Change]) -> dict[int, dict[str, Array]]:
    every = range(len(simulations.problem.cases))
    answers = simulations.of(changes, every)
    return {c: a for c, a in zip(every, answers, strict=True) if a is not None}


def _sensor_faults(problem: Problem) -> list[str]:
    """Sentences on faults of the sensors and the clock, once per kind."""
    out = []
    for case in problem.cases:
        if case.experiment.recording is not None:
            out += [f"{case.name}: {fault.sentence}" for fault in faults(case.experiment.recording)]
    return list(dict.fromkeys(out))


def write_diagnosis(result: Diagnosis, out: Path) -> None:
    """Write `revised/` and `diagnosis.json`, then the page: a figure that fails costs no result.

    What an earlier diagnosis left in `revised/`, and this one has not, goes.
    """
    file, mended = out / "diagnosis.json", list[str]()
    if result.mended:
        written = write_revised(result.problem, result.mended, out / REVISED)
        mended = [f.relative_to(out).as_posix() for f in written]
    old = own(out, content(file).get("revised"), (f"{REVISED}/*",))
    text = json.dumps(
        result.to_json() | {"revised": mended}, indent=1, ensure_ascii=False, allow_nan=False, default=float
    )
    write_whole(file, text + "\n")
    remove(out, {*old, f"{REVISED}/{MJCF}"}.difference(mended))
    failures: list[str] = []
    with spared("the page", failures):
        write_story(result, out, mended)
    result.notes.extend(failures)
