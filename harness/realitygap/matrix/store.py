"""Where finished cells are kept: one file per cell, written whole or not at all, found again by its key."""

import re
import uuid
from abc import ABC, abstractmethod
from pathlib import Path

from realitygap.files.errors import InputError
from realitygap.files.home import at_home
from realitygap.files.unfinished import sweep
from realitygap.files.whole import write_whole


class Store(ABC):
    """Files of cells by key."""

    @abstractmethod
    def keys(self) -> set[str]:
        """The keys of all cells that are there."""

    @abstractmethod
    def read(self, key: str) -> bytes:
        """The file of a cell."""

    @abstractmethod
    def write(self, key: str, data: bytes) -> None:
        """Keep the file of a cell; a reader sees all of it or nothing."""


class FolderStore(Store):
    """A folder, of this machine or shared by several."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def keys(self) -> set[str]:
        sweep(self.folder)
        return {p.stem for p in self.folder.glob("*.zip") if not p.name.startswith(".")}

    def read(self, key: str) -> bytes:
        return (self.folder / f"{key}.zip").read_bytes()

    def write(self, key: str, data: bytes) -> None:
        write_whole(self.folder / f"{key}.zip", data)


class RemoteStore(Store):
    """A place that `fsspec` reaches: `s3://…`, `gs://…`, `sftp://…`, `file://…`."""

    def __init__(self, url: str) -> None:
        try:
            import fsspec
        except ImportError:
            raise InputError(f"{url}: needs fsspec; install it with: pip install 'realitygap[cluster]'") from None
        try:
            self.files, self.folder = fsspec.core.url_to_fs(url)
            self.files.makedirs(self.folder, exist_ok=True)
        except (ValueError, ImportError) as error:
            raise InputError(f"{url}: cannot be reached ({error}); expected a URL that fsspec knows") from None
        except OSError as error:  # a host that nobody knows, a place that takes no files
            raise InputError(f"{url}: cannot be reached ({error}); expected a place that takes files") from None

    def keys(self) -> set[str]:
        self.files.invalidate_cache(self.folder)
        names = [str(p).rsplit("/", 1)[-1] for p in self.files.ls(self.folder, detail=False)]
        return {n.removesuffix(".zip") for n in names if n.endswith(".zip") and not n.startswith(".")}

    def read(self, key: str) -> bytes:
        return bytes(self.files.cat_file(f"{self.folder}/{key}.zip"))

    def write(self, key: str, data: bytes) -> None:
        # object stores show a file when it is complete; a file system shows it from the start, so it is moved there
        part = f"{self.folder}/.{key}-{uuid.uuid4().hex}"
        self.files.pipe_file(part, data)
        self.files.mv(part, f"{self.folder}/{key}.zip")


def open_store(place: str) -> Store:
    """The store at a path or URL."""
    return RemoteStore(place) if re.match(r"[a-z0-9+]+://", place) else FolderStore(at_home(place))
