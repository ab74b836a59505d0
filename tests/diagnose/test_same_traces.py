"""What makes the same traces is told, however unlikely it was beforehand (recordings of the demo, synthetic)."""

import numpy as np
import pytest
from demo_problem import demo_problem, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.fit.space import SLAB, Space, negative_log_prior
from realitygap.diagnose.result.diagnosis import why
from realitygap.diagnose.search.exchange import Exchanged, exchanged
from realitygap.diagnose.search.rivals import ODDS
from realitygap.diagnose.search.simpler import narrower, says_otherwise
from stood import Effects, stood


def test_a_zero_that_is_off_and_a_turned_centre_of_mass_are_not_told_apart() -> None:
    """Of the last link of an arm: gravity turns, whichever of both it is."""
    missing: Effects = {("joint_offset", "elbow"): {"angle": 0.5}}
    at = stood(missing, missing, [("center_of_mass", "forearm"), ("viscous_friction", "shoulder")])
    with at.simulations:
        out = exchanged(at.round_, [], Exchanged())
    assert out.better is None
    (rival,) = (r for of in out.rivals.values() for r in of if r.suspect.effect == "center_of_mass")
    assert rival.same
    assert rival.open
    assert rival.behind > ODDS, "evidence alone would not tell it"
    assert "the same traces" in why(rival)


@pytest.mark.parametrize(
    ("effect", "target", "richer", "told"),
    [
        ("link_mass", "forearm", "payload", True),
        ("link_mass", "forearm", "center_of_mass", True),
        ("coulomb_friction", "elbow", "direction_friction", False),
        ("coulomb_friction", "elbow", "stribeck_friction", False),
    ],
)
def test_what_a_richer_law_says_in_other_words_is_nothing_else(
    effect: str, target: str, richer: str, told: bool
) -> None:
    """A load in the middle of a link, and a heavier link, are two things; equal friction by side is dry friction."""
    problem = demo_problem()
    finding, law = suspect_of(problem, effect, target), suspect_of(problem, richer, target)
    assert narrower(finding, law)
    assert says_otherwise(finding, law) is not told
    assert not says_otherwise(law, finding)


@pytest.mark.parametrize(("name", "target", "values"), [("joint_offset", "elbow", {"angle": 0.1})])
def test_a_prior_is_the_square_of_its_residual(name: str, target: str, values: dict[str, float]) -> None:
    """Which `prior_slope` is the derivative of, far out and at its mode, also of what is there and positive."""
    problem = demo_problem()
    offset = guess(problem, suspect_of(problem, name, target)).at(values)
    mass = guess(problem, suspect_of(problem, "link_mass", "forearm"))
    space = Space(problem, [offset, mass])
    for times in (0.0, 1e-7, 0.1, 1.0, 30.0):
        x = space.expected * (1.0 + 0.05 * times) + times * np.array([1.0, 0.0])
        moved = [space.prior(x + 1e-6 * e) - space.prior(x - 1e-6 * e) for e in np.eye(2)]
        assert space.prior_slope(x) == pytest.approx(np.diag(moved) / 2e-6, rel=1e-4)
        assert 0.5 * space.prior(x)[0] ** 2 == pytest.approx(float(negative_log_prior(np.array(times / SLAB))))


def test_what_is_far_wrong_is_not_ruled_out_beforehand() -> None:
    """A horn two teeth off costs less than a name has to gain; what is near costs what it does of a normal prior, and
    all that could be has a probability.
    """
    far = np.array([0.5 / 0.02 / SLAB])
    assert float(negative_log_prior(far)[0]) < 5.0 < 0.5 * far[0] ** 2
    near = np.linspace(-1.5, 1.5, 7)
    assert negative_log_prior(near) == pytest.approx(0.5 * near**2)
    ends = np.array([1e2, 1e4, 1e6])
    assert (np.diff(negative_log_prior(ends)) > np.diff(np.log(ends))).all(), (
        "what lies beyond has a finite probability"
    )
