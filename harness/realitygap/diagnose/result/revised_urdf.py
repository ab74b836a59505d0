"""A URDF with other masses, centres of mass and inertias, which may lie in another folder; all else stays."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from pathlib import Path

from defusedxml.ElementTree import DefusedXMLParser
from realitygap_engines.errors import ModelError
from realitygap_engines.model.contact import find_mesh
from realitygap_engines.model.robot import Link

ENTRIES = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
PACKAGE = "package://"


def revised_urdf(urdf: Path, folder: Path, links: Sequence[Link]) -> str:
    """The text of a URDF for another folder, with the inertials of these links.

    What is fixed to a link is part of it, so the inertials of the links merged into it are taken out.
    """
    root = _read(urdf)
    elements = {e.get("name"): e for e in root.iter("link")}
    for link in links:
        for name in link.merged[1:]:
            inertial = elements[name].find("inertial")
            if inertial is not None:
                elements[name].remove(inertial)
        _write(elements[link.name], link)
    for mesh in root.iter("mesh"):
        name = mesh.get("filename", "")
        if name and not name.startswith(PACKAGE):
            moved = moved_path(urdf.parent / name.removeprefix("file://"), folder)
            mesh.set("filename", moved if name[0] != "/" and "://" not in name else name)
    return ET.tostring(root, encoding="unicode") + "\n"


def found_packages(urdf: Path, packages: Mapping[str, Path]) -> dict[str, Path]:
    """The packages of a URDF's meshes that are found beside or above it only, and where they lie."""
    out: dict[str, Path] = {}
    for mesh in _read(urdf).iter("mesh"):
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


def _read(urdf: Path) -> ET.Element:
    parser = DefusedXMLParser(target=ET.TreeBuilder(insert_comments=True))
    parser.feed(urdf.read_text(encoding="utf-8"))
    root: ET.Element = parser.close()
    return root


def _write(element: ET.Element, link: Link) -> None:
    """Put a link's mass, centre of mass and inertia about it, in link axes, in place of what was there."""
    inertial = element.find("inertial")
    if inertial is None:
        inertial = ET.SubElement(element, "inertial")
    for child in list(inertial):
        inertial.remove(child)
    ET.SubElement(inertial, "origin", xyz=" ".join(repr(float(v)) for v in link.com), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=repr(float(link.mass)))
    ET.SubElement(inertial, "inertia", {name: repr(float(link.inertia[ij])) for name, ij in ENTRIES.items()})
    ET.indent(inertial, level=2)
    inertial.tail = inertial.tail or "\n  "
