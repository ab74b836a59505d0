"""Files that are not what their name says, or are not whole: what they are, and what makes tables of them."""

import gzip
from pathlib import Path

import pytest
from bags import FILE, scenario
from realitygap.files.errors import InputError
from realitygap.recording import read_recording

HEADED, WHOLE = r" .*expected columns with a header line", r" \(.*\); expected a whole Parquet file: get it again"


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("run.csv", b"", HEADED),
        ("run.csv", b"\x89PNG\r\n\x1a\n\x00\xff\xfe", HEADED),
        ("run.csv", b'time,position\n1,2\n1,2,3,4\n"', HEADED),
        ("run.parquet", b"", WHOLE),
        ("run.parquet", b"\x89PNG\r\n\x1a\n\x00\xff\xfe", WHOLE),
        ("run.parquet", b"PAR1\x15\x04\x15\x10", WHOLE),
        ("run.parquet", b"time,position\n1,2\n", r": it is text; expected a Parquet file: rename it to \.csv where"),
    ],
)
def test_files_that_are_not_tables(name: str, data: bytes, said: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes(data)
    with pytest.raises(InputError, match=rf"run\.\w+: is not a table{said}"):
        read_recording(path, scenario(), ["elbow"], file=FILE)


@pytest.mark.parametrize("name", ["run.csv", "run.parquet", "run.mcap", "run.bag"])
def test_what_git_has_not_fetched_is_told(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n")
    with pytest.raises(InputError, match=rf"{name}: is a pointer of git-lfs, .*: run `git lfs pull`"):
        read_recording(path, scenario(), ["elbow"], file=FILE)


@pytest.mark.parametrize("name", ["run.csv", "run.parquet", "run.mcap"])
def test_what_is_packed_without_saying_so_is_told(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes(gzip.compress(b"time,position\n1,2\n"))
    with pytest.raises(InputError, match=rf"{name}: is packed with gzip; .*: rename it to {name}\.gz"):
        read_recording(path, scenario(), ["elbow"], file=FILE)
