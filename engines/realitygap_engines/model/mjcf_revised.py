"""A MJCF file with other masses, centres of mass and inertias, which may lie in another folder; all else stays."""

import os
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from defusedxml.ElementTree import DefusedXMLParser

from realitygap_engines.errors import ModelError
from realitygap_engines.model.mjcf_file import compile_mjcf
from realitygap_engines.model.robot import Array, Link

FOLDERS = {"mesh": "meshdir", "hfield": "meshdir", "skin": "meshdir", "texture": "texturedir"}
"""Where the files of an asset lie, by attributes of `<compiler>`; `assetdir` stands for both."""
NOTHING = {"pos": "0 0 0", "mass": "0", "diaginertia": "0 0 0"}


def revised_mjcf(path: Path, folder: Path, links: Sequence[Link]) -> str:
    """The text of a MJCF file for another folder, with the inertials of these links; what it includes is part of it.

    What is fixed to a link is part of it, so the bodies merged into it weigh nothing.

    Raises:
        ModelError: for a body that the file does not spell out, because it attaches or repeats a part.
    """
    m = compile_mjcf(path)
    root = _expanded(path, path.parent, ())
    compiler = {k: v for element in root.iter("compiler") for k, v in element.attrib.items()}
    if links and (compiler.get("inertiafromgeom") == "true" or float(compiler.get("settotalmass", -1)) > 0):
        _spell_out(root, m)
    bodies = {e.get("name"): e for e in root.iter("body")}
    for link in links:
        for name in link.merged:
            if name not in bodies:
                raise ModelError(
                    f"{path}: body {name} is not spelled out in the file, so that its inertia cannot be changed there; "
                    "expected it as an element <body> (MuJoCo's compile saves a file like that)"
                )
        for name in link.merged[1:]:
            _write(bodies[name], NOTHING)
        com = link.com + _anchor(m, link.name)
        _write(bodies[link.name], _inertial(link.mass, com, link.inertia))
    _move_assets(root, compiler, path, folder)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _expanded(path: Path, main: Path, above: tuple[Path, ...]) -> ET.Element:
    parser = DefusedXMLParser(target=ET.TreeBuilder(insert_comments=True))
    parser.feed(path.read_text(encoding="utf-8"))
    root: ET.Element = parser.close()
    for parent in list(root.iter()):
        for i, child in reversed(list(enumerate(parent))):
            if child.tag == "include":
                name = child.get("file", "")
                found = next((p for p in (main / name, path.parent / name) if p.is_file()), main / name)
                if found in above:
                    raise ModelError(f"{path}: includes itself through {name}")
                parent.remove(child)
                for k, part in enumerate(_expanded(found, main, (*above, found))):
                    parent.insert(i + k, part)
    return root


def _spell_out(root: ET.Element, m: Any) -> None:
    """Every body's own inertial, where the file has them computed or scaled."""
    for element in root.iter("body"):
        name = element.get("name")
        if name:
            b = m.body(name).id
            values = {"pos": m.body_ipos[b], "quat": m.body_iquat[b], "diaginertia": m.body_inertia[b]}
            _write(element, {"mass": repr(float(m.body_mass[b])), **{k: _text(v) for k, v in values.items()}})
    for compiler in root.iter("compiler"):
        compiler.attrib.pop("settotalmass", None)
        compiler.set("inertiafromgeom", "auto")


def _anchor(m: Any, body: str) -> Array:
    """Where the frame of a link lies in its body's: at the position of a hinge. Shape (3,)."""
    b = m.body(body).id
    joint = int(m.body_jntadr[b])
    hinge = joint >= 0 and int(m.jnt_type[joint]) == 3
    return np.array(m.jnt_pos[joint]) if hinge else np.zeros(3)


def _inertial(mass: float, com: Array, inertia: Array) -> dict[str, str]:
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia.tolist()
    return {"pos": _text(com), "mass": repr(float(mass)), "fullinertia": _text(np.array([xx, yy, zz, xy, xz, yz]))}


def _write(body: ET.Element, inertial: dict[str, str]) -> None:
    for old in body.findall("inertial"):
        body.remove(old)
    body.insert(0, ET.Element("inertial", inertial))


def _move_assets(root: ET.Element, compiler: dict[str, str], path: Path, folder: Path) -> None:
    both = compiler.get("assetdir", "")
    for element in root.iter():
        if element.tag in FOLDERS and element.get("file"):
            where = path.parent / compiler.get(FOLDERS[element.tag], both) / element.get("file", "")
            name = str(os.path.relpath(os.path.realpath(where), os.path.realpath(folder)))
            element.set("file", Path(name).as_posix())
    for element in root.iter("compiler"):
        for key in ("assetdir", "meshdir", "texturedir"):
            element.attrib.pop(key, None)


def _text(values: Array) -> str:
    return " ".join(repr(float(v)) for v in values)
