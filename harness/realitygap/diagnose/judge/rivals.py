"""What the data cannot tell apart: other effects whose own fits give the same traces within the floors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from realitygap.diagnose.data.decoys import KNOWN
from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.data.problem import WORST, Change, Problem, Suspect
from realitygap.diagnose.fit.fit import fit
from realitygap.diagnose.search.found import Found, Step, name

MOST = 3
"""Rivals that are listed at most."""
CLOSE = 0.5
"""Share of the best suspect's explanation that a rival's first try must have reached."""
FITTED = 6
"""Rivals that are fitted per finding."""
WORSE = (1.2, 0.5)
"""What came out worse than this multiple and this much more, when the finding was chosen, is no rival."""
TWINS = ({"rotor_inertia", "link_inertia"}, {"joint_offset", "base_tilt"})
"""What is the same thing on one joint: it is fitted however little its first try promised."""
SAME_COST = 0.12
"""How much the mean squared residual of a rival may be larger, on training and on held-out motions."""
SAME_TRACE = 0.7
"""Root mean square of the difference of two fits' traces, in floors, below which they are the same."""


@dataclass(frozen=True)
class Rival:
    """An effect that explains as much as a finding, and why they cannot be told apart here."""

    suspect: Suspect
    why: str


def rivals(pool: Pool, found: Found) -> dict[Suspect, list[Rival]]:
    """For each finding, the suspects that could stand in its place, the simplest first."""
    problem = pool.problem
    train, judge = problem.of("train"), problem.of("held_out")
    questions, owners = [], []
    for step in found.steps:
        own = [c for c in found.fit.changes if c.suspect == step.suspect]
        others = [c for c in found.fit.changes if c.suspect != step.suspect]
        if not own or not step.ranked:
            continue
        top = step.ranked[0].explained
        tried = _tried(step, [*train, *judge])
        seen: set[Suspect] = {step.suspect, *(c.suspect for c in others)}
        most = len(seen) + FITTED
        for screened in step.ranked:
            suspect = screened.change.suspect
            promising = screened.explained >= CLOSE * top and len(seen) < most
            if suspect in seen or not (promising or _twins(problem, step.suspect, suspect)):
                continue
            seen.add(suspect)
            first = screened.change
            if step.suspect in tried and suspect in tried:
                least, fitted = tried[step.suspect][0], tried[suspect]
                if fitted[0] > WORSE[0] * least + WORSE[1]:
                    continue
                first = fitted[1]
            questions.append(([*others, first], train, judge))
            owners.append(step.suspect)
    fits = pool.map(fit, questions)
    out: dict[Suspect, list[Rival]] = {}
    order = list(KNOWN)
    for owner, other in zip(owners, fits, strict=True):
        cases = [*train, *judge]
        worse = max(other.mean_cost(part) - found.fit.mean_cost(part) for part in (train, judge))
        apart = difference(problem, found.fit.changes, other.changes, cases) if worse <= SAME_COST else WORST
        if apart <= SAME_TRACE:
            rival = other.changes[-1].suspect
            why = f"its own fit differs from this one by {apart:.2f} floors on all runs"
            out.setdefault(owner, []).append(Rival(rival, why))
    for listed in out.values():
        listed.sort(key=lambda r: (len(KNOWN[r.suspect.effect].parameters), order.index(r.suspect.effect)))
        del listed[MOST:]
    return out


def _twins(problem: Problem, a: Suspect, b: Suspect) -> bool:
    """Whether both can be the same thing on one joint of a robot on a fixed base."""
    fixed = not problem.plant.model.floating
    return fixed and {a.effect, b.effect} in TWINS and _first_joint(a) == _first_joint(b)


def _first_joint(suspect: Suspect) -> int:
    """The joint that a suspect acts at; a link's is the one that carries it, the base acts at the first."""
    return suspect.indices[0] - (KNOWN[suspect.effect].sits_at == "link")


def _tried(step: Step, cases: Sequence[int]) -> dict[Suspect, tuple[float, Change]]:
    """What each suspect left, when the finding was chosen, and how it was fitted."""
    out: dict[Suspect, tuple[float, Change]] = {}
    for fitted in step.tried:
        last, cost = fitted.changes[-1], fitted.mean_cost(cases)
        if last.suspect not in out or cost < out[last.suspect][0]:
            out[last.suspect] = (cost, last)
    return out


def difference(problem: Problem, a: Sequence[Change], b: Sequence[Change], cases: Sequence[int]) -> float:
    """Root mean square difference of the traces of two models, in floors."""
    squares = [np.mean((problem.residuals(a, c) - problem.residuals(b, c)) ** 2) for c in cases]
    return float(np.sqrt(np.mean(squares)))


SEPARATES = {
    frozenset(
        {"link_mass", "center_of_mass"}
    ): "repeat a motion with a known second load: mass and centre of mass part there",
    frozenset({"link_mass", "constant_effort"}): "hold the joint at several angles on both sides of the vertical",
    frozenset({"joint_offset", "constant_effort"}): "repeat a motion at another controller gain: an offset stays, the "
    "deflection by a torque shrinks",
    frozenset({"joint_offset", "base_tilt"}): "measure the base with a level, or turn the robot by 180°",
    frozenset(
        {"base_tilt", "constant_effort"}
    ): "swing the joint far to both sides: the pull of a tilt changes with the angle",
    frozenset(
        {"center_of_mass", "base_tilt"}
    ): "turn the robot by 180°: a tilt changes its sign, a centre of mass does not",
    frozenset({"rotor_inertia", "link_inertia"}): "repeat a fast motion with a known second load",
    frozenset(
        {"rotor_inertia", "command_delay"}
    ): "let the joint swing freely with the servo off: there is no delay then",
    frozenset({"viscous_friction", "command_delay"}): "let the joint swing freely with the servo off",
    frozenset({"coulomb_friction", "stribeck_friction"}): "a slow triangle, well below the Stribeck velocity",
    frozenset({"coulomb_friction", "load_dependent_friction"}): "repeat the motion with a second load",
    frozenset({"coulomb_friction", "backlash"}): "record the motor's effort in a slow triangle",
    frozenset(
        {"supply_voltage", "torque_constant"}
    ): "measure the supply, or record a fast motion near the speed limit",
    frozenset({"supply_voltage", "controller_gain"}): "measure the supply, or drive the servo into saturation",
    frozenset({"torque_constant", "controller_gain"}): "record the motor's current, or a motion near the speed limit",
    frozenset({"supply_voltage", "voltage_sag"}): "record the supply voltage",
    frozenset({"backlash", "joint_compliance"}): "hold the output and load it in steps to both sides",
}
"""The recording that separates two effects."""


def experiment(listed: dict[Suspect, list[Rival]]) -> str:
    """What to record to settle what cannot be told apart; empty where nothing is open."""
    advice = []
    for owner, others in listed.items():
        for rival in others:
            pair = frozenset({owner.effect, rival.suspect.effect})
            default = "a motion with another load, another gain and a phase with the servo off"
            advice.append(f"{name(owner)} or {name(rival.suspect)}: {SEPARATES.get(pair, default)}")
    return "; ".join(dict.fromkeys(advice))
