"""The page and its parts as files: a pure function of the result folder."""

import errno
import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import synthetic
from realitygap.cli.main import app
from realitygap.compare.traces import read_traces
from realitygap.files.errors import InputError
from realitygap.page.style import number
from realitygap.report import remake, write_figures, write_page
from realitygap.report.curves import read_curves, unpack, write_curves
from realitygap.report.folder import read_folder
from realitygap.report.payload import payload
from realitygap.report.spread import spread
from realitygap.report.thesis import grounds, improvements
from realitygap.trace.trace import Trace
from signals import there
from synthetic_tosses import write_tosses
from typer.testing import CliRunner

JOINTS = ("hip", "knee", "ankle", "toe")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    cells = synthetic.grid(engine=["mujoco", "drake"], robot_revision=["old", "new"], step_rate=[500.0, 1000.0])
    return synthetic.write_folder(
        tmp_path_factory.mktemp("synthetic"),
        joints=JOINTS,
        cells=cells,
        error=lambda c: (
            np.inf if (c.engine, c.step_rate) == ("drake", 500.0) else 0.02 if c.robot_revision == "old" else 0.01
        ),
    )


def test_means_of_the_page_are_those_of_the_table() -> None:
    results = read_folder(Path(__file__).parents[2] / "results" / "reference" / "demo")
    rows = payload(results)["rows"]
    keys = [rows[name] for name in ("cell", "signal", "group")]
    exact, told = (pd.Series(v).groupby(keys).mean() for v in (results.gaps["mean_abs"].to_numpy(), rows["mean"]))
    assert [number(v) for v in told] == [number(v) for v in exact]


def test_same_folder_same_page(folder: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(folder, tmp_path / "copy")
    assert write_page(copy).read_bytes() == write_page(folder).read_bytes()


def test_page_needs_nothing_from_elsewhere(folder: Path) -> None:
    text = write_page(folder).read_text()
    assert not re.search(r"""(?:src|href)\s*=\s*["']?\s*(?:https?:)?//""", text)
    assert "fetch(" not in text
    assert "@import" not in text
    assert not re.findall(r"https?://(?!www\.w3\.org/2000/svg)", text)


def test_page_says_settings_limits_and_failures(folder: Path) -> None:
    text = write_page(folder).read_text()
    assert "the solver of drake" in text
    assert "armature: emulated. outside the engine" in text
    assert "diverged at 1.2000 s at knee: not finite" in text
    assert "Virtual recordings." not in text


def test_a_setting_that_no_engine_has_is_no_row(folder: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(folder, tmp_path / "copy")
    manifest = json.loads((copy / "manifest.json").read_text())
    manifest["settings"]["drake"] |= {"contact friction": None, "compliance": 0}
    (copy / "manifest.json").write_text(json.dumps(manifest))
    text = write_page(copy).read_text()
    assert "contact friction" not in text
    assert '<th scope="row" data-label="setting">compliance</th>' in text


def test_only_a_folder_with_traces_asks_to_choose_a_cell_for_its_curves(folder: Path, tmp_path: Path) -> None:
    assert "Choose a cell for its curves:" in write_page(folder).read_text()
    shutil.copy(folder / "gaps.csv", tmp_path)
    assert "Choose a cell for its numbers:" in write_page(tmp_path).read_text()


def test_page_of_virtual_recordings_says_so(tmp_path: Path) -> None:
    cells = [synthetic.cell()]
    synthetic.write_folder(tmp_path, joints=JOINTS, cells=cells, error=lambda _: 0.01, virtual=True)
    assert "Nothing is concluded about reality" in write_page(tmp_path).read_text()


def test_page_without_timings_manifest_and_curves(folder: Path, tmp_path: Path) -> None:
    shutil.copy(folder / "gaps.csv", tmp_path)
    assert "MuJoCo comes closest" in write_page(tmp_path).read_text() or "MuJoCo is" in write_page(tmp_path).read_text()


def test_names_from_outside_stay_text(tmp_path: Path) -> None:
    joints = ["</script><script>alert(1)</script>", "<b>knee</b>"]
    synthetic.write_folder(tmp_path, joints=joints, cells=[synthetic.cell(recording="<i>x</i>")], error=lambda _: 0.01)
    text = write_page(tmp_path).read_text()
    assert "<script>alert" not in text
    assert "<b>knee" not in text
    assert "<i>x" not in text


def test_folder_without_table_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"found no gaps\.csv"):
        write_page(tmp_path)


def curves_of(folder: Path, simulated: Trace, measured: Trace) -> Path:
    """The curve file of one cell with these traces."""
    return write_curves(folder, read_traces(synthetic.write_cell(folder, synthetic.cell(), simulated, measured)))[0]


def test_curves_come_back_within_their_quantum(tmp_path: Path) -> None:
    joints = ["a", "b"]
    measured, simulated = synthetic.trace(joints, 0.0, 0, command=True), synthetic.trace(joints, 0.01, 1)
    path = curves_of(tmp_path, simulated, measured)
    content = read_curves(path)
    time = unpack(content["time"])
    truth = np.rad2deg(there(simulated.at(time + measured.time[0]).position))
    for i, joint in enumerate(joints):
        packed = content["simulated"]["position"][joint]
        assert packed["unit"] == "deg"
        np.testing.assert_allclose(unpack(packed), truth[:, i], atol=0.51 * packed["quantum"])
        assert packed["quantum"] <= 1e-4 * np.abs(truth[:, i]).max()
    theirs = read_curves(tmp_path / "curves" / f"{content['measured']}.js")
    np.testing.assert_allclose(
        unpack(theirs["position"]["a"]), np.rad2deg(there(measured.at(time).position)[:, 0]), atol=1e-3
    )


def test_samples_that_were_not_measured_stay_missing(tmp_path: Path) -> None:
    measured = synthetic.trace(["a"], 0.0, 0)
    there(measured.position)[200:400] = np.nan
    path = curves_of(tmp_path, synthetic.trace(["a"], 0.01, 1), measured)
    content = read_curves(path)
    values = unpack(read_curves(tmp_path / "curves" / f"{content['measured']}.js")["position"]["a"])
    time = unpack(content["time"])
    assert np.isnan(values[(time > 1.01) & (time < 1.98)]).all()
    assert np.isfinite(values[time < 0.99]).all()
    assert np.isfinite(content["boxes"]["position"]["a"]).all()


def test_box_is_that_of_all_samples(tmp_path: Path) -> None:
    measured, simulated = synthetic.trace(["a"], 0.0, 0), synthetic.trace(["a"], 0.02, 3)
    path = curves_of(tmp_path, simulated, measured)
    gap = np.rad2deg(np.abs(there(simulated.position) - there(measured.position))[:, 0])
    low, q1, median, q3, high, most = read_curves(path)["boxes"]["position"]["a"]
    np.testing.assert_allclose([q1, median, q3, most], [*np.percentile(gap, [25, 50, 75]), gap.max()], rtol=1e-3)
    assert low <= q1 <= median <= q3 <= high <= most


def test_spread_is_the_rms_between_the_engines(tmp_path: Path) -> None:
    measured = synthetic.trace(["a"], 0.0, 0)
    for engine, offset in (("mujoco", 0.01), ("drake", 0.03)):
        shifted = synthetic.trace(["a"], 0.0, 0)
        there(shifted.position)[:] += offset
        synthetic.write_cell(tmp_path, synthetic.cell(engine), shifted, measured)
    gaps = {(e, (), "position", "moving"): 1.0 for e in ("mujoco", "drake")}
    synthetic.write_planted(tmp_path, synthetic.planted(gaps))
    (one,) = spread(read_folder(tmp_path))
    assert one.radians == pytest.approx(0.02, rel=1e-9)


def test_gain_that_follows_from_the_recording_is_no_axis(tmp_path: Path) -> None:
    def gaps(pairs: Any) -> synthetic.Gaps:
        return {
            ("mujoco", (("recording", r), ("overrides", json.dumps({"servos.*.gain": g}))), "position", "moving"): 1.0
            for r, g in pairs
        }

    synthetic.write_planted(tmp_path / "a", synthetic.planted(gaps([("p16", 2.5), ("p32", 5.0)])))
    synthetic.write_planted(tmp_path / "b", synthetic.planted(gaps([("p16", 2.5), ("p16", 5.0)])))
    assert "servos.*.gain" not in read_folder(tmp_path / "a").varying
    assert read_folder(tmp_path / "b").axes["servos.*.gain"] == [2.5, 5.0]


def test_figures_are_the_same_twice_and_name_what_they_show(tmp_path: Path) -> None:
    cells = synthetic.grid(engine=["mujoco", "drake"], robot_revision=["old", "new"])
    synthetic.write_folder(
        tmp_path, joints=JOINTS[:2], cells=cells, error=lambda c: np.inf if c.engine == "drake" else 0.01
    )
    files = write_figures(tmp_path)
    first = {f: f.read_bytes() for f in files}
    assert {f: f.read_bytes() for f in write_figures(tmp_path)} == first
    names = [f.name for f in files]
    assert "boxes-position-revisions-MuJoCo.svg" in names
    assert "curves-position-new.svg" in names
    boxes = (tmp_path / "figures" / "boxes-position-new.svg").read_text()
    for label in ("MuJoCo", "Drake", "diverged", *JOINTS[:2]):
        assert label in boxes


@pytest.mark.parametrize("joints", [1, 20])
def test_figures_for_one_joint_and_for_many(tmp_path: Path, joints: int) -> None:
    names = [f"joint_{i}" for i in range(joints)]
    synthetic.write_folder(tmp_path, joints=names, cells=[synthetic.cell()], error=lambda _: 0.01)
    boxes = next(f for f in write_figures(tmp_path) if f.name == "boxes-position-swing.svg").read_text()
    assert all(n in boxes for n in names)


def test_names_in_any_script_stay_text(tmp_path: Path) -> None:
    """Without a warning, which is an error in tests: what shows the figure has the font."""
    names, swing = ["肩", "팔꿈치", "कलाई"], synthetic.cell(recording="振り子")
    synthetic.write_folder(tmp_path, joints=names, cells=[swing], error=lambda _: 0.01)
    drawn = "".join(file.read_text(encoding="utf-8") for file in write_figures(tmp_path))
    assert all(f">{name}<" in drawn or f">{name} [" in drawn for name in names)
    assert "振り子" in drawn


def test_a_body_without_joints_has_curves_of_its_position(tmp_path: Path) -> None:
    scenario = write_tosses(tmp_path, 0.3)
    done = CliRunner().invoke(app, ["run", str(scenario), "-e", "mujoco", "-o", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert "could not be made" not in done.output
    assert list((tmp_path / "out" / "figures").glob("curves-*.svg"))


def test_the_thesis_own_differences_are_those_of_its_tables() -> None:
    """Table 5.6 as printed, made anew from tables 5.4 and 5.5."""
    assert improvements() == [
        ("cheering", "moving", "+0.2924", "-0.9567", "+1.7149"),
        ("cheering", "unmoving", "+0.3951", "-0.1687", "+0.3538"),
        ("kick", "moving", "+0.1311", "-0.3301", "+0.1088"),
        ("kick", "unmoving", "+0.1821", "+0.3208", "+0.3139"),
    ]
    assert grounds()[:2] == [
        ("moving", "flat", "0.3345", "0.6742", "1.6723"),
        ("moving", "grass", "0.3138", "1.6838", "0.2798"),
    ]


def test_only_pages_of_the_thesis_robot_show_its_tables(tmp_path: Path) -> None:
    for name, shown in (("wolfgang_cheering", True), ("arm", False)):
        gaps = {("mujoco", (("scenario", name),), "position", "moving"): 1.0}
        page = write_page(synthetic.write_planted(tmp_path / name, synthetic.planted(gaps))).read_text()
        assert ("table 6.1" in page) is shown


@pytest.mark.parametrize("cut", ["garbage", "header", "row"])
def test_timings_that_are_cut_or_none_are_one_sentence(cut: str, folder: Path, tmp_path: Path) -> None:
    """Within the header or a row, as a copy that was interrupted leaves them."""
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    file = tmp_path / "timings.csv"
    whole = file.read_text()
    last = whole.splitlines()[-1]
    kept = {"garbage": "garbage", "header": whole[:40], "row": whole[: -len(last) // 2]}
    file.write_text(kept[cut])
    with pytest.raises(InputError, match=r"timings.csv: is not a table of timings .*; take it away or run again"):
        read_folder(tmp_path)


def test_a_folder_that_takes_no_files_is_one_sentence(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)

    def refused(**_: object) -> None:
        raise OSError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr("tempfile.TemporaryFile", refused)
    with pytest.raises(InputError, match=r"^report: .* cannot be written, .* takes no files .Read-only file system."):
        remake(tmp_path)
