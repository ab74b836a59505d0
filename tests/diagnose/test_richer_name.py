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
MODEL = cast("Scored", SimpleNamespace())


@pytest.mark.parametrize(("more", "needed"), [(4.5, False), (7.5, True)])
def test_it_needs_what_every_name_needs(
    problem: Problem, monkeypatch: pytest.MonkeyPatch, more: float, needed: bool
) -> None:
    monkeypatch.setattr(exchange, "no_more", lambda *_: False)  # laws are off by less than that
    round_ = cast(
        "Round",
        SimpleNamespace(
            limit=LIMIT,
            now=MODEL,
            criterion=None,
            simulations=SimpleNamespace(problem=problem),
            little=lambda _: 0.0,
        ),
    )
    dry, sides = (suspect_of(problem, e, "elbow") for e in ("coulomb_friction", "direction_friction"))
    plain, rich = Rival(dry, MODEL, more, 0.0), Rival(sides, MODEL, -more, 0.0)
    assert exchange._plainer(round_, plain, sides, MODEL) != needed
    assert exchange._gains(round_, rich, dry, MODEL) == needed
