"""Repetitions are found and brought to one clock, and the noise floor is what was put in."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bags import Run
from realitygap.recording import Recording
from realitygap.recording.align import group_repetitions, noise_floor
from realitygap.recording.delay import delay, mean_squared_difference
from realitygap.recording.frames import angle_between, unit_quaternions
from realitygap.recording.quantum import quantum
from realitygap.robot.drive import Array
from realitygap.trace.trace import Trace
from signals import there

PERIOD = 0.01


def motion(t: Array) -> Array:
    """A kick: still, then a swing, then still."""
    return np.exp(-(((t - 4.0) / 0.6) ** 2)) * np.sin(3.0 * t)


def recording(
    name: str = "run",
    late: float = 0.0,
    length: float = 8.0,
    jitter: float = 0.0,
    goal: Callable[[Array], Array] = motion,
    seed: int = 0,
) -> Recording:
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, length, PERIOD)
    time[1:] += jitter * PERIOD * rng.uniform(-0.5, 0.5, len(time) - 1)
    command = np.column_stack([goal(time - late), 0.5 * goal(time - late)])
    position = np.column_stack([goal(time - late - 0.05), 0.5 * goal(time - late - 0.05)])
    trace = Trace(time, ("a", "b"), position=position, command=command)
    return Recording(Path(f"{name}.mcap"), trace, time, command, "position", np.empty(0), np.empty(0))


@pytest.mark.parametrize("jitter", [0.0, 0.4])
@pytest.mark.parametrize("late", [-1.234, -0.003, 0.0, 0.0042, 0.5, 2.0])
def test_delay_is_found_below_the_sampling_period(late: float, jitter: float) -> None:
    found = delay(recording(jitter=jitter), recording(late=late, length=9.5, jitter=jitter, seed=1))
    assert found == pytest.approx(late, abs=0.1 * PERIOD)


def test_delay_of_a_periodic_motion_is_the_smallest() -> None:
    """Whichever of the two lasts longer, and so has periods before or after that are as good."""
    found = delay(recording(goal=np.sin), recording(goal=np.sin, late=0.3, length=30.0))
    assert found == pytest.approx(0.3, abs=0.1 * PERIOD)
    found = delay(recording(goal=np.sin, late=0.3, length=30.0), recording(goal=np.sin))
    assert found == pytest.approx(-0.3, abs=0.1 * PERIOD)


def test_delay_without_motion_is_none() -> None:
    still = recording(goal=np.zeros_like)
    assert delay(still, recording()) == 0.0


def test_correlation_is_the_sum_it_stands_for() -> None:
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(40, 2)), rng.normal(size=(30, 2))
    a[5:9, 0] = np.nan
    error, lags = mean_squared_difference(a, b)
    for found, lag in zip(error, lags, strict=True):
        squares = np.array([(a[k] - b[k + lag]) ** 2 for k in range(40) if 0 <= k + lag < 30])
        beyond_half = np.isfinite(squares).sum() - 0.5 * np.isfinite(b).sum()
        if beyond_half != 0:  # at exactly half, rounding decides
            assert found == (pytest.approx(np.nanmean(squares)) if beyond_half > 0 else np.inf)


def test_repetitions_are_one_motion_under_one_set_of_conditions() -> None:
    runs = [
        Run("kick_rep1", recording("1"), use="train"),
        Run("kick_rep2", recording("2", late=0.3, jitter=0.3), use="train"),
        Run("kick_p16", recording("3"), '{"servos.*.gain": 2.5}', "train"),
        Run("other", recording("4", goal=lambda t: motion(t) + 0.2 * np.sin(t)), use="train"),
        Run("kick_rep3", recording("5", late=-0.2), use="train"),
        Run("kick_rep4", recording("6"), use="held_out"),
        Run("kick_rep1#2", recording("1"), use="train"),
    ]
    groups = group_repetitions(runs)
    assert [g.indices for g in groups] == [(0, 1, 4), (2,), (3,), (5,), (6,)]
    assert groups[0].name == "kick"
    np.testing.assert_allclose(groups[0].shifts, [0.0, 0.3, -0.2], atol=1e-3)


@pytest.mark.parametrize(("off", "one"), [(0.03, True), (0.08, False)])
def test_commands_of_one_motion_agree_within_a_twentieth(off: float, one: bool) -> None:
    runs = [Run("a", recording("1")), Run("b", recording("2", goal=lambda t: (1.0 + off) * motion(t)))]
    assert len(group_repetitions(runs)) == (1 if one else 2)


def test_what_commands_mean_is_part_of_a_motion() -> None:
    told = recording("2")
    runs = [Run("a", recording("1")), Run("b", replace(told, command_kind="duty"))]
    assert len(group_repetitions(runs)) == 2


@pytest.mark.parametrize(("late", "one"), [(0.5, True), (0.0, False)])
def test_servos_that_are_off_are_off_at_the_same_moments_of_a_motion(late: float, one: bool) -> None:
    """For half a second of eight, amid a hold; the other run's whole motion comes later, with or without that."""

    def off_at(name: str, begin: float, motion_late: float) -> Recording:
        whole = recording(name, late=motion_late)
        command = whole.command.copy()
        command[(whole.command_time >= begin) & (whole.command_time < begin + 0.5)] = np.nan
        return replace(whole, command=command, trace=replace(whole.trace, command=command))

    runs = [Run("a", off_at("1", 1.0, 0.0)), Run("b", off_at("2", 1.0 + late, 0.5))]
    assert len(group_repetitions(runs)) == (1 if one else 2)


def test_windows_elsewhere_in_the_motion_are_not_repetitions() -> None:
    first = Run("a", recording("1"), window=(2.0, 6.0))
    again = Run("b", recording("2", late=0.5), window=(2.5, 6.5))
    other = Run("c", recording("3"), window=(4.0, 8.0))
    assert [g.indices for g in group_repetitions([first, again, other])] == [(0, 1), (2,)]


def test_without_commands_the_measured_motion_says_what_is_a_repetition() -> None:
    """An arm's excitations begin in one pose and last as long as one another: that makes them no repetitions."""

    def led(name: str, seed: int, late: float = 0.0, goal: Callable[[Array], Array] = motion) -> Recording:
        whole = recording(name, late=late, goal=goal)
        measured = there(whole.trace.position) + np.random.default_rng(seed).normal(size=(800, 2)) * 1e-3
        trace = replace(whole.trace, position=measured, command=None)
        return replace(whole, trace=trace, command_time=np.empty(0), command=np.empty((0, 2)), command_kind=None)

    runs = [
        Run("sweep_1", led("1", 1)),
        Run("pick", led("2", 2, goal=lambda t: motion(0.9 * t))),
        Run("sweep_2", led("3", 3, late=0.3)),
        Run("higher", led("4", 4, goal=lambda t: 1.2 * motion(t))),
    ]
    groups = group_repetitions(runs)
    assert [g.indices for g in groups] == [(0, 2), (1,), (3,)]
    np.testing.assert_allclose(groups[0].shifts, [0.0, 0.3], atol=1e-3)


def swung(name: str, angle: float, late: float = 0.0, told: Callable[[Array], Array] = np.zeros_like) -> Recording:
    """A joint that is let go at an angle and told efforts."""
    time = np.arange(0.0, 8.0, PERIOD)
    begun = np.maximum(time - late - 1.0, 0.0)
    position = angle * np.exp(-0.3 * begun) * np.cos(4.0 * begun) + 1e-3 * np.random.default_rng(len(name)).normal(
        size=800
    )
    command = told(time - late)[:, None]
    trace = Trace(time, ("a",), position=position[:, None], command=command)
    return Recording(Path(f"{name}.csv"), trace, time, command, "effort", np.empty(0), np.empty(0))


def test_free_swings_are_repetitions_where_they_swing_alike() -> None:
    """Commands of zero are the same in every motion: they say nothing of it."""
    runs = [Run("one", swung("one", 0.6)), Run("again", swung("again", 0.6, late=0.4)), Run("wide", swung("wide", 1.1))]
    groups = group_repetitions(runs)
    assert [g.indices for g in groups] == [(0, 1), (2,)]
    assert groups[0].shifts[1] == pytest.approx(0.4, abs=0.02)


@pytest.mark.parametrize("size", [0.2, 2e-3])
def test_efforts_make_the_same_motion_from_the_same_place_alone_however_small_they_are(size: float) -> None:
    runs = [
        Run("a", swung("a", 0.6, told=lambda t: size * np.sin(t))),
        Run("again", swung("again", 0.6, told=lambda t: size * np.sin(t))),
        Run("from_elsewhere", swung("from_elsewhere", 0.4, told=lambda t: size * np.sin(t))),
        Run("other", swung("other", 0.6, told=lambda t: size * np.sin(1.5 * t))),
    ]
    assert [g.indices for g in group_repetitions(runs)] == [(0, 1), (2,), (3,)]


def test_where_a_free_motion_starts_is_looked_at_at_one_moment_of_it() -> None:
    """One run was recorded from half a second before its swing on, the other from its begin on."""
    runs = [Run(n, swung(n, 0.6, late=late, told=lambda t: 0.2 * np.sin(t))) for n, late in (("a", -0.5), ("b", -1.0))]
    assert [g.indices for g in group_repetitions(runs)] == [(0, 1)]


def test_a_joint_that_is_told_efforts_and_never_seen_starts_anywhere() -> None:
    def unseen(name: str) -> Recording:
        run = swung(name, 0.6, told=lambda t: 0.2 * np.sin(t))
        return replace(run, trace=replace(run.trace, position=np.full((800, 1), np.nan)))

    runs = [Run(name, unseen(name)) for name in ("one", "two")]
    assert [g.indices for g in group_repetitions(runs)] == [(0, 1)]


def test_a_hold_is_the_same_motion_where_the_robot_stays() -> None:
    still = [recording(name, goal=np.zeros_like) for name in ("one", "two")]
    pushed = recording("pushed", goal=np.zeros_like)
    assert pushed.trace.position is not None
    trace = replace(pushed.trace, position=pushed.trace.position + 0.2 * motion(pushed.trace.time)[:, None])
    runs = [*(Run(r.name, r) for r in still), Run("pushed", replace(pushed, trace=trace))]
    assert [g.indices for g in group_repetitions(runs)] == [(0, 1), (2,)]


def test_bodies_without_joints_are_repetitions_where_they_start_alike() -> None:
    def toss(name: str, height: float) -> Recording:
        time = np.arange(0, 0.5, PERIOD)
        place = np.column_stack([time, 0 * time, height + 0 * time])
        turn = np.tile([1.0, 0, 0, 0], (len(time), 1))
        trace = Trace(time, (), position=np.empty((len(time), 0)), base_position=place, base_quaternion=turn)
        return Recording(Path(name), trace, np.empty(0), np.empty((0, 0)), None, np.empty(0), np.empty(0))

    runs = [Run(n, toss(n, z)) for n, z in (("t1", 1.0), ("t2", 1.005), ("t3", 1.1))]
    assert [g.indices for g in group_repetitions(runs)] == [(0, 1), (2,)]


@pytest.mark.parametrize("count", [2, 3, 10])
def test_noise_floor_is_the_noise_that_was_put_in(count: int) -> None:
    """x minus the mean of r - 1 others has the deviation σ·√(1 + 1/(r-1)); the mean of its size is √(2/π) of that."""
    rng = np.random.default_rng(count)
    sigma = np.array([0.01, 0.03])
    clean = recording().trace
    noisy = [replace(clean, position=there(clean.position) + sigma * rng.normal(size=(800, 2))) for _ in range(count)]
    floors = noise_floor(noisy)
    expected = np.sqrt(2 / np.pi) * sigma * np.sqrt(1 + 1 / (count - 1))
    assert [floors["a", "position"], floors["b", "position"]] == pytest.approx(list(expected), rel=0.1)
    assert ("a", "velocity") not in floors


def test_noise_floor_of_two_is_their_difference_in_every_signal() -> None:
    time = np.arange(0, 1, PERIOD)
    turn = np.column_stack([np.cos(0.05 * time), np.sin(0.05 * time), 0 * time, 0 * time])  # by 0.1·t about x
    still = np.tile([1.0, 0, 0, 0], (100, 1))
    zero = np.zeros((100, 3))
    one = Trace(time, ("a",), effort=np.zeros((100, 1)), base_position=zero, base_quaternion=still, base_angular=zero)
    two = replace(
        one, effort=there(one.effort) + 0.5, base_position=zero + np.array([0.3, 0, 0.4]), base_quaternion=-turn
    )
    floors = noise_floor([one, two])
    assert floors["a", "effort"] == pytest.approx(0.5)
    assert floors["base", "base_position"] == pytest.approx(0.5)
    assert floors["base", "base_orientation"] == pytest.approx(0.1 * time.mean(), rel=1e-6)
    assert floors["base", "base_angular_velocity"] == 0.0


def test_noise_floor_of_an_imu_is_that_of_the_vertical() -> None:
    """A heading that an IMU believes in and that drifts is no difference; how much it turns is, in whatever axes."""
    time = np.arange(0, 1, PERIOD)
    heading, lean = 0.3 * time, 0.02
    none = 0 * time
    one = np.column_stack([np.cos(heading), none, none, np.sin(heading)])
    by_lean = np.array([np.cos(lean / 2), np.sin(lean / 2), 0.0, 0.0])
    two = np.tile(by_lean, (100, 1))
    rates = np.tile([0.3, 0.0, 0.4], (100, 1))
    traces = [Trace(time, (), imu_quaternion=q, imu_angular=w) for q, w in ((one, rates), (two, 1.2 * rates[:, ::-1]))]
    floors = noise_floor(traces)
    assert floors["base", "base_orientation"] == pytest.approx(lean, rel=1e-4)
    assert floors["base", "base_angular_velocity"] == pytest.approx(0.1)


def test_a_single_run_has_the_floor_of_its_quantum() -> None:
    step = 2 * np.pi / 4096
    clean = recording().trace
    position = there(clean.position)
    rounded = replace(clean, position=np.round(position / step) * step)
    floors = noise_floor([rounded])
    assert floors["a", "position"] == pytest.approx(step / 4, rel=1e-9)
    # a quarter is what the rounding does in the mean
    moving = np.abs(np.gradient(position[:, 0])) > step
    assert np.abs(there(rounded.position) - position)[moving, 0].mean() == pytest.approx(step / 4, rel=0.1)


def test_the_quantum_survives_the_rounding_of_files() -> None:
    step = 2 * np.pi / 4096
    value = (np.random.default_rng(0).integers(-1000, 1000, (500, 1)) * step).astype(np.float32).astype(float)
    value = np.vstack([value, value[-1:] + 1e-7])
    assert quantum(value)[0] == pytest.approx(step, rel=1e-3)
    assert quantum(np.ones((5, 1)))[0] == 0.0


def test_angles_and_signs_of_orientations() -> None:
    half = 0.5 * np.array([0.0, 1e-9, 0.1, 3.0])
    turned = np.column_stack([np.cos(half), 0 * half, np.sin(half), 0 * half])
    still = np.tile([1.0, 0, 0, 0], (4, 1))
    np.testing.assert_allclose(angle_between(still, -turned), 2 * half, rtol=1e-7, atol=1e-16)
    flipped = turned * np.array([[1.0], [-1], [-1], [1]])
    np.testing.assert_allclose(unit_quaternions(3.0 * flipped), turned, atol=1e-15)
    assert np.isnan(unit_quaternions(np.zeros((1, 4)))).all()
