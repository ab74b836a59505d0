"""Recordings of real robots, whatever file they are in, as one type."""

from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path

from realitygap_engines.model.robot import Mimic

from realitygap.files.errors import InputError
from realitygap.files.plain_file import check_plain
from realitygap.files.unpacked import OTHERS, PACKED, plain_name
from realitygap.recording.assemble import assemble
from realitygap.recording.followers import with_followers
from realitygap.recording.part import part_of
from realitygap.recording.recording import Recording
from realitygap.recording.streams import Streams, request_of
from realitygap.scenario.schema import Scenario

__all__ = ["READERS", "Recording", "read_recording", "reader_of"]

FOLDER = "folder"
DATASET = "data set"
INFO = Path("meta") / "info.json"
"""What makes a folder a data set."""
PARTS = ("data", "meta", "videos")
"""What a data set's folder holds."""
READERS = {  # file suffix, or a kind of folder -> module with read(path, request) -> Streams
    ".bag": "rosbag",
    ".csv": "table",
    ".db3": "rosbag",
    ".mcap": "rosbag",
    ".parquet": "table",
    ".tsv": "table",
    DATASET: "lerobot",
    FOLDER: "rosbag",
}


def reader_of(path: Path) -> str:
    """The name of the reader for a file or folder.

    Raises:
        InputError: where nothing is there, or nothing here reads it.
    """
    if not path.exists():
        raise InputError(f"{path}: does not exist; expected a bag, a bag folder, a table or a data set")
    check_plain(path)
    kind = plain_name(path).suffix.lower()
    if path.suffix.lower() in OTHERS:
        raise InputError(
            f"{path}: is packed in a way that is not read here; expected {', '.join(PACKED)}, or unpack it first"
        )
    if path.is_dir():
        kind = DATASET if (path / INFO).exists() else FOLDER
    whole = next((p for p in path.absolute().parents if (p / INFO).exists()), None)
    if whole is not None and path.absolute().relative_to(whole).parts[0] in PARTS:
        raise InputError(f"{path}: is a part of the LeRobot data set {whole}; expected the data set's folder")
    if kind not in READERS:
        known = ", ".join(k for k in READERS if k not in (FOLDER, DATASET))
        raise InputError(
            f"{path}: is not a kind of recording that is known here; expected {known}, a bag folder or the folder of a "
            "LeRobot data set; save it as .csv with a header line: time, position/JOINT, command/JOINT, effort/JOINT"
        )
    return READERS[kind]


def read_recording(
    path: Path,
    scenario: Scenario,
    joints: Sequence[str],
    *,
    file: Path,
    mimics: Mapping[str, Mimic] | None = None,
    limits: Mapping[str, tuple[float, float]] | None = None,
) -> Recording:
    """What was measured in one recording.

    Args:
        path: a rosbag 1 file, a rosbag 2 folder, a bare .mcap or .db3, a .csv, .tsv or .parquet (all of them as .gz or
            .zst too), or a data set's folder.
        scenario: says which topics and columns are what (with the overrides of this run applied).
        joints: the joints to keep, which is the order of all joint columns, whatever the order in the recording.
        file: the scenario file, for messages.
        mimics: the joints that follow others: what was not recorded of them is told from those.
        limits: lower and upper [rad] of the joints that turn and have both: of the turns that an angle may be of, it is
            the one within them.

    Raises:
        InputError: for a file that cannot be read, a topic, column or joint that is not there, or values that make no
            sense; the sentence says what was found.
    """
    reader = reader_of(path)
    episode = scenario.recordings.episode if scenario.recordings else None
    if episode is not None and reader != READERS[DATASET]:
        raise InputError(
            f"{file}: recordings: found episode {episode} of {path}; expected a data set with meta/info.json"
        )
    module = import_module(f"realitygap.recording.readers.{reader}")

    def read(of: Sequence[str]) -> Recording:
        request = request_of(scenario, tuple(of), file, limits)
        streams: Streams = module.read(path, request)
        return part_of(assemble(path, streams, request), request)

    return with_followers(read, tuple(joints), mimics or {})
