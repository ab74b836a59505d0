"""What a bag may unpack to: a packed one reads as a plain one, and one that unpacks beyond its allowance is refused."""

import contextlib
import os
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rosbags.highlevel.anyreader
import rosbags.rosbag1.reader
import rosbags.rosbag2.reader
import rosbags.rosbag2.storage_mcap
from bags import FILE, scenario, two_joints
from realitygap.files.errors import InputError
from realitygap.recording import read_recording
from realitygap.recording.readers import bag_limits
from realitygap.recording.readers.rosbag import opened
from rosbags import rosbag1, rosbag2
from signals import Signals

PACKED = ("bag bz2", "bag lz4", "db3 file", "db3 message", "mcap file", "mcap message", "mcap storage")
"""Formats, and how they are packed."""


@pytest.fixture
def packing(monkeypatch: pytest.MonkeyPatch, write_bag: Callable[..., Path], tmp_path: Path) -> Callable[..., Path]:
    """A function that writes messages to a packed bag: the usual writer, told to pack."""

    def write(packed: str, messages: list[Any]) -> Path:
        form, how = packed.split()
        writer: Any = rosbag1.Writer if form == "bag" else rosbag2.Writer

        class Packing(writer):  # type: ignore[misc]
            def __enter__(self) -> Any:
                if form == "bag":
                    self.set_compression(self.CompressionFormat[how.upper()])
                else:
                    self.set_compression(rosbag2.CompressionMode[how.upper()], rosbag2.CompressionFormat.ZSTD)
                return super().__enter__()

        with monkeypatch.context() as patch:
            patch.setattr(rosbag1 if form == "bag" else rosbag2, "Writer", Packing)
            name = packed.replace(" ", "_")
            return write_bag(tmp_path / (f"{name}.bag" if form == "bag" else name), form, messages)

    return write


@pytest.mark.parametrize("packed", PACKED)
def test_a_packed_bag_reads_as_a_plain_one(
    packed: str, packing: Callable[..., Path], write_bag: Callable[..., Path], tmp_path: Path
) -> None:
    form = packed.split()[0]
    plain = write_bag(tmp_path / ("plain.bag" if form == "bag" else "plain"), form, two_joints())
    one, other = (read_recording(p, scenario(), ["a", "b"], file=FILE) for p in (plain, packing(packed, two_joints())))
    np.testing.assert_array_equal(Signals(one.trace).position, Signals(other.trace).position)
    np.testing.assert_array_equal(Signals(one.trace).command, Signals(other.trace).command)


@pytest.mark.parametrize("packed", PACKED)
def test_a_bag_that_unpacks_beyond_its_allowance_is_refused(
    packed: str, packing: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    same = 4000 * two_joints(1)
    path = packing(packed, [(t, r + 0.01 * k, kind, v) for k, (t, r, kind, v) in enumerate(same)])
    monkeypatch.setattr(bag_limits, "TIMES", 0)
    monkeypatch.setattr(bag_limits, "LEAST", 1000)
    with pytest.raises(InputError, match=rf"{path.name}: unpacks to more than 0 MiB, 0 times its size"):
        read_recording(path, scenario(), ["a", "b"], file=FILE)


def test_a_library_is_itself_again_when_a_bag_is_closed(packing: Callable[..., Path]) -> None:
    def own() -> list[Any]:
        return [
            dict(rosbags.rosbag1.reader.decompressors),
            dict(rosbags.rosbag2.storage_mcap.DECOMPRESSORS),
            vars(rosbags.rosbag2.reader)["zstd"],
            *(vars(rosbags.highlevel.anyreader)[name] for name in bag_limits.PARSERS),
        ]

    before = own()
    path = packing("mcap storage", two_joints())
    with opened(path) as bag, opened(path) as again:
        assert own() != before
        assert len(list(bag.raw({"/joint_states"}))) == len(list(again.raw({"/joint_states"}))) == 100
    assert own() == before


@pytest.mark.parametrize("column", ["timestamp", "data"])
@pytest.mark.parametrize("value", ["yesterday", 1.5, b"abc", None])
def test_a_database_that_holds_something_else_is_told(
    column: str, value: object, write_bag: Callable[..., Path], tmp_path: Path
) -> None:
    path = write_bag(tmp_path / "run", "db3", two_joints())
    with contextlib.closing(sqlite3.connect(next(path.glob("*.db3")))) as database:
        database.execute("CREATE TABLE others AS SELECT * FROM messages")
        database.execute("DROP TABLE messages")  # whose columns forbid what others allow
        database.execute("ALTER TABLE others RENAME TO messages")
        database.execute(f"UPDATE messages SET {column} = ? WHERE id = 3", [value])
        database.commit()
    with pytest.raises(InputError):
        read_recording(path, scenario(), ["a", "b"], file=FILE)


@pytest.mark.parametrize("name", ["metadata.yaml", "x.mcap"])
def test_a_pipe_in_the_folder_of_a_bag_is_told(name: str, tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    os.mkfifo(tmp_path / "run" / name)
    with pytest.raises(InputError, match=rf"{name}: is a pipe, a socket or a device; expected a file"):
        read_recording(tmp_path / "run", scenario(), ["a", "b"], file=FILE)
