"""Reading a robot's file, whatever its format, into the canonical `Model`."""

import os
from collections.abc import Mapping
from os import PathLike
from pathlib import Path

from realitygap_engines.errors import ModelError
from realitygap_engines.model.mjcf import read_mjcf
from realitygap_engines.model.robot import Model
from realitygap_engines.model.sdf import read_sdf

LARGEST = 64 << 20
"""Bytes of a robot's description; meshes lie beside it."""
ELEMENTS = 20_000
"""Beginnings and ends of elements; the files of machines have some thousands."""
HEAD = 65536
"""Bytes in which the root element of an XML file begins, after whatever its authors wrote above it."""


TAGS = {"mjcf": b"<mujoco", "sdf": b"<sdf", "urdf": b"<robot"}


def format_of(path: Path) -> str:
    """`mjcf`, `sdf` or `urdf`, by the root element; a file that cannot be read or is none of them counts as a URDF."""
    try:
        with path.open("rb") as file:
            head = file.read(HEAD)
    except OSError:
        return "urdf"
    found = {kind: at for kind, tag in TAGS.items() if (at := head.find(tag)) >= 0}
    return min(found, key=found.__getitem__, default="urdf")


def read_model(
    path: str | PathLike[str],
    *,
    floating: bool,
    packages: Mapping[str, Path] | None = None,
    contact_links: list[str] | None = None,
) -> Model:
    """The canonical model of a URDF, xacro, MJCF or SDF file. Arguments and errors as of `read_urdf`."""
    if not isinstance(path, str | PathLike):
        raise ModelError(f"found {type(path).__name__}; expected the path of a robot's file")
    file = Path(path)
    if file.exists() and not (file.is_file() or file.is_dir()):
        raise ModelError(f"{file}: is a pipe, a socket or a device; expected a robot's file")
    if file.is_file() and file.stat().st_size > LARGEST:
        raise ModelError(f"{file}: holds {file.stat().st_size >> 20} MiB, expected at most {LARGEST >> 20} MiB of XML")
    count = file.read_bytes().count(b"<") if file.is_file() and os.access(file, os.R_OK) else 0
    if count > ELEMENTS:
        raise ModelError(f"{file}: holds {count} tags, expected at most {ELEMENTS} in a robot's file")
    if format_of(file) == "mjcf":
        return read_mjcf(file, floating=floating, contact_links=contact_links)
    if format_of(file) == "sdf":
        return read_sdf(file, floating=floating, packages=packages, contact_links=contact_links)
    from realitygap_engines.model.urdf import read_urdf  # with all that reads meshes: who is sent a model needs none

    return read_urdf(file, floating=floating, packages=packages, contact_links=contact_links)
