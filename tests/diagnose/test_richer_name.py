"""A name that says more of the same law than another one needs what every name does, whichever was found first."""

from types import SimpleNamespace
from typing import cast

import pytest
from demo_problem import suspect_of
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.search import exchange
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.rivals import Rival
from realitygap.diagnose.search.round import Round

LIMIT = 6.0


@pytest.mark.parametrize(("more", "needed"), [(4.5, False), (7.5, True)])
def test_it_needs_what_every_name_needs(problem: Problem, more: float, needed: bool) -> None:
    less, best = (cast("Scored", SimpleNamespace(evidence=e, fit=None)) for e in (-more, 0.0))
    laws = SimpleNamespace(alike=lambda *_: False)  # are off by less than that
    round_ = cast(
        "Round",
        SimpleNamespace(
            limit=LIMIT,
            criterion=laws,
            simulations=SimpleNamespace(problem=problem),
            little=lambda _: 0.0,
        ),
    )
    dry, sides = (suspect_of(problem, e, "elbow") for e in ("coulomb_friction", "direction_friction"))
    plain, rich = Rival(dry, less, more, 0.0), Rival(sides, best, -more, 0.0)
    round_.now = best
    assert exchange._plainer(round_, plain, sides, less) != needed
    round_.now = less
    assert exchange._gains(round_, rich, dry, less) == needed
