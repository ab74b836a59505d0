"""The time of a table: dates as people's loggers write them, and rows in another order than that of time."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from bags import FILE, scenario
from realitygap.files.errors import InputError
from realitygap.recording import Recording, read_recording
from signals import Signals

TIME = 0.01 * np.arange(50)
START = pd.Timestamp("2024-03-05 10:00:00", tz="UTC")


def read(path: Path, time: Any, separator: str = ",", units: dict[str, str] | None = None) -> Recording:
    frame = pd.DataFrame({"time": time, "command": TIME, "position": 2 * TIME})
    frame.to_parquet(path) if path.suffix == ".parquet" else frame.to_csv(path, index=False, sep=separator)
    asked = scenario(None, "command", columns={} if units is None else {"units": units})
    return read_recording(path, asked, ["elbow"], file=FILE)


@pytest.mark.parametrize("units", [None, {"time": "ns"}])
@pytest.mark.parametrize(
    ("form", "separator"),
    [
        ("%Y-%m-%dT%H:%M:%S.%fZ", ","),
        ("%Y-%m-%d %H:%M:%S.%f", ","),
        ("%Y-%m-%dT%H:%M:%S.%f+02:00", ","),
        (" %Y-%m-%dT%H:%M:%S,%f", ";"),
    ],
)
def test_dates_of_iso_8601_are_seconds(form: str, separator: str, units: dict[str, str] | None, tmp_path: Path) -> None:
    """Whatever unit numbers would have."""
    stamps = (START + pd.to_timedelta(TIME, unit="s")).strftime(form)
    recording = read(tmp_path / "run.csv", stamps, separator, units)
    np.testing.assert_allclose(recording.trace.time, TIME, atol=1e-9)
    np.testing.assert_array_equal(Signals(recording.trace).position[:, 0], 2 * TIME)


@pytest.mark.parametrize("units", [None, {"time": "ns"}])
@pytest.mark.parametrize("kind", ["datetime64[ns]", "datetime64[us]", "datetime64[ns, UTC]", "timedelta64[ns]"])
def test_dates_of_parquet_are_seconds(kind: str, units: dict[str, str] | None, tmp_path: Path) -> None:
    after = pd.to_timedelta(TIME, unit="s")
    stamps: Any = pd.Series(after if kind[0] == "t" else (START if "UTC" in kind else START.tz_localize(None)) + after)
    recording = read(tmp_path / "run.parquet", stamps.astype(kind), units=units)
    np.testing.assert_allclose(recording.trace.time, TIME, atol=1e-9)


@pytest.mark.parametrize(
    ("cell", "sentence"),
    [
        (
            "05.03.2024 10:00:00.010",
            r"time is '05\.03\.2024 10:00:00\.010' in line 3, expected a number, or a date as 2024-",
        ),
        (
            "2024-03-05T10:61:00",
            r"in line 3, expected a number, or a date as 2024-03-05T10:00:00\.010 \(ISO 8601\), whi",
        ),
        ("", r"time is empty in line 3, expected a time in s"),
    ],
)
@pytest.mark.parametrize("form", ["%d.%m.%Y %H:%M:%S.%f", "%Y-%m-%dT%H:%M:%S.%f"])
def test_other_dates_are_told_how_to_convert(form: str, cell: str, sentence: str, tmp_path: Path) -> None:
    stamps = list((START + pd.to_timedelta(TIME, unit="s")).strftime(form))
    stamps[1] = cell
    if form.startswith("%d"):
        sentence = r"time is '05\.03\.2024 10:00:00\.000000' in line 2, expected a number, or a date as 2024"
    with pytest.raises(InputError, match=sentence):
        read(tmp_path / "run.csv", stamps)


def test_rows_that_came_a_little_late_are_sorted(tmp_path: Path) -> None:
    """With all that stands in them, and where others repeat a time."""
    order = np.arange(50)
    order[[20, 21]] = order[[21, 20]]
    order[30:36] = [33, 34, 30, 31, 32, 35]
    frame = pd.DataFrame({"time": 3.0 + TIME, "command": TIME, "position": 2 * TIME}).iloc[order]
    pd.concat([frame, frame[-1:]]).to_csv(tmp_path / "run.csv", index=False)
    recording = read_recording(tmp_path / "run.csv", scenario(None, "command"), ["elbow"], file=FILE)
    np.testing.assert_allclose(recording.trace.time, TIME, atol=1e-9)
    np.testing.assert_allclose(Signals(recording.trace).position[:, 0], 2 * TIME, atol=1e-9)
    np.testing.assert_allclose(recording.command[:, 0], TIME, atol=1e-9)
    assert recording.notes == (
        "2 rows came out of order and were sorted",
        "1 rows repeat the time of another and were dropped, of 51",
    )


@pytest.mark.parametrize("late", [0.2, 100.0])
def test_a_clock_that_was_set_back_is_told(late: float, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"time goes back from 0\.24 to .* s in line 27, expected times that increase"):
        read(tmp_path / "run.csv", TIME - late * (TIME >= 0.25))


def test_a_first_row_that_came_late_begins_no_other_clock(tmp_path: Path) -> None:
    recording = read(tmp_path / "run.csv", TIME[[1, 0, *range(2, 50)]])
    np.testing.assert_allclose(recording.trace.time, TIME, atol=1e-9)


@pytest.mark.parametrize(("cells", "told"), [(["s", "0.00", "0.01"], True), (["s", "n/k", "0.01"], False)])
def test_a_line_of_units_below_the_header_is_told_as_such(cells: list[str], told: bool, tmp_path: Path) -> None:
    """As LabVIEW and others write it: no date, and nothing that a spreadsheet's format of cells mends."""
    rows = [f"{cell},{value},{value}" for cell, value in zip(cells, ["deg", 1, 2], strict=True)]
    (tmp_path / "run.csv").write_text("\n".join(["time,command,position", *rows, ""]))
    with pytest.raises(InputError, match="time is 's' in line 2, expected a number") as raised:
        read_recording(tmp_path / "run.csv", scenario(None, "command", columns={}), ["elbow"], file=FILE)
    way = "; where line 2 holds units, delete it and say them in recordings.columns.units"
    assert str(raised.value).endswith(way) is told
