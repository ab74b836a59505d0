"""What laws of the bundled demo (synthetic) are off by is adjusted, and no finding."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest
from demo_problem import DEMO, FRICTION, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Care, Fit
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.judge.adjust import _seen, adjusted
from realitygap.diagnose.judge.gaps import held_out_gap, shown
from realitygap.diagnose.judge.steps import steps
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.found import Found
from realitygap.diagnose.search.linear import LinearGain
from realitygap.scenario.file import load_scenario

GAIN = 5.048
"""Of the recorded servos [duty/rad]."""


def found_in(simulations: Simulations) -> Found:
    """The missing friction, and what stands beside it."""
    problem = simulations.problem
    friction = guess(problem, suspect_of(problem, "coulomb_friction", "elbow"))
    criterion = Criterion(simulations, [friction])
    still, best = residual(simulations, [], criterion.train), criterion.fit([friction])
    assert still is not None
    assert best is not None
    beside = [suspect_of(problem, e, j) for e in ("controller_gain", "viscous_friction") for j in ("shoulder", "elbow")]
    blocks = criterion.responses(best.fit, beside)
    return Found(criterion.score(Fit((), still)), best, best, 6.0, {}, criterion.floors, criterion, blocks=blocks)


@pytest.fixture(scope="module")
def off(simulations: Simulations) -> Iterator[Found]:
    """The same in a model whose gains are 4 % too high."""
    file = load_scenario(DEMO).override({"servos.drive.gain": 1.04 * GAIN})
    with Simulations(build_problem(file, "mujoco"), 2) as own:
        yield found_in(own)


def test_what_laws_are_off_by_is_told_beside_the_findings_and_narrows_the_gap(off: Found) -> None:
    simulations, (friction,) = off.criterion.simulations, off.best.fit.changes
    done = adjusted(simulations, off, [])
    gains = [c for c in done.best.fit.changes if c.suspect in done.adjusted]
    assert [(c.suspect.effect, c.suspect.target) for c in gains] == [
        ("controller_gain", "shoulder"),
        ("controller_gain", "elbow"),
    ]
    assert [c.parameters["gain"] for c in gains] == pytest.approx([GAIN, GAIN], rel=0.01)
    (found,) = (c for c in done.best.fit.changes if c.suspect == friction.suspect)
    assert abs(found.parameters["torque"] - FRICTION) < abs(friction.parameters["torque"] - FRICTION)
    (torque, *_), (was, *_) = done.cautious.deviation, off.cautious.deviation
    moved = found.parameters["torque"] - friction.parameters["torque"]
    assert torque >= 0.99 * float(np.hypot(was, moved)), "no better known than before, and as far as it moved"
    assert held_out_gap(simulations, done.floors, done.best.fit.changes) < 0.5 * held_out_gap(
        simulations, done.floors, off.best.fit.changes
    )
    models = steps(done, [friction.suspect, *done.adjusted])
    assert [len(m) for m in models] == [0, 1, 3], "all of them are one step, the last"
    of = shown(simulations, done.floors, models, ["mujoco"])
    assert of[gains[0].suspect] == of[gains[1].suspect]
    assert of[gains[0].suspect].before == of[friction.suspect].after


def test_the_mended_models_values_are_fitted_as_if_laws_were_exact(off: Found, monkeypatch: pytest.MonkeyPatch) -> None:
    """As those of the findings are: a model that was compared has its evidence at its best, with values drawn away."""
    cares, fit = list[Care](), Criterion.fit

    def told(
        self: Criterion, changes: Sequence[Change], known: Fit | None = None, care: Care = "whole"
    ) -> Scored | None:
        cares.append(care)
        return fit(self, changes, known, care)

    monkeypatch.setattr(Criterion, "fit", told)
    assert adjusted(off.criterion.simulations, off, []).adjusted
    assert cares[-1] == "whole"


def test_what_was_refused_is_not_adjusted(off: Found) -> None:
    simulations = off.criterion.simulations
    shoulder = suspect_of(off.criterion.problem, "controller_gain", "shoulder")
    assert shoulder not in adjusted(simulations, off, [shoulder]).adjusted


def test_what_was_left_out_in_the_end_is_adjusted_where_no_straight_line_leads_there(off: Found) -> None:
    simulations, problem = off.criterion.simulations, off.criterion.problem
    left_out = [suspect_of(problem, "controller_gain", j) for j in ("shoulder", "elbow")]
    fuller = off.criterion.fit([*off.best.fit.changes, *(guess(problem, s) for s in left_out)])
    assert fuller is not None
    found = replace(off, blocks=(), fuller=fuller)
    done = adjusted(simulations, found, [])
    assert list(done.adjusted) == left_out
    values = [c.parameters["gain"] for c in done.best.fit.changes if c.suspect in left_out]
    assert values == pytest.approx([GAIN, GAIN], rel=0.01)
    assert list(adjusted(simulations, found, left_out[:1]).adjusted) == left_out[1:]
    assert adjusted(simulations, replace(found, fuller=None), []).adjusted == ()


def test_what_a_plainer_name_stands_for_is_not_tried_beside_it(off: Found, monkeypatch: pytest.MonkeyPatch) -> None:
    """Friction by side was found, and dry friction took its place; two frictions of a joint cannot stand together."""
    problem, criterion = off.criterion.problem, off.criterion
    sides = guess(problem, suspect_of(problem, "direction_friction", "elbow"))
    gain = guess(problem, suspect_of(problem, "controller_gain", "shoulder"))
    fuller, bare = criterion.fit([sides, gain]), off.base.fit
    assert fuller is not None
    blocks = [*off.blocks, *criterion.responses(bare, [sides.suspect])]
    tried, fit = list[set[Suspect]](), Criterion.fit

    def told(
        self: Criterion, changes: Sequence[Change], known: Fit | None = None, care: Care = "whole"
    ) -> Scored | None:
        tried.append({c.suspect for c in changes})
        return fit(self, changes, known, care)

    monkeypatch.setattr(Criterion, "fit", told)
    assert gain.suspect in adjusted(criterion.simulations, replace(off, blocks=blocks, fuller=fuller), []).adjusted
    assert tried
    assert not any(sides.suspect in of for of in tried)


def test_beside_what_was_left_out_is_adjusted_what_straight_lines_say_there(off: Found) -> None:
    """One gain was found and left out; the other one is what lines from there lead to."""
    shoulder, elbow = (suspect_of(off.criterion.problem, "controller_gain", j) for j in ("shoulder", "elbow"))
    fuller = off.criterion.fit([*off.best.fit.changes, guess(off.criterion.problem, elbow)])
    assert fuller is not None
    own = [b for b in off.blocks if b.suspect == shoulder]
    found = replace(off, blocks=own, fuller=fuller)
    done = adjusted(off.criterion.simulations, found, [])
    assert {c.suspect for c in done.best.fit.changes if c.suspect in done.adjusted} == {shoulder, elbow}


def test_exact_laws_are_left_as_they_are(simulations: Simulations) -> None:
    found = found_in(simulations)
    assert adjusted(simulations, found, []) is found


def test_what_answers_nothing_is_not_fitted(problem: Problem, simulations: Simulations) -> None:
    tilt = suspect_of(problem, "base_tilt", "base")
    still = residual(simulations, [], problem.of("train"))
    assert still is not None
    (block, *_) = Criterion(simulations, []).responses(Fit((), still), [tilt])
    assert _seen(LinearGain(block, (0.1, 0.2), 9.0)).free == ("roll", "pitch")
    deaf = block.columns.copy()
    deaf[:, 0] *= 1e-9
    assert _seen(LinearGain(replace(block, columns=deaf), (0.1, 0.2), 9.0)).free == ("pitch",)
