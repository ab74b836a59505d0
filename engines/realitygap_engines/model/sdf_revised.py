"""A SDF file with other masses, centres of mass and inertias, which may lie in another folder; all else stays."""

import os
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from defusedxml.ElementTree import DefusedXMLParser

from realitygap_engines.model.inertial_editor import ENTRIES
from realitygap_engines.model.robot import Array, Link
from realitygap_engines.model.sdf import link_frames

NOTHING = 1e-12
"""Mass [kg] and inertia [kg·m²] of what is counted elsewhere: SDF has no link without."""


def revised_sdf(path: Path, folder: Path, links: Sequence[Link]) -> str:
    """The text of a SDF file for another folder, with the inertials of these links.

    What is fixed to a link is part of it, so the links merged into it weigh next to nothing.
    """
    parser = DefusedXMLParser(target=ET.TreeBuilder(insert_comments=True))
    parser.feed(path.read_text(encoding="utf-8"))
    root: ET.Element = parser.close()
    elements = {e.get("name"): e for e in root.iter("link")}
    frames = link_frames(path)
    for link in links:
        pose = frames.get(link.name, np.eye(4))
        turn = pose[:3, :3]
        _write(elements[link.name], link.mass, turn @ link.com + pose[:3, 3], turn @ link.inertia @ turn.T)
        for name in link.merged[1:]:
            _write(elements[name], NOTHING, np.zeros(3), NOTHING * np.eye(3))
    for uri in root.iter("uri"):
        text = (uri.text or "").strip()
        if text and "://" not in text and not text.startswith("/"):
            moved = os.path.relpath(os.path.realpath(path.parent / text), os.path.realpath(folder))
            uri.text = Path(moved).as_posix()
    return ET.tostring(root, encoding="unicode") + "\n"


def _write(element: ET.Element, mass: float, com: Array, inertia: Array) -> None:
    for old in element.findall("inertial"):
        element.remove(old)
    inertial = ET.SubElement(element, "inertial")
    ET.SubElement(inertial, "pose").text = " ".join([*(repr(float(v)) for v in com), "0 0 0"])
    ET.SubElement(inertial, "mass").text = repr(float(mass))
    tensor = ET.SubElement(inertial, "inertia")
    for name, ij in ENTRIES.items():
        ET.SubElement(tensor, name).text = repr(float(inertia[ij]))
    ET.indent(inertial, level=3)
