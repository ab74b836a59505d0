"""What a URDF file must be before it is read: well-formed, harmless, with numbers where numbers belong, and a tree."""

import io
import math
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

import defusedxml.ElementTree
import yourdfpy
from defusedxml.common import DefusedXmlException

from realitygap_engines.errors import ModelError
from realitygap_engines.model.quiet import quiet
from realitygap_engines.model.xacro_file import expanded, is_xacro

JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed")
FLOATING = "floating"
"""The type of a joint that says that its child is the robot's base and moves freely."""
LONGEST_NAME = 1000
"""Characters of a name: PyBullet dies of longer ones."""
FAR, MANY = 1e4, 1e9
"""[m] Nothing on a machine is farther, and in any unit no number of one larger, but for a limit that is none."""
LARGEST = {"origin": FAR, "box": FAR, "cylinder": FAR, "sphere": FAR, "dynamics": MANY, "mimic": MANY, "mesh": MANY}
"""Element -> the largest number that any machine has there; masses and inertias are checked where they are lumped."""
NUMBERS = {  # element -> attribute -> how many numbers
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "mass": {"value": 1},
    "inertia": {"ixx": 1, "ixy": 1, "ixz": 1, "iyy": 1, "iyz": 1, "izz": 1},
    "limit": {"lower": 1, "upper": 1, "effort": 1, "velocity": 1},
    "dynamics": {"damping": 1, "friction": 1},
    "mimic": {"multiplier": 1, "offset": 1},
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "mesh": {"scale": 3},
}
POSITIVE = {"mass": ("value",), "dynamics": ("damping", "friction"), "limit": ("effort", "velocity")}
"""Element -> attributes that are no negative number."""
NEEDED = {"mass", "inertia", "box", "cylinder", "sphere"}
"""Elements whose attributes must all be there."""
SIZES = {"box", "cylinder", "sphere"}


def parse_urdf(path: Path, packages: Mapping[str, Path] | None = None) -> yourdfpy.Robot:
    """The links and joints of a URDF or xacro file; visuals, materials, transmissions and extensions are dropped.

    Raises:
        ModelError: for a file that is not a URDF of a tree of links, in one sentence.
    """
    root = _root(path, packages or {})
    for other in [child for child in root if child.tag not in ("link", "joint")]:
        root.remove(other)
    for link in root.iterfind("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    for part in root:
        _check_part(path, part)
    try:
        with quiet("yourdfpy"):  # what it complains about is said here
            robot = yourdfpy.URDF.load(
                io.BytesIO(ElementTree.tostring(root)),
                build_scene_graph=False,
                load_meshes=False,
                build_collision_scene_graph=False,
                load_collision_meshes=False,
            ).robot
    except Exception as error:
        raise ModelError(f"{path}: is not a usable URDF ({type(error).__name__}: {error})") from None
    _check_tree(path, robot)
    return robot


def _root(path: Path, packages: Mapping[str, Path]) -> ElementTree.Element:
    try:
        text = path.read_bytes()
    except OSError as error:
        raise ModelError(f"{path}: cannot be read ({error.strerror}); expected a URDF file") from None
    if is_xacro(path, text):
        text = expanded(path, packages)
    try:
        root: ElementTree.Element = defusedxml.ElementTree.fromstring(text)
    except DefusedXmlException as error:
        raise ModelError(f"{path}: found XML entities ({type(error).__name__}), expected a URDF without them") from None
    except (ElementTree.ParseError, ValueError, LookupError) as error:  # ValueError, LookupError: its encoding
        raise ModelError(f"{path}: is not well-formed XML ({error}); expected a URDF") from None
    if root.tag != "robot":
        raise ModelError(f"{path}: the root element is <{root.tag}>, expected <robot>")
    root.attrib.setdefault("name", path.stem)
    return root


def _check_part(path: Path, part: ElementTree.Element) -> None:
    """A link or joint has a name, a joint two ends, and numbers are numbers."""
    name = part.get("name")
    if not name:
        raise ModelError(f"{path}: a {part.tag} has no name, expected one")
    if len(name) > LONGEST_NAME:
        raise ModelError(
            f"{path}: {part.tag} {name[:20]}... has a name of {len(name)} characters, expected at most {LONGEST_NAME}"
        )
    for end in ("parent", "child") if part.tag == "joint" else ():
        element = part.find(end)
        if element is None or not element.get("link"):
            raise ModelError(f'{path}: joint {name} has no {end}, expected <{end} link="..."/>')
    for element in part.iter():
        if element.tag == "mesh" and not element.get("filename"):
            raise ModelError(f"{path}: {part.tag} {name}: mesh has no filename, expected the path of one")
        for attribute, count in NUMBERS.get(element.tag, {}).items():
            text = element.get(attribute)
            if text is None and element.tag in NEEDED:
                raise ModelError(f"{path}: {part.tag} {name}: {element.tag} has no {attribute}, expected a number")
            if text is not None:
                what = f"{path}: {part.tag} {name}: {element.tag} {attribute}"
                _check_numbers(what, element.tag, text, count, positive=attribute in POSITIVE.get(element.tag, ()))


def _check_numbers(what: str, tag: str, text: str, count: int, *, positive: bool) -> None:
    expected = "a finite number" if count == 1 else f"{count} finite numbers with spaces between them"
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        raise ModelError(f"{what} is {text!r}, expected {expected}") from None
    endless = tag == "limit" and not any(math.isnan(v) for v in values)
    if len(values) != count or not (endless or all(math.isfinite(v) for v in values)):
        raise ModelError(f"{what} is {text!r}, expected {expected}")
    if max(map(abs, values)) > LARGEST.get(tag, math.inf):
        raise ModelError(f"{what} is {text!r}, which no machine has; expected at most {LARGEST[tag]:g}")
    if tag in SIZES and min(values) <= 0:
        raise ModelError(f"{what} is {text!r}, expected more than 0 m")
    if positive and min(values) < 0:
        raise ModelError(f"{what} is {text!r}, expected no negative number")


def _check_tree(path: Path, robot: yourdfpy.Robot) -> None:
    links = {link.name for link in robot.links}
    if not links:
        raise ModelError(f"{path}: has no link, expected at least one")
    for kind, names in (("link", [x.name for x in robot.links]), ("joint", [x.name for x in robot.joints])):
        double = sorted({n for n in names if names.count(n) > 1})
        if double:
            raise ModelError(
                f"{path}: {kind} {double[0]} is defined {names.count(double[0])} times, expected every name once"
            )
    children: dict[str, list[str]] = {}
    seen: set[str] = set()
    for joint in robot.joints:
        _check_joint(path, joint, links)
        if joint.child in seen:
            raise ModelError(f"{path}: link {joint.child} has two parent joints; expected a tree")
        seen.add(joint.child)
        children.setdefault(joint.parent, []).append(joint.child)
    roots = sorted(links - seen)
    if len(roots) != 1:
        found = ", ".join(roots) or "none (a loop)"
        raise ModelError(f"{path}: expected one root link, found {found}")
    reached, todo = set(), list(roots)
    while todo:
        name = todo.pop()
        reached.add(name)
        todo += children.get(name, [])
    if len(reached) < len(links):
        raise ModelError(f"{path}: link {min(links - reached)} is in a loop of joints; expected a tree")
    for joint in robot.joints:
        if joint.type == FLOATING:
            _check_floating(path, joint, robot, roots[0])


def _check_floating(path: Path, joint: yourdfpy.Joint, robot: yourdfpy.Robot, root: str) -> None:
    """A joint that floats may only join the robot to a root link that is none of its bodies."""
    (link,) = [link for link in robot.links if link.name == root]
    others = [other.name for other in robot.joints if other.parent == root and other is not joint]
    found = ""
    if joint.parent != root:
        found = f"hangs on link {joint.parent}"
    elif link.inertial is not None or link.collisions:
        found = f"hangs on the root link {root}, which has a mass or a shape of its own"
    elif others:
        found = f"hangs on the root link {root} beside joint {others[0]}"
    if found:
        raise ModelError(
            f"{path}: joint {joint.name} is floating and {found}; expected it between an empty root link and the "
            f"robot's base alone, which moves freely then; make it one of {', '.join(JOINT_TYPES)}"
        )


def _check_joint(path: Path, joint: yourdfpy.Joint, links: set[str]) -> None:
    for end in (joint.parent, joint.child):
        if end not in links:
            raise ModelError(f"{path}: joint {joint.name} names link {end}, which is not defined")
    if joint.type not in (*JOINT_TYPES, FLOATING):
        raise ModelError(
            f"{path}: joint {joint.name} is {joint.type or 'of no type'}; expected one of {', '.join(JOINT_TYPES)}"
        )
