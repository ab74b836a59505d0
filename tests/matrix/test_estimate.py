"""How long and how large cells will be: by their steps, or of a motion that is followed by its samples."""

from dataclasses import replace
from pathlib import Path

import pytest
from realitygap.compare.row import Cell
from realitygap.matrix.collect import _timings
from realitygap.matrix.estimate import BYTES, OVERHEAD, REPORT, SAMPLE, START, STEP, StepCost, costs, memory, steps
from realitygap.matrix.matrix_file import matrix_of
from realitygap.matrix.plan import plan
from realitygap.matrix.task import Outcome, Task
from realitygap.scenario.file import load_scenario

SCENARIOS = Path(__file__).parents[2] / "scenarios"


@pytest.fixture(scope="module")
def demo() -> Task:
    """Two joints, two repetitions."""
    return next(t for t in plan(matrix_of(load_scenario(SCENARIOS / "demo" / "scenario.yaml"), ["mujoco"]))
                if len(t.motion.experiments) == 2)  # fmt: skip


def followed() -> Task:
    """Two joints of which 500 samples in 5 s were measured."""
    file = load_scenario(SCENARIOS / "effort_driven" / "followed.yaml")
    return plan(matrix_of(file, ["mujoco"]))[0]


def test_all_repetitions_are_stepped_and_with_floors_twice_as_finely_again(demo: Task) -> None:
    assert steps(replace(demo, floors=False)) == pytest.approx(
        1000.0 * sum(e.duration for e in demo.motion.experiments)
    )
    assert steps(demo) == pytest.approx(3 * steps(replace(demo, floors=False)))


def test_a_motion_that_is_followed_takes_its_samples_whatever_the_step_rate() -> None:
    task = followed()
    (one,) = task.motion.experiments
    assert one.recording is not None
    samples = len(one.recording.trace.time)
    assert steps(replace(task, floors=False)) == samples < 0.2 * one.duration * one.scenario.physics.step_rate
    assert steps(task) == 2 * samples
    assert memory(task) == 2 * samples * SAMPLE


def test_what_a_motion_holds_is_its_steps_and_its_samples(demo: Task) -> None:
    rows = [0 if e.recording is None else len(e.recording.trace.time) for e in demo.motion.experiments]
    seconds = sum(e.duration for e in demo.motion.experiments)
    assert memory(demo) == pytest.approx(2 * (1000.0 * seconds * BYTES + sum(rows) * SAMPLE))
    needed = 3 * memory(demo)
    assert len(costs(0.0, [demo] * 5, 3, 1.9 * needed)) == 1
    assert f"{needed / 1e9:.1f} GB of memory" in costs(0.0, [demo] * 5, 3, 1.9 * needed)[0]
    assert not costs(0.0, [demo] * 5, 3, 2.1 * needed)


def test_a_step_costs_what_it_did_in_cells_of_the_same_kind(demo: Task) -> None:
    def done(wall: float, engine: str = "mujoco") -> Outcome:
        cell: Cell = replace(demo.cell, engine=engine)
        return Outcome(cell, "ok", wall=wall, steps=1000)

    fixed, each = STEP["mujoco"]
    count = steps(demo)
    assert StepCost([]).seconds(demo) == pytest.approx(count * (fixed + 2 * each) * 1e-6 + OVERHEAD)
    known = StepCost([done(0.1), done(0.3), done(5.0), done(9.0, "dart"), replace(done(7.0), steps=0)])
    assert known.seconds(demo) == pytest.approx(count * 0.3e-3 + OVERHEAD)
    assert known.total([demo] * 4, 2) == pytest.approx(2 * known.seconds(demo) + START + REPORT)
    assert known.total([], 2) == REPORT


def test_how_fast_a_motion_is_is_its_duration_and_not_its_samples_by_a_step_rate_it_has_not(demo: Task) -> None:
    for task, count, seconds in ((followed(), 500, followed().motion.experiments[0].duration), (demo, 4500, 4.5)):
        (factor,) = _timings([(task, Outcome(task.cell, "ok", wall=0.5, steps=count))])["real_time_factor"]
        assert factor == pytest.approx(seconds / 0.5)
