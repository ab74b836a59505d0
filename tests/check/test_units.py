"""Units that a scenario states, or should: what is in another one, and the key that mends it in that kind of file."""

import sys
from pathlib import Path

import numpy as np
import pytest
from realitygap.check import check
from realitygap.check.observed import observe
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from spoil import scaled
from teams import DEMO, Team, demo


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


def in_bags(team: Team, factor: dict[str, float]) -> Team:
    """The same in bags, with signals of the elbow in another unit."""
    out = team.copy()
    for table in out.tables.values():
        table.command_time = table.time.copy()
        for signal, times in factor.items():
            getattr(table, signal)[:, 1] *= times
    return out


@pytest.mark.parametrize("signals", [("position",), ("command",), ("velocity",), ("position", "velocity", "command")])
def test_degrees_in_a_bag_are_told_with_the_unit_that_mends_them(
    signals: tuple[str, ...], team: Team, tmp_path: Path
) -> None:
    spoilt = in_bags(team, dict.fromkeys(signals, 180 / np.pi))
    file = load_scenario(spoilt.write(tmp_path))
    (found,) = check(file)
    told = signals[0]
    assert (found.kind, found.joints, found.certainty) == ("degrees", ("elbow",), "certain")
    assert found.sentence.endswith(f", or `units: {{{told}: deg}}` under recordings.columns")
    unit = {"elbow": "deg", "*": "rad"}
    mended = file.override({"recordings.columns.units": dict.fromkeys(signals, unit)})
    assert check(mended) == []
    for o, whole in zip(observe(mended), observe(load_scenario(DEMO)), strict=True):
        for signal in ("position", "velocity", "command"):
            np.testing.assert_allclose(getattr(o.recording.trace, signal), getattr(whole.recording.trace, signal))


def test_a_velocity_in_revolutions_per_minute_is_told_with_the_unit_that_says_so(team: Team, tmp_path: Path) -> None:
    wrong = team.copy()
    scaled("velocity", 60 / (2 * np.pi))(wrong, 1)
    file = load_scenario(wrong.write(tmp_path))
    (found,) = check(file)
    assert (found.kind, found.certainty, found.joints) == ("velocity", "likely", ("elbow",))
    assert found.sentence.endswith("told by `units: {velocity: rpm}` under recordings.columns")
    assert check(file.override({"recordings.columns.units": {"velocity": {"elbow": "rpm", "*": "rad"}}})) == []
