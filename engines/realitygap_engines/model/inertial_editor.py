"""The one editor of inertials: a URDF with other masses, centres of mass and inertias; all else stays as written."""

import copy
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, replace

from defusedxml.ElementTree import DefusedXMLParser

from realitygap_engines.model.inertia import Inertial

ENTRIES = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}


@dataclass(frozen=True)
class UrdfText:
    """A URDF as a tree that can be edited.

    `head` is the text before the root element; `spaced` says whether empty elements are written `<a />`.
    """

    head: str
    spaced: bool
    root: ET.Element

    def written(self) -> str:
        """The file's text."""
        text = ET.tostring(self.root, encoding="unicode")
        return self.head + (text if self.spaced else text.replace(" />", "/>")) + "\n"


def urdf_text(text: str) -> UrdfText:
    """The tree of a URDF's text, with its comments.

    Raises:
        ParseError: for what is not well-formed XML.
        DefusedXmlException: for XML entities.
    """
    parser = DefusedXMLParser(target=ET.TreeBuilder(insert_comments=True))
    parser.feed(text)
    root: ET.Element = parser.close()
    start = text.find(f"<{root.tag}")
    return UrdfText(text[:start], " />" in text or "/>" not in text, root)


def with_inertials(urdf: UrdfText, bodies: Mapping[str, Inertial | None], *, digits: int | None = None) -> UrdfText:
    """The same with the inertials of these links: mass, centre of mass and inertia about it in the link's axes.

    Args:
        urdf: what is edited; it stays as it is.
        bodies: by the link's name; None takes a link's inertial away. Names that the file does not have do nothing.
        digits: significant digits of the numbers; all by default, so that the same machine is read back.
    """
    root = copy.deepcopy(urdf.root)
    for element in root.findall("link"):
        name = element.get("name", "")
        if name not in bodies:
            continue
        body, inertial = bodies[name], element.find("inertial")
        if body is not None:
            _write(element, inertial, body, digits)
        elif inertial is not None:
            element.remove(inertial)
    return replace(urdf, root=root)


def _write(link: ET.Element, inertial: ET.Element | None, body: Inertial, digits: int | None) -> None:
    mass, com, inertia = body

    def number(value: float) -> str:
        return repr(float(value)) if digits is None else f"{value:.{digits}g}"

    added = inertial is None
    if inertial is None:
        inertial = ET.SubElement(link, "inertial")
    values = {
        "origin": {"xyz": " ".join(number(v) for v in com), "rpy": "0 0 0"},
        "mass": {"value": number(mass)},
        "inertia": {name: number(inertia[ij]) for name, ij in ENTRIES.items()},
    }
    for tag, attributes in values.items():
        child = inertial.find(tag)
        if child is None:
            child, added = ET.SubElement(inertial, tag), True
        child.attrib.update(attributes)
    if added:
        ET.indent(inertial, level=2)
        inertial.tail = inertial.tail or "\n  "
