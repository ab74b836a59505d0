"""The evidence: its closed form, and the scale of the discrepancy that it finds in laws whose faults are known."""

from dataclasses import replace

import numpy as np
import pytest
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.space import SLAB
from realitygap.diagnose.likelihood.whitening import Channel
from realitygap.diagnose.search.discrepancy import Accepted, Discrepancy
from realitygap.diagnose.search.evidence import SHARP, Scored, cautious, log_prior, score, sharp

NOISE = 0.5


def scored(residual: np.ndarray, slope: np.ndarray, responses: np.ndarray, laws: tuple[str, ...]) -> Scored:
    """The evidence of a model with fitted values, none of which its prior minds, on one channel of white noise."""
    n, p = slope.shape
    channel = Channel(0, "position", 0, 0.01 * np.arange(n, dtype=np.float64), NOISE, np.zeros(n))
    names = tuple((k, "torque") for k in range(p))
    fit = Fit((), residual, names, slope, np.ones(p), np.zeros(p))
    return score([channel], fit, Discrepancy(np.ones(1), responses, laws))


def test_the_evidence_is_the_marginal_likelihood() -> None:
    """At the fit: of noise, values with a normal prior and laws that are off, by the matrices themselves."""
    rng = np.random.default_rng(3)
    n, laws = 60, ("friction", "friction", "drive")
    slope, responses = rng.standard_normal((n, 2)), rng.standard_normal((n, 3))
    residual = 0.3 * rng.standard_normal(n)  # below the noise: there is no rest
    got = scored(residual, slope, responses, laws)
    each = np.array([got.discrepancy_scale[law] for law in laws])
    dense = np.diag(NOISE**2 / got.metric.weight) + (responses * each**2) @ responses.T
    inside = np.eye(2) + SLAB**2 * slope.T @ np.linalg.solve(dense, slope)
    expected = -0.5 * residual @ np.linalg.solve(dense, residual) - 0.5 * np.linalg.slogdet(dense)[1]
    expected += -0.5 * np.linalg.slogdet(inside)[1] + log_prior(got.discrepancy_scale)
    assert got.evidence == pytest.approx(expected)


@pytest.mark.parametrize("off", [0.5, 2.0])
def test_each_kind_of_law_has_the_discrepancy_that_the_recordings_say(off: float) -> None:
    """Friction is off by what is planted, the drive by as much less."""
    rng = np.random.default_rng(8)
    n, q = 4000, 40
    responses = rng.standard_normal((n, 2 * q))
    true = np.concatenate([off * rng.standard_normal(q), rng.standard_normal(q) / off])
    laws = ("friction",) * q + ("drive",) * q
    residual = NOISE * rng.standard_normal(n) + responses @ true
    assert scored(residual, np.zeros((n, 0)), responses, laws).discrepancy_scale == {
        "friction": off,
        "drive": 1.0 / off,
    }


def test_the_laws_of_a_machine_are_alike() -> None:
    """A fault of a drive of 2.5 ordinary ones passes for one where nothing is known of other laws, and not where the
    recordings say that friction, in all that it does, has an eighth of the ordinary discrepancy.
    """
    rng = np.random.default_rng(8)
    n, q = 4000, 40
    friction, drive = 0.5 * rng.standard_normal((n, q)), 0.1 * rng.standard_normal((n, 1))
    fault = 2.5 * drive[:, 0]
    residual = NOISE * rng.standard_normal(n) + friction @ (0.125 * rng.standard_normal(q)) + fault

    def gained(responses: np.ndarray, laws: tuple[str, ...]) -> tuple[float, float]:
        """The scale of the drive's discrepancy, and what the effect that is its fault gains."""
        without = scored(residual, np.zeros((n, 0)), responses, laws)
        named = scored(residual - fault, drive, responses, laws)
        return without.discrepancy_scale["drive"], named.evidence - without.evidence

    alone, beside = gained(drive, ("drive",)), gained(np.hstack([friction, drive]), ("friction",) * q + ("drive",))
    assert (alone[0], beside[0]) == (2.0, 1.0)
    assert beside[1] > alone[1] + 3.0


def test_a_load_that_is_known_worse_than_a_drawing_has_it_has_to_be_earned() -> None:
    """The same recordings take friction for twice as far off as it is, and what a link weighs not."""
    rng = np.random.default_rng(8)
    n, q = 4000, 2
    responses = rng.standard_normal((n, q))
    residual = NOISE * rng.standard_normal(n) + responses @ np.full(q, 1.5)
    told = {
        law: scored(residual, np.zeros((n, 0)), responses, (law,) * q).discrepancy_scale[law]
        for law in ("friction", "load")
    }
    assert told == {"friction": 2.0, "load": 1.0}
    far = responses @ np.full(q, 6.0)
    assert scored(
        NOISE * rng.standard_normal(n) + far, np.zeros((n, 0)), responses, ("load",) * q
    ).discrepancy_scale == {"load": 2.0}


def test_laws_are_no_worse_than_the_larger_model_says() -> None:
    """A model that lacks dry friction calls its laws poor, which would pass for the friction that it lacks."""
    rng = np.random.default_rng(5)
    n, q = 4000, 20
    responses = rng.standard_normal((n, q))
    missing = 2.0 * responses[:, :3].sum(axis=1)
    residual = NOISE * rng.standard_normal(n) + 0.3 * responses @ rng.standard_normal(q) + missing
    channel = Channel(0, "position", 0, 0.01 * np.arange(n, dtype=np.float64), NOISE, np.zeros(n))
    discrepancy = Discrepancy(np.ones(1), responses, ("friction",) * q)
    free, bound = (
        score([channel], Fit((), residual), w)
        for w in (discrepancy, replace(discrepancy, most={"friction": 0.5, "drive": 1.0}))
    )
    assert free.discrepancy_scale == {"friction": 1.0}
    assert bound.discrepancy_scale == {"friction": 0.5}
    assert bound.evidence < free.evidence
    assert sharp([channel], Fit((), residual), discrepancy).discrepancy_scale == {"friction": SHARP}


def test_of_a_stop_on_the_other_side_alone_no_discrepancy_is_left() -> None:
    upper = Suspect("joint_stop", "elbow", (1,))
    values = (("lower", -0.3), ("upper", np.inf), ("stiffness", 5.0))
    discrepancy = Discrepancy(
        np.ones(1),
        np.ones((4, 2)),
        ("", ""),
        (Accepted(0, upper, "upper", 0.5, 0.0), Accepted(1, upper, "stiffness", 2.0, 0.0)),
    )
    assert discrepancy.shares(Fit((Change(upper, values, ("lower", "stiffness")),), np.zeros(4))).tolist() == [0.0, 2.5]


def test_moves_are_looked_for_where_laws_are_better_than_a_machines() -> None:
    rng = np.random.default_rng(9)
    channel = Channel(0, "position", 0, 0.01 * np.arange(50, dtype=np.float64), NOISE, np.zeros(50))
    discrepancy = Discrepancy(np.ones(1), rng.standard_normal((50, 2)), ("friction", "load"))
    assert set(sharp([channel], Fit((), rng.standard_normal(50)), discrepancy).discrepancy_scale.values()) == {SHARP}


def test_what_laws_are_off_by_is_in_the_intervals_of_values_that_were_fitted_as_if_they_were_exact() -> None:
    """A fault of the law looks much like the value: it draws least squares four times as far as noise does."""
    rng = np.random.default_rng(12)
    n, trials, held = 400, 300, 0
    slope = rng.standard_normal((n, 1))
    off = 0.1 * (slope + rng.standard_normal((n, 1)))  # 0.1 of the value in one standard deviation of its law
    channel = Channel(0, "position", 0, 1.1 * np.arange(n, dtype=np.float64), NOISE, np.zeros(n))
    widest = 0.0
    for _ in range(trials):
        residual = NOISE * rng.standard_normal(n) + off @ rng.standard_normal(1)
        value = -float(np.linalg.lstsq(slope, residual)[0][0])
        fit = Fit((), residual + slope[:, 0] * value, ((0, "torque"),), slope, np.ones(1), np.zeros(1))
        (deviation,) = cautious([channel], fit, Discrepancy(np.ones(1), off, ("friction",))).deviation
        held += abs(value) < 1.96 * deviation
        widest = max(widest, deviation)
    assert held / trials > 0.9
    assert widest < 0.4
