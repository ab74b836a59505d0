"""Which samples hold, move, turn, are loaded or shaken, and where a gap stands out: planted motions and differences."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from realitygap.compare.gap import unit_of
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.judge.gaps import WORST, cost, rms
from realitygap.diagnose.judge.locate import Mask, locate, phases
from realitygap.diagnose.judge.worsened import in_units, worsened
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.robot.drive import PID
from realitygap.trace.trace import Array, Trace

TIME = np.arange(0.0, 6.0, 0.01)
ANGLE = np.interp(TIME, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [0.0, 0.0, 1.0, 0.0, 0.0, 0.04, 0.10])
"""Rests for a second, goes up and down by 1 rad/s, rests, creeps by 0.04 and then by 0.06 rad/s."""
RADIAN = 180.0 / np.pi


def seen(problem: Problem, effort: Array, spin: Array | None = None) -> dict[str, Mask]:
    """The phases of one joint that moves so, beside another that rests."""
    two = np.column_stack([ANGLE, 0.0 * ANGLE])
    trace = Trace(TIME, ("shoulder", "elbow"), position=two, command=two, imu_angular=spin)
    case = replace(problem.cases[0], measured=trace)
    plant = case.experiment.plant.copy()
    plant.drive["kind"], plant.drive["effort_limit"], plant.drive["real_limit"] = PID, 2.0, 1.5
    case = replace(case, experiment=replace(case.experiment, plant=plant))
    return phases(case, 0, {"position": two, "effort": np.column_stack([effort, 0.0 * effort])})


def test_a_joint_that_creeps_holds_and_turns_where_it_changes_its_direction(problem: Problem) -> None:
    found = seen(problem, np.zeros_like(TIME))
    inner = np.min([np.abs(TIME - corner) for corner in (1.0, 3.0, 4.0, 5.0)], axis=0) > 0.02
    holds = ((TIME < 1.0) | ((TIME > 3.0) & (TIME < 5.0))) & inner
    np.testing.assert_array_equal(found["holding"][inner], holds[inner] | (np.abs(TIME[inner] - 2.0) < 0.005))
    np.testing.assert_array_equal(found["moving"], ~found["holding"])
    turns = TIME[found["reversal"]]
    first, second = turns[turns < 4.0], turns[turns > 4.0]
    assert (first.min(), first.max()) == pytest.approx((1.92, 2.08), abs=0.021)
    assert (second.min(), second.max()) == pytest.approx((4.92, 5.08), abs=0.021), "down, a rest, and up again"
    assert len(turns) == pytest.approx(2 * 17, abs=2)


def test_a_joint_is_loaded_above_three_fifths_of_its_largest_effort_and_full_at_the_smaller_limit(
    problem: Problem,
) -> None:
    effort = np.select([TIME < 1.0, TIME < 2.0, TIME < 3.0, TIME < 4.0], [0.88, 0.92, -0.92, -1.5], 0.0)
    found = seen(problem, effort)
    np.testing.assert_array_equal(found["loaded"], (TIME >= 1.0) & (TIME < 4.0))
    np.testing.assert_array_equal(found["saturation"], (TIME >= 3.0) & (TIME < 4.0))


def test_a_base_is_shaken_around_a_jump_of_its_rate(problem: Problem) -> None:
    spin = np.column_stack([0.1 * np.sin(5.0 * TIME), 0.0 * TIME, 1.0 + 1.0 * (TIME >= 2.5)])
    hit = TIME[seen(problem, np.zeros_like(TIME), spin)["impact"]]
    assert (hit.min(), hit.max()) == pytest.approx((2.42, 2.58), abs=0.021)


def floors_of(problem: Problem) -> Floors:
    """The sensors' noise alone."""
    noise = tuple({s: c.noise[s] for s in problem.signals(i)} for i, c in enumerate(problem.cases))
    slow = tuple({s: np.zeros_like(c.value(s)) for s in noise[i]} for i, c in enumerate(problem.cases))
    return Floors(noise, slow, (1.0,) * len(problem.cases), np.zeros(len(problem.plant.model.joints)))


def off(problem: Problem, floors: Floors, times: float | Mapping[int, Array]) -> dict[int, dict[str, Array]]:
    """What differs from the measurement by so many floors, of velocities by as many as `times` says at each sample."""
    out = {}
    for i, case in enumerate(problem.cases):
        out[i] = {s: case.value(s) + (times if isinstance(times, float) else 1.0) * floors.sigma(i, s)
                  for s in floors.noise[i]}  # fmt: skip
        if not isinstance(times, float):
            out[i]["position"] = case.value("position")
            out[i]["velocity"] = case.value("velocity") + times[i] * floors.sigma(i, "velocity")
    return out


def test_a_gap_in_floors_is_a_root_mean_square_of_cases_that_count_alike(problem: Problem) -> None:
    floors = floors_of(problem)
    assert cost(problem, floors, 0, off(problem, floors, 3.0)[0]) == pytest.approx(9.0)
    assert cost(problem, floors, 0, off(problem, floors, 1e4)[0]) == pytest.approx(1e8)
    assert cost(problem, floors, 0, off(problem, floors, 1e9)[0]) == cost(problem, floors, 0, None) == WORST**2
    assert rms({4: 1.0, 7: 9.0, 8: 100.0}, [4, 7]) == pytest.approx(np.sqrt(5.0))


@pytest.mark.parametrize(("larger", "named"), [(1.2, False), (1.4, True)])
def test_a_phase_is_named_where_its_residual_is_clearly_larger_than_that_of_the_whole(
    problem: Problem, larger: float, named: bool
) -> None:
    """The reversals of the elbow, of which the other samples are off by as much as makes the whole."""
    floors = floors_of(problem)
    turns = {i: phases(c, 1, {"position": c.value("position")})["reversal"] for i, c in enumerate(problem.cases)}
    share = float(np.mean(np.concatenate(list(turns.values()))))
    factor = 4.0 * larger * np.sqrt((1.0 - share) / (1.0 - larger**2 * share))
    times = {i: np.where(turn, factor, 4.0)[:, None] for i, turn in turns.items()}
    places = locate(problem, floors, off(problem, floors, times))
    (place,) = (p for p in places if (p.joint, p.signal) == ("elbow", "velocity"))
    assert [p.floors for p in places] == sorted((p.floors for p in places), reverse=True), "the largest first"
    assert ("reversal" in place.when) == named
    assert place.floors == pytest.approx(factor / larger)


@pytest.mark.parametrize(
    ("before", "after", "told"), [(10.0, 10.4, False), (1.0, 1.2, False), (10.0, 10.6, True), (1.0, 1.3, True)]
)
def test_a_gap_has_grown_by_a_twentieth_and_a_quarter_of_the_noise(
    problem: Problem, before: float, after: float, told: bool
) -> None:
    floors, judge = floors_of(problem), problem.of("held_out")
    noise = tuple({s: np.full_like(v, 0.01) for s, v in of.items()} for of in floors.noise)
    floors = replace(floors, noise=noise)
    found = worsened(problem, floors, judge, off(problem, floors, before), off(problem, floors, after))
    assert {(w.joint, w.signal) for w in found} == (
        {(j, s) for j in problem.plant.model.joint_names for s in noise[judge[0]]} if told else set()
    )
    for w in found:
        scale = 1.0 if w.signal == "effort" else RADIAN
        assert (w.before, w.after) == pytest.approx((0.01 * before * scale, 0.01 * after * scale))


def test_a_gap_in_units_is_of_one_kind_of_joint_alone(problem: Problem) -> None:
    """The shoulder turns and the elbow slides: neither's gap is a mean of both."""
    floors, judge, plant = floors_of(problem), problem.of("held_out"), problem.plant.copy()
    first, second = plant.model.joints
    plant.model = replace(plant.model, joints=(first, replace(second, prismatic=True)))
    noise = tuple({s: np.array([0.01, 0.03]) for s in of} for of in floors.noise)
    floors, problem = replace(floors, noise=noise), replace(problem, plant=plant)
    found = in_units(problem, judge, off(problem, floors, 1.0), off(problem, floors, 2.0))
    signals = list(noise[judge[0]])
    assert sorted(u.signal for u in found) == sorted(2 * signals)
    turns, slides = (u for u in found if u.signal == "position")
    assert (turns.before, turns.after) == pytest.approx((0.01 * RADIAN, 0.02 * RADIAN))
    assert slides.after / slides.before == pytest.approx(2.0)
    assert slides.before == pytest.approx(0.03 * unit_of("position", True)[1])
    assert (turns.unit, slides.unit) == (unit_of("position", False)[0], unit_of("position", True)[0])
    assert turns.logarithm == pytest.approx(np.log(2.0))
