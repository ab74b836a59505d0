"""Efforts that no law explains, as candidates: tables over what the missing effort of a joint depends on."""

from __future__ import annotations

from collections.abc import Sequence

from realitygap_engines import Failed, Unsupported

from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.files.errors import InputError
from realitygap.missing.effort import MissingEffort, missing_of
from realitygap.missing.few import few_knots
from realitygap.missing.shape import Term, shape_of
from realitygap.robot.effects import EFFORT_MAP
from realitygap.robot.effort_map import Table

MOST = 24
"""Values of all tables of one joint: more are no shape that a fit over whole motions could tell."""


def unnamed(problem: Problem, changes: Sequence[Change], joints: Sequence[int]) -> list[tuple[Change, ...]]:
    """What the missing effort of some joints depends on, of a model with changes: the tables of one joint each.

    None where no missing effort can be told: of a floating base, of coupled joints, where the engine fails.
    """
    try:
        runs = [_missing(problem, changes, c) for c in problem.of("train")]
    except (InputError, Unsupported, Failed):
        return []
    out = []
    for j in joints:
        joint = problem.plant.model.joint_names[j]
        if any(c.suspect.table is not None and c.suspect.indices == (j,) for c in changes):
            continue
        terms = few_knots(runs, joint, [term for term in shape_of(runs, joint).terms if term.known])
        if terms and sum(len(t.values) for t in terms) <= MOST:
            out.append(tuple(_change(joint, j, term) for term in terms))
    return out


def _missing(problem: Problem, changes: Sequence[Change], case: int) -> MissingEffort:
    plant = problem.changed_plant(changes, case)
    return missing_of(problem.cases[case].experiment.with_plant(plant), problem.engine)


def _change(joint: str, index: int, term: Term) -> Change:
    table = Table(term.variables, term.knots)
    suspect = Suspect(EFFORT_MAP.name, joint, (index,), table=table)
    return Change(suspect, tuple(zip(table.names, term.values, strict=True)), table.names)
