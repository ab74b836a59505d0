"""Units that a scenario states, or should: what is in another one, and the key that mends it in that kind of file."""

import sys
from pathlib import Path

import pytest
from realitygap.check import check
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from teams import Team, demo


@pytest.fixture(scope="module")
def team() -> Team:
    return demo()


@pytest.mark.parametrize(("signal", "other"), [("position", "command"), ("command", "position")])
def test_a_unit_that_is_stated_and_wrong_is_told_beside_the_other(
    signal: str, other: str, team: Team, tmp_path: Path
) -> None:
    file = load_scenario(team.write(tmp_path))
    found = check(file.override({f"recordings.columns.units.{signal}": "deg"}))
    assert {(m.kind, m.joints) for m in found} == {("degrees", ("shoulder",)), ("degrees", ("elbow",))}
    for m in found:
        assert m.sentence.endswith(
            f": the {signal} is in rad and not in deg, as its unit is stated, or the {other} is in deg, too; expected "
            f"both in rad: remove the {signal}'s unit from `units` under recordings.columns, or add `{other}: deg`"
        )
    assert check(file) == []
