"""The terms of a missing effort are the functions that were planted, each with its share; nothing is simulated."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from realitygap.missing.effort import MissingEffort
from realitygap.missing.shape import Term, samples_of, shape_of
from realitygap.missing.splines import Spline
from realitygap.missing.words import sentence
from realitygap.trace.trace import Array

TIME = np.arange(0.0, 10.0, 0.01)


def told(law: Callable[[Array, Array], Array], *, slides: bool = False, error: float = 0.005) -> list[MissingEffort]:
    """Four recordings in which angle and speed are independent, and what an effort of both is measured as."""
    runs = []
    for k in range(4):
        rng = np.random.default_rng(k)
        rate, phase = rng.uniform(0.5, 4.0, 5), rng.uniform(0.0, 6.0, 5)
        angle = np.sin(np.outer(TIME, rate) + phase).sum(1) / 2
        speed = np.cos(np.outer(TIME, rate) + phase) @ rate / 2
        effort = law(angle, speed) + error * rng.normal(size=len(TIME))
        variables = {"angle": angle[:, None], "speed": speed[:, None]}
        runs.append(
            MissingEffort(
                str(k),
                "mujoco",
                None,
                ("joint0",),
                (slides,),
                TIME,
                effort[:, None],
                0 * angle[:, None] + error,
                variables,
            )
        )
    return runs


def values_of(term: Term, columns: dict[str, Array]) -> Array:
    spline = Spline(term.variables, tuple(np.array(row) for row in term.knots))
    return np.asarray(spline.design(columns) @ np.array(term.values))


@pytest.mark.parametrize("drag", [-0.05, -0.4])
def test_a_sum_of_two_is_told_as_two_with_the_mean_once_the_larger_first(drag: float) -> None:
    def law(angle: Array, speed: Array) -> Array:
        return np.asarray(0.7 + 0.3 * np.sin(3.0 * angle) + drag * speed)

    runs = told(law)
    shape = shape_of(runs, "joint0")
    columns = {v: np.concatenate([r.variables[v][:, 0] for r in runs]) for v in ("angle", "speed")}
    effort = np.concatenate([r.effort[:, 0] for r in runs])
    own = {"angle": np.var(0.3 * np.sin(3.0 * columns["angle"])), "speed": np.var(drag * columns["speed"])}
    assert [t.variables[0] for t in shape.terms] == sorted(own, key=lambda v: -float(own[v]))
    for term in shape.terms:
        assert term.share == pytest.approx(own[term.variables[0]] / np.var(effort), abs=0.03)
    assert sum(t.share for t in shape.terms) == pytest.approx(shape.share)
    assert shape.size == pytest.approx(np.sqrt(np.mean(effort**2)))
    assert shape.mean == pytest.approx(np.mean(effort), abs=1e-3)
    found = [values_of(t, columns) for t in shape.terms]
    inside = np.abs(columns["speed"]) < np.quantile(np.abs(columns["speed"]), 0.95)
    off = (sum(found) - law(columns["angle"], columns["speed"]))[inside]
    assert np.sqrt(np.mean(off**2)) < 0.02
    assert sorted(abs(float(np.mean(f))) for f in found)[0] < 0.03, "one of the two has the mean"


def test_a_sliders_is_in_newtons_and_a_constant_one_is_told_with_its_sign() -> None:
    runs = told(lambda angle, _: np.full_like(angle, -0.7), slides=True)
    shape = shape_of(runs, "joint0")
    assert shape.unit == "N"
    assert not shape.terms
    assert sentence(shape).endswith("(0.7 N rms) is -0.7 N in the mean, and depends on nothing that was looked at")
    assert sentence(replace(shape, mean=0.3)).endswith("(0.7 N rms) depends on nothing that was looked at")
    assert sentence(replace(shape, within=0.89)) == sentence(shape)
    assert sentence(replace(shape, within=0.91)).endswith("(0.7 N rms) is no more than its band leaves open")
    assert shape_of(told(lambda angle, _: np.full_like(angle, 0.7)), "joint0").unit == "N·m"


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_how_often_the_band_holds_nothing(sign: float) -> None:
    """Of white noise of the band's own size in 95 of 100 cases, and never where it is beyond, on either side."""
    noise = shape_of(told(lambda angle, _: 0 * angle), "joint0")
    far = shape_of(told(lambda angle, _: np.full_like(angle, 0.1 * sign)), "joint0")
    assert noise.within == pytest.approx(0.95, abs=0.02)
    assert noise.noise == pytest.approx(1.0, abs=0.1)
    assert far.within == 0.0


def test_what_is_told_surely_counts_more_and_at_most_ten_times() -> None:
    """Half of the samples are three times as sure; where all are exact, all count alike."""
    runs = [replace(r, error=np.where(TIME[:, None] < 5.0, 0.1, 0.3)) for r in told(lambda a, _: 0.2 * a)]
    samples, _, noise = samples_of(runs, "joint0")
    variance = float(np.var(np.concatenate([r.effort for r in runs])))
    ratio = samples.weight.max() / samples.weight.min()
    assert ratio == pytest.approx((0.09 + 0.1 * variance) / (0.01 + 0.1 * variance), rel=0.02)
    assert noise == pytest.approx(1.0)
    exact, *_ = samples_of([replace(r, error=0 * r.error) for r in runs], "joint0")
    np.testing.assert_allclose(exact.weight, 1.0)


def test_where_no_sample_is_a_function_stays_within_what_was_seen() -> None:
    """A product of two that go round in an ellipse has 0.15 N·m at most, and in the corners nobody was 0.3."""
    runs = []
    for k, run in enumerate(told(lambda a, _: 0 * a)):
        turn, size = (2.0 + 0.1 * k) * TIME[:, None], np.linspace(0.2, 1.0, len(TIME))[:, None]
        angle, speed = size * np.sin(turn), size * np.cos(turn)
        runs.append(replace(run, effort=run.effort + 0.3 * angle * speed, variables={"angle": angle, "speed": speed}))
    (term,) = shape_of(runs, "joint0").terms
    assert term.variables == ("angle", "speed")
    assert 0.13 < np.abs(term.values).max() < 0.18


BENDS: dict[str, Callable[[Array], Array]] = {
    "a spring": lambda a: 0.2 * a,
    "an arc": lambda a: 0.2 * a**2,
    "an S": lambda a: 0.2 * a**3,
    "a sine of one period": lambda a: 0.2 * np.cos(2.0 * a),
    "a corner": lambda a: 0.2 * np.abs(a),
    "a jump": lambda a: 0.2 * np.tanh(5.0 * a),
}


@pytest.mark.parametrize("name", BENDS)
def test_a_bend_has_no_periods_however_noisy_it_is(name: str) -> None:
    for error in (0.005, 0.05):
        (term,) = shape_of(told(lambda a, _: BENDS[name](a), error=error), "joint0").terms
        assert term.variables == ("angle",)
        assert term.periods is None


@pytest.mark.parametrize(("size", "periods"), [(0.2, 6.0), (0.2, 40.0), (0.05, 14.0)])
def test_a_ripple_has_its_periods_also_beside_a_spring(size: float, periods: float) -> None:
    (term,) = shape_of(told(lambda a, _: size * np.sin(periods * a) + 0.3 * a), "joint0").terms
    assert term.periods == pytest.approx(periods, abs=0.1)


def test_of_many_recordings_repetitions_are_left_out_together_and_of_few_blocks_of_time() -> None:
    one = told(lambda a, _: 0.2 * a)[0]
    always = replace(one, variables=one.variables | {"speed": np.ones((len(TIME), 1))})
    fold = samples_of([always] * 16, "joint0")[0].fold
    assert list(fold.reshape(16, -1)[:, 0]) == [k // 2 for k in range(16)]
    for count in (1, 3):
        fold = samples_of([always] * count, "joint0")[0].fold.reshape(count, -1)
        for k in range(count):
            np.testing.assert_array_equal(fold[k], (np.floor(TIME) + k) % 5)


def test_a_joint_is_fitted_where_it_moves_unless_it_hardly_ever_does() -> None:
    moving, resting = list[MissingEffort](), list[MissingEffort]()
    for run in told(lambda a, _: 0.2 * a):
        speed = run.variables["speed"]
        for share, runs in ((0.5, moving), (0.05, resting)):
            slow = np.where(TIME[:, None] < 10.0 * share, speed, 0.0)
            runs.append(replace(run, variables=run.variables | {"speed": slow}))
    assert len(samples_of(moving, "joint0")[0].effort) == pytest.approx(0.5 * 4 * len(TIME), rel=0.05)
    assert len(samples_of(resting, "joint0")[0].effort) == 4 * len(TIME)
