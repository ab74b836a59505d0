"""Reading a robot's file, whatever its format, into the canonical `Model`."""

from collections.abc import Mapping
from os import PathLike
from pathlib import Path

from realitygap_engines.model.mjcf import read_mjcf
from realitygap_engines.model.robot import Model
from realitygap_engines.model.urdf import read_urdf

HEAD = 65536
"""Bytes in which the root element of an XML file begins, after whatever its authors wrote above it."""


def format_of(path: Path) -> str:
    """`mjcf` or `urdf`, by the root element; a file that cannot be read or is neither counts as a URDF."""
    try:
        with path.open("rb") as file:
            head = file.read(HEAD)
    except OSError:
        return "urdf"
    return "mjcf" if b"<mujoco" in head and b"<robot" not in head.partition(b"<mujoco")[0] else "urdf"


def read_model(
    path: str | PathLike[str],
    *,
    floating: bool,
    packages: Mapping[str, Path] | None = None,
    contact_links: list[str] | None = None,
) -> Model:
    """The canonical model of a URDF or MJCF file. Arguments and errors as of `read_urdf`."""
    file = Path(path)
    if format_of(file) == "mjcf":
        return read_mjcf(file, floating=floating, contact_links=contact_links)
    return read_urdf(file, floating=floating, packages=packages, contact_links=contact_links)
