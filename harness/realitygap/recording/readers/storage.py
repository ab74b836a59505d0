"""Which file of a folder is the bag."""

from pathlib import Path

from realitygap.files.errors import InputError
from realitygap.files.plain_file import check_plain

TABLES = {".csv", ".parquet", ".tsv"}
"""In a folder that is taken for a bag, people have recordings of another kind."""


def storage_of(path: Path) -> Path:
    """The path to read: a folder without metadata, as a recorder leaves behind that was killed, is its one file.

    Raises:
        InputError: for a folder that is no bag.
    """
    for part in path.iterdir() if path.is_dir() else ():
        check_plain(part)
    if not path.is_dir() or (path / "metadata.yaml").exists():
        return path
    files = sorted([*path.glob("*.mcap"), *path.glob("*.db3"), *path.glob("*.bag")])
    if len(files) == 1:
        return files[0]
    found = f"{len(files)} storage files" if files else "no .mcap, .db3 or .bag"
    tables = sorted({part.suffix for part in path.iterdir()} & TABLES)
    inside = [*([f"{path}/*{files[0].suffix}"] if files else []), *(f"{path}/*{suffix}" for suffix in tables)]
    hint = f"; for several recordings name the files in it: {' '.join(inside)}" if inside else ""
    raise InputError(f"{path}: is a folder without metadata.yaml and with {found}; expected a rosbag 2 folder{hint}")
