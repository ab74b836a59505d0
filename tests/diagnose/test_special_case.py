"""Whether a special case of a law says as much as the law, on the bundled demo (synthetic)."""

import pytest
from demo_problem import demo_problem, planted, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.round import MUCH
from realitygap.diagnose.search.special_case import no_more


@pytest.mark.parametrize(("forward", "backward", "says_more"), [(0.30, 0.46, True), (1.46, 1.54, False)])
def test_a_law_says_more_where_another_friction_is_larger(forward: float, backward: float, says_more: bool) -> None:
    """All friction of a joint with much viscous friction may be off by more than its dry friction by side does."""
    bare = demo_problem()
    sides, dry, oil = (
        guess(bare, suspect_of(bare, effect, "elbow"))
        for effect in ("direction_friction", "coulomb_friction", "viscous_friction")
    )
    sides, oil = sides.at({"forward": forward, "backward": backward}), oil.at({"coefficient": 6.0})
    problem = planted(sides, oil)
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [sides, oil])
        fits = [criterion.fit(c) for c in ([sides, oil], [dry, oil], [oil])]
        assert all(fits)
        law, special, without = (f for f in fits if f is not None)
        criterion.set_discrepancy(law.fit, criterion.responses(law.fit, suspects(problem)))
        law, special, without = (criterion.score(f.fit) for f in (law, special, without))
    ahead = law.evidence - special.evidence
    assert ahead > 0.0
    assert criterion.alike(law.fit, special.fit, sides.suspect)
    limits = (0.9 * ahead / MUCH, 1.1 * ahead / MUCH)
    told = [no_more(criterion, law, special, sides.suspect, without, limit) for limit in limits]
    assert told == [not says_more, True], "of much evidence, what the law itself does counts"
    assert no_more(criterion, law, special, sides.suspect, None, limits[0]), "nobody knows what it does"
