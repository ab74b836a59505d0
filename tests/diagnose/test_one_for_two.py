"""One finding takes the place of two of the same law there, on recordings of the bundled demo (synthetic)."""

from realitygap.diagnose.data.changes import model_key
from realitygap.diagnose.search.grow import grown
from realitygap.diagnose.search.one_for_two import one_for_two
from stood import Effects, stood


def test_an_inertia_is_not_a_mass_and_another_centre_of_it() -> None:
    missing: Effects = {("link_inertia", "forearm"): {"scale": 2.5}}
    wrong: Effects = {
        ("link_mass", "forearm"): {"mass": 0.6},
        ("center_of_mass", "forearm"): {"x": 0.0, "y": 0.0, "z": -0.12},
        ("viscous_friction", "shoulder"): {"coefficient": 0.01},
    }
    at = stood(missing, wrong, [])
    with at.simulations:
        ways = one_for_two(at.round_)
        better = grown(at.round_, [], set(), again=True, ways=ways)
    effects = [{c.suspect.effect for c in way} for way, _ in ways]
    assert {"link_inertia", "viscous_friction"} in effects
    assert all("viscous_friction" in of for of in effects), "a friction is of another law"
    assert all(needs < 0.0 for _, needs in ways), "with a finding less it may lose what that had to gain"
    assert better is not None
    assert at.right <= model_key(better.fit.changes)
    assert len(better.fit.changes) < len(at.round_.now.fit.changes)
