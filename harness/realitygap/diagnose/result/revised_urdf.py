"""A URDF with other masses, centres of mass and inertias, which may lie in another folder; all else stays."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from realitygap_engines.errors import ModelError
from realitygap_engines.model.contact import find_mesh
from realitygap_engines.model.hold import own_body
from realitygap_engines.model.inertia import Inertial
from realitygap_engines.model.inertial_editor import urdf_text, with_inertials
from realitygap_engines.model.mjcf_revised import revised_mjcf
from realitygap_engines.model.read import format_of
from realitygap_engines.model.robot import Link
from realitygap_engines.model.sdf_revised import revised_sdf
from realitygap_engines.model.xacro_file import urdf_source

PACKAGE = "package://"


def revised_urdf(urdf: Path, folder: Path, links: Sequence[Link], packages: Mapping[str, Path] | None = None) -> str:
    """The text of a URDF, MJCF or SDF for another folder, with the inertials of these links.

    What is fixed to a link is part of it, so the inertials of the links merged into it are taken out. What a scenario
    holds fixed to it keeps its own.
    """
    if format_of(urdf) == "mjcf":
        return revised_mjcf(urdf, folder, links)
    if format_of(urdf) == "sdf":
        return revised_sdf(urdf, folder, links)
    bodies: dict[str, Inertial | None] = {name: None for link in links for name in link.merged[1:]}
    bodies |= {link.name: own_body(link) for link in links}
    text = with_inertials(urdf_text(urdf_source(urdf, packages or {})), bodies)
    root = text.root
    for mesh in root.iter("mesh"):
        name = mesh.get("filename", "")
        if name and not name.startswith(PACKAGE):
            moved = moved_path(urdf.parent / name.removeprefix("file://"), folder)
            mesh.set("filename", moved if name[0] != "/" and "://" not in name else name)
    return text.written()


def found_packages(urdf: Path, packages: Mapping[str, Path]) -> dict[str, Path]:
    """The packages of a URDF's meshes that are found beside or above it only, and where they lie."""
    out: dict[str, Path] = {}
    if format_of(urdf) != "urdf":  # their files are told by their places
        return out
    for mesh in urdf_text(urdf_source(urdf, packages)).root.iter("mesh"):
        name = mesh.get("filename", "")
        package, _, rest = name.removeprefix(PACKAGE).partition("/")
        if not name.startswith(PACKAGE) or package in packages or package in out:
            continue
        try:
            found = find_mesh(urdf, "", name, {})
        except ModelError:
            continue  # a mesh to look at only, which nothing here needs
        out[package] = found.parents[len(Path(rest).parts) - 1]
    return out


def moved_path(path: Path, folder: Path) -> str:
    """The relative path that leads from a folder to a file. Links in its folder are followed, the file's own is not."""
    real = Path(os.path.realpath(path.parent)) / path.name
    return Path(os.path.relpath(real, os.path.realpath(folder))).as_posix()
