"""What mends one engine is no finding, nor is what a search puts in its place for the same reason."""

import sys
from collections.abc import Mapping

import pytest
from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.gaps import Shown, artefacts
from realitygap.diagnose.result.workflow import diagnose
from realitygap.diagnose.search_budget import SearchBudget

FRICTION = Suspect("coulomb_friction", "elbow", (1,))


@pytest.mark.parametrize(
    ("elsewhere", "artefact"),
    [
        ([(10.0, 9.9)], True),
        ([(10.0, 1.2)], False),
        ([(10.0, 7.2)], True),
        ([(10.0, 6.9)], False),  # half of the square, which is 99
        ([(10.0, 9.9), (10.0, 1.2)], False),
        ([(10.0, 9.9), (10.0, 12.0)], True),
        ([], False),
    ],
)
def test_what_helps_in_the_searching_engine_alone_mends_that_engine(
    elsewhere: list[tuple[float, float]], artefact: bool
) -> None:
    others = {f"other{i}": gaps for i, gaps in enumerate(elsewhere)}
    assert artefacts({FRICTION: Shown(10.0, 1.0, others)}) == [FRICTION] * artefact
    assert not artefacts({FRICTION: Shown(1.0, 10.0, others)}), "what helps nowhere is told otherwise"
    assert not artefacts({FRICTION: Shown(1.0, 2.0, {"dart": (1.0, 30.0)})})


def test_what_is_found_in_its_place_is_asked_as_well(simulations: Simulations, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[list[Suspect]] = []

    def twice(proofs: Mapping[Suspect, Shown]) -> list[Suspect]:
        asked.append(list(proofs))
        return asked[-1][:1] if len(asked) < 3 else []

    monkeypatch.setattr(sys.modules[diagnose.__module__], "artefacts", twice)
    found = diagnose(simulations, ["mujoco"], budget=SearchBudget(steps=1.0))
    first, second = asked[0][0], asked[1][0]
    assert first != second
    assert not {first, second} & {c.suspect for c in found.changes}
    assert sum("mends that engine" in note for note in found.notes) == 2
