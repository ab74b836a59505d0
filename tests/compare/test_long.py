"""A motion that is too long to be kept has the gaps that it has, and traces that people can look at."""

from pathlib import Path

import numpy as np
import pytest
from realitygap.compare import comparison, size
from realitygap.compare.comparison import RepeatedMotion, compare, motions_of, whole_size
from realitygap.compare.row import slug
from realitygap.compare.table import table, to_csv
from realitygap.compare.traces import read_traces, write_traces
from realitygap.report.curves import boxes
from realitygap.scenario.file import load_scenario

DEMO = Path(__file__).parents[2] / "scenarios" / "demo" / "scenario.yaml"


@pytest.fixture(scope="module")
def motions() -> list[RepeatedMotion]:
    found = motions_of(load_scenario(DEMO))
    return [next(m for m in found if (len(m.experiments) > 1) == repeated) for repeated in (False, True)]


@pytest.mark.parametrize("repeated", [False, True])
def test_its_gaps_are_those_of_the_whole(
    repeated: bool, motions: list[RepeatedMotion], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    motion = motions[repeated]
    model = motion.experiments[0].plant.model
    whole = compare(motion, "mujoco")
    monkeypatch.setattr(comparison, "WHOLE", 0.0)
    monkeypatch.setattr(size, "WHOLE", 0.0)
    monkeypatch.setattr(size, "THIN", whole_size(motion) / 20)
    thin = compare(motion, "mujoco")
    assert to_csv(table(thin.rows)) == to_csv(table(whole.rows))
    files = {}
    for name, done in (("whole", whole), ("thin", thin)):
        write_traces(tmp_path / name, done, model)
        files[name] = tmp_path / name / "traces" / f"{slug(done.cell)}.parquet"
    assert files["thin"].stat().st_size < 0.2 * files["whole"].stat().st_size
    shown, full = read_traces(files["thin"]), read_traces(files["whole"])
    assert boxes(shown) == boxes(full) != {}
    assert shown.measured is not None
    ours, theirs = shown.simulated.position, full.simulated.at(shown.measured.time).position
    assert ours is not None
    assert theirs is not None
    np.testing.assert_allclose(ours, theirs, atol=1e-12)
    assert "thinned" in (size.told([motion], whole=False) or "")
    assert size.told([motion], whole=True) is not None


def test_an_ordinary_motion_is_kept_whole(motions: list[RepeatedMotion]) -> None:
    assert all(whole_size(m) < comparison.WHOLE for m in motions)
    assert size.told(motions, whole=False) is None
