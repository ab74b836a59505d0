"""Tables whose header and rows do not agree: no column is shifted, and none is chosen by chance."""

from pathlib import Path

import bags
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from bags import FILE
from realitygap.files.errors import InputError
from realitygap.recording import read_recording
from realitygap.robot.drive import Array
from realitygap.scenario.schema import Scenario
from signals import Signals

TIME = np.arange(50) * 0.01
NAMES = ["time", "command", "position", "velocity"]
VALUES = np.column_stack([TIME, TIME + 1, 2 * TIME, np.ones(50)])


def scenario(columns: dict[str, str] | None = None) -> Scenario:
    return bags.scenario(None, "command", "fixed", "position", columns=columns or {})


def text(names: list[str], values: Array, *, before: str = "", after: str = "", point: str = ".") -> str:
    """A table with commas between the cells, and more before and after every row."""
    rows = [before + ",".join(f"{v:.3f}".replace(".", point) for v in row) + after for row in values]
    return "\n".join([",".join(names), *rows]) + "\n"


def test_separators_at_the_ends_of_rows_alone_shift_no_column(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text(text(NAMES, VALUES, after=","))
    trace = Signals(read_recording(path, scenario(), ["elbow"], file=FILE).trace)
    np.testing.assert_allclose(trace.time, TIME, atol=1e-12)
    np.testing.assert_allclose(trace.position[:, 0], 2 * TIME, atol=1e-12)


@pytest.mark.parametrize(("before", "point"), [("7,", "."), ("", ",")])
def test_rows_with_more_cells_than_names_are_told(before: str, point: str, tmp_path: Path) -> None:
    """Names of rows without a name above them, and a decimal comma where commas separate."""
    path = tmp_path / "run.csv"
    path.write_text(text(NAMES, VALUES, before=before, point=point))
    with pytest.raises(InputError, match=r"run\.csv: is not a table \(its rows have more cells than its header"):
        read_recording(path, scenario(), ["elbow"], file=FILE)


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
@pytest.mark.parametrize("again", ["position", " position"])
def test_a_column_that_stands_twice_is_told_where_it_is_asked_for(again: str, suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"run{suffix}"
    names, values = [*NAMES, again], np.column_stack([VALUES, TIME])
    if suffix == ".csv":
        path.write_text(text(names, values))
    else:
        pq.write_table(pa.table([pa.array(column) for column in values.T], names=names), path)
    with pytest.raises(InputError, match=r"has more than one column position; expected one: rename or remove"):
        read_recording(path, scenario(), ["elbow"], file=FILE)
    elsewhere = scenario({"position": "velocity", "velocity": "command"})
    trace = Signals(read_recording(path, elsewhere, ["elbow"], file=FILE).trace)
    np.testing.assert_array_equal(trace.position[:, 0], np.ones(50))


@pytest.mark.parametrize("mark", [",", ";", " "])
@pytest.mark.parametrize(("cells", "told"), [("0.1,1,2,1,9", "has 5 cells"), ("0.1,1,2", "has 3 cells")])
def test_a_line_with_more_or_fewer_cells_than_the_header_is_told(
    cells: str, told: str, mark: str, tmp_path: Path
) -> None:
    """By its number in the file; only as the last one it is what a file that was cut off ends with."""
    path = tmp_path / "run.csv"
    lines = ["# by hand", *text(NAMES, VALUES).splitlines()]
    lines[40] = cells
    path.write_text("\n".join(lines).replace(",", mark))
    with pytest.raises(InputError, match=rf"run\.csv: is not a table \(line 41 {told}, the header 4\); expected"):
        read_recording(path, scenario(), ["elbow"], file=FILE)
    if len(cells.split(",")) < 4:
        path.write_text("\n".join(lines[:41]).replace(",", mark))
        assert len(read_recording(path, scenario(), ["elbow"], file=FILE).trace.time) == 38


def test_empty_cells_are_readings_that_are_absent(tmp_path: Path) -> None:
    """With all their separators, at the ends of lines, too."""
    path = tmp_path / "run.csv"
    lines = text(NAMES, VALUES).splitlines()
    lines[40] = lines[40].rpartition(",")[0] + ","
    lines[30] = '0.290,"1.290",0.580,'
    path.write_text("\n".join(lines))
    assert len(read_recording(path, scenario(), ["elbow"], file=FILE).trace.time) == 50


def test_an_empty_file_is_told(tmp_path: Path) -> None:
    (tmp_path / "run.csv").touch()
    with pytest.raises(InputError, match=r"run\.csv: is not a table \(it is empty\)"):
        read_recording(tmp_path / "run.csv", scenario(), ["elbow"], file=FILE)


@pytest.mark.parametrize("stated", ["sep=;", '"sep=;"', "SEP=;;;;"])
@pytest.mark.parametrize(("above", "encoding"), [("", "cp1252"), ("# of a logger\n", "utf-8-sig"), ("", "utf-16")])
def test_a_first_line_that_says_the_separator_is_taken_at_its_word(
    stated: str, above: str, encoding: str, tmp_path: Path
) -> None:
    """Also where the header has other separators in its names."""
    path = tmp_path / "run.csv"
    names = ["time", "command", "position", "speed [°/s], raw"]
    rows = [";".join(f"{v:.3f}".replace(".", ",") for v in row) for row in VALUES]
    path.write_text(f"{stated}\n{above}{';'.join(names)}\n" + "\n".join(rows) + "\n", encoding=encoding)
    recording = read_recording(path, scenario(), ["elbow"], file=FILE)
    np.testing.assert_allclose(Signals(recording.trace).position[:, 0], 2 * TIME, atol=1e-12)
    np.testing.assert_allclose(recording.trace.time, TIME, atol=1e-12)
    path.write_text(path.read_text(encoding=encoding).replace("0,020;1,020", "0,020;?"), encoding=encoding)
    with pytest.raises(InputError, match=rf"command is '\?' in line {5 if not above else 6}, expected a number"):
        read_recording(path, scenario(), ["elbow"], file=FILE)


def test_a_comma_that_is_said_to_separate_is_none_of_numbers(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("sep=,\n" + text([*NAMES[:-1], "a;b"], VALUES))
    trace = Signals(read_recording(path, scenario(), ["elbow"], file=FILE).trace)
    np.testing.assert_allclose(trace.position[:, 0], 2 * TIME, atol=1e-12)


@pytest.mark.parametrize("whole", [True, False])
@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be", "utf-32"])
def test_a_table_is_read_by_its_byte_order_mark(encoding: str, whole: bool, tmp_path: Path) -> None:
    """And a last line that was cut off is left out."""
    path, mark = tmp_path / "run.csv", "\ufeff" if encoding.endswith("be") else ""
    cells = text(NAMES, np.tile(VALUES, (100, 1)) + 100.0 * np.repeat(np.arange(100), 50)[:, None])
    path.write_text(mark + (cells if whole else cells + "9999.0,"), encoding=encoding)
    recording = read_recording(path, scenario(), ["elbow"], file=FILE)
    assert len(recording.trace.time) == 5000
    assert any("the last line is cut off" in note for note in recording.notes) is not whole
