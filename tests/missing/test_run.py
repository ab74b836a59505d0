"""`run --missing-effort`: the missing effort lies in the traces, on the page, and as effects that a scenario takes."""

from pathlib import Path

import numpy as np
import pytest
import realitygap as rg
import yaml
from realitygap.cli import results
from realitygap.files.progress import Progress
from realitygap.missing.files import NAME
from realitygap.report import write_page
from realitygap.trace.parquet import read_parquet
from rosbags.highlevel import AnyReader

SCENARIO = Path(__file__).parents[2] / "scenarios" / "effort_driven" / "scenario.yaml"
"""Its pendulum's elbow has 0.1 N·m more dry friction than the model."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("missing") / "out"
    said, _ = results.run(SCENARIO, ["mujoco"], out, {}, None, Progress(quiet=True), missing=True)
    assert any("missing effort at elbow" in line and "depends on the speed" in line for line in said)
    return out


def test_it_is_in_the_traces_beside_what_was_simulated_and_measured(folder: Path) -> None:
    paths = sorted((folder / "traces").glob("*.parquet"))
    assert len(paths) == 2
    for path in paths:
        found = read_parquet(path)
        (name,) = [n for n in found if n.startswith(NAME)]
        assert set(found) == {"simulated", "measured", name}
        trace = found[name]
        assert trace.effort is not None
        assert trace.effort_error is not None
        assert trace.velocity is not None
        fast = np.abs(trace.velocity[:, 1]) > 0.5
        miss = trace.effort[fast, 1] + 0.1 * np.sign(trace.velocity[fast, 1])
        assert np.mean(np.abs(miss) < 1.96 * trace.effort_error[fast, 1]) >= 0.9
        with AnyReader([path.with_suffix(".mcap")]) as reader:
            topics = set(reader.topics)
        assert {"/missing_effort/joint_states", "/missing_effort/low/joint_states"} <= topics


def test_the_page_shows_it_and_is_made_from_the_folder_alone(folder: Path) -> None:
    page = (folder / "report.html").read_text()
    assert "The missing effort at elbow" in page
    assert page.count("data:image/svg+xml;base64,") == 2
    assert (folder / "figures" / "missing-effort-elbow.svg").is_file()
    assert write_page(folder).read_text() == page
    figure = (folder / "figures" / "missing-effort-elbow.svg").read_text(encoding="utf-8")
    for named in ("fitted function of the speed", "median, moving forward", "median, moving backward"):
        assert figure.count(f">{named}<") == 1, "its legend names every curve once"
    assert "fitted function" not in (folder / "figures" / "missing-effort-shoulder.svg").read_text(encoding="utf-8")


def test_its_effects_close_the_gap_where_they_were_not_fitted(folder: Path) -> None:
    told = yaml.safe_load((folder / "missing_effort.yaml").read_text())
    assert [e["target"] for e in told["effects"]] == ["elbow"]
    scenario = rg.load_scenario(SCENARIO)
    gaps = []
    for one in (scenario, scenario.override(told)):
        table = rg.compare(one, ["mujoco"], floors=False).gaps
        held_out = table[(table["use"] == "held_out") & (table["signal"] == "position") & (table["joint"] == "elbow")]
        gaps.append(float(held_out["mean_abs"].iloc[0]))
    assert gaps[1] < 0.3 * gaps[0]


def test_the_library_tells_the_same() -> None:
    found = rg.missing_effort(SCENARIO, runs="sines")
    assert found.shape("elbow").terms[0].variables == ("speed",)
    with pytest.raises(rg.InputError, match=r"joint: found elbo; expected .*elbow; did you mean elbow\?"):
        found.shape("elbo")
    assert found.runs[0].slides == (False, False)
    frame = found.to_frame()
    assert set(frame["joint"]) == {"shoulder", "elbow"}
    assert {"effort", "effort_error", "angle", "speed", "load", "reversal"} <= set(frame)
    assert "error" not in frame, "its commands are efforts, and no position is commanded"


def test_it_is_told_on_the_recordings_clock_within_the_window() -> None:
    """Of a part that begins after a second, what is judged: the same efforts at the same times."""
    runs = [{"path": "sines.csv", "use": "train"}]
    whole, part = (
        rg.missing_effort(rg.load_scenario(SCENARIO).override({"recordings.runs": [runs[0] | own]})).runs[0]
        for own in ({}, {"part": [1.0, 4.5], "window": [2.0, 4.0]})
    )
    assert (part.time.min(), part.time.max()) == pytest.approx((2.0, 4.0), abs=0.011)
    inside = (whole.time > part.time[0] - 1e-6) & (whole.time < part.time[-1] + 1e-6)
    np.testing.assert_allclose(part.time, whole.time[inside], rtol=0, atol=1e-9)
    np.testing.assert_allclose(part.variables["angle"], whole.variables["angle"][inside], atol=1e-3)
    assert np.median(np.abs(part.effort - whole.effort[inside]), axis=0) == pytest.approx([0.0, 0.0], abs=5e-3)
