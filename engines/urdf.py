"""Reading a URDF into the canonical `Model`, and writing a `Model` as a plain URDF."""

import logging
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

import defusedxml.ElementTree
import numpy as np
import yourdfpy
from defusedxml.common import DefusedXmlException

from engines.contact import contact_spheres
from engines.model import Array, Joint, Link, Model, ModelError, quaternion_from_rotation, rotation_from_quaternion

KNOWN_TYPES = ("revolute", "continuous", "prismatic", "fixed")


def read_urdf(
    path: Path, *, floating: bool, packages: Mapping[str, Path] | None = None, contact_links: list[str] | None = None
) -> Model:
    """The canonical model of a URDF file.

    Args:
        path: the URDF.
        floating: whether the root link moves freely.
        packages: where `package://NAME/` lies; without an entry, NAME is looked for beside and above the URDF.
        contact_links: URDF links whose collision shapes touch the ground (default: the root and the leaves).

    Raises:
        ModelError: for a file that is not a URDF or a robot that cannot be simulated, in one sentence.
    """
    robot = _parse(path)
    children: dict[str, list[yourdfpy.Joint]] = {}
    for joint in robot.joints:
        children.setdefault(joint.parent, []).append(joint)
    links = {link.name: link for link in robot.links}
    _check_tree(path, robot, links)
    root = next(link.name for link in robot.links if link.name not in {j.child for j in robot.joints})

    made_links: list[Link] = []
    made_joints: list[Joint] = []
    shapes: list[list[tuple[yourdfpy.Collision, Array]]] = []
    notes: list[str] = []

    def collect(name: str, pose: Array, parts: list[tuple[yourdfpy.Link, Array]], moving: list[tuple]) -> None:  # type: ignore[type-arg]
        """Everything that is fixed to a link, with its pose there, and the joints that move away from it."""
        parts.append((links[name], pose))
        for joint in children.get(name, []):
            origin = pose @ (np.eye(4) if joint.origin is None else joint.origin)
            if joint.type == "fixed":
                collect(joint.child, origin, parts, moving)
            else:
                moving.append((joint, origin))

    def build(name: str) -> None:
        parts: list[tuple[yourdfpy.Link, Array]] = []
        moving: list[tuple[yourdfpy.Joint, Array]] = []
        collect(name, np.eye(4), parts, moving)
        index = len(made_links)
        made_links.append(_lump(path, name, parts, needs_mass=index > 0 or floating))
        shapes.append(
            [(c, pose if c.origin is None else pose @ c.origin) for part, pose in parts for c in part.collisions]
        )
        for joint, origin in moving:
            made_joints.append(_joint(path, joint, origin, index))
            build(joint.child)

    build(root)
    if not floating and not made_joints:
        raise ModelError(f"{path}: nothing can move: the robot has no moving joint and a fixed base")
    parents = {j.parent for j in made_joints}
    chosen = [
        bool({*link.merged} & {*contact_links}) if contact_links is not None else i == 0 or i not in parents
        for i, link in enumerate(made_links)
    ]
    final = []
    for link, link_shapes, touches in zip(made_links, shapes, chosen, strict=True):
        spheres = contact_spheres(path, link.name, link_shapes, packages or {}) if touches and link_shapes else ()
        if link_shapes and not touches:
            notes.append(f"link {link.name} does not touch the ground: only the base and the last links do")
        final.append(Link(link.name, link.mass, link.com, link.inertia, spheres, link.merged))
    return Model(robot.name, tuple(final), tuple(made_joints), floating, tuple(notes))


def _parse(path: Path) -> yourdfpy.Robot:
    try:
        text = path.read_bytes()
    except OSError as error:
        raise ModelError(f"{path}: cannot be read ({error.strerror}); expected a URDF file") from None
    if path.suffix == ".xacro" or b"xacro:" in text:
        raise ModelError(
            f"{path}: is a xacro file, not a URDF; expand it first: xacro {path.name} > {path.name.split('.')[0]}.urdf"
        )
    try:
        tree = defusedxml.ElementTree.fromstring(text)
    except DefusedXmlException as error:
        raise ModelError(f"{path}: XML entities are not accepted in a URDF ({type(error).__name__})") from None
    except Exception as error:
        raise ModelError(f"{path}: is not well-formed XML ({error}); expected a URDF") from None
    if tree.tag != "robot":
        raise ModelError(f"{path}: the root element is <{tree.tag}>, expected <robot>")
    for number in tree.iter("mass"):
        _finite(path, "mass", number.get("value"))
    logging.getLogger("yourdfpy").setLevel(logging.ERROR)
    try:
        return yourdfpy.URDF.load(
            str(path),
            build_scene_graph=False,
            load_meshes=False,
            build_collision_scene_graph=False,
            load_collision_meshes=False,
        ).robot
    except Exception as error:
        raise ModelError(f"{path}: is not a usable URDF ({type(error).__name__}: {error})") from None


def _finite(path: Path, what: str, text: str | None) -> None:
    try:
        value = float(text or "")
    except ValueError:
        raise ModelError(f"{path}: {what} is {text!r}, expected a number") from None
    if not np.isfinite(value):
        raise ModelError(f"{path}: {what} is {text!r}, expected a finite number")


def _check_tree(path: Path, robot: yourdfpy.Robot, links: dict[str, yourdfpy.Link]) -> None:
    if not robot.links:
        raise ModelError(f"{path}: has no link")
    for kind, names in (("link", [x.name for x in robot.links]), ("joint", [x.name for x in robot.joints])):
        double = sorted({n for n in names if names.count(n) > 1})
        if double:
            raise ModelError(f"{path}: {kind} {double[0]} is defined {names.count(double[0])} times")
    seen: set[str] = set()
    for joint in robot.joints:
        for end in (joint.parent, joint.child):
            if end not in links:
                raise ModelError(f"{path}: joint {joint.name} names link {end}, which is not defined")
        if joint.child in seen:
            raise ModelError(f"{path}: link {joint.child} has two parent joints; expected a tree")
        seen.add(joint.child)
        if joint.type not in KNOWN_TYPES:
            raise ModelError(f"{path}: joint {joint.name} is {joint.type}; expected one of {', '.join(KNOWN_TYPES)}")
        if joint.mimic is not None:
            raise ModelError(f"{path}: joint {joint.name} mimics {joint.mimic.joint}; mimic joints are not supported")
    roots = [name for name in links if name not in seen]
    if len(roots) != 1:
        found = ", ".join(roots) or "none (a loop)"
        raise ModelError(f"{path}: expected one root link, found {found}")
    reached, todo = set(), [roots[0]]
    while todo:
        name = todo.pop()
        reached.add(name)
        todo += [j.child for j in robot.joints if j.parent == name]
    if len(reached) < len(links):
        raise ModelError(f"{path}: link {sorted(set(links) - reached)[0]} is not connected to root {roots[0]}")


def _lump(path: Path, name: str, parts: list[tuple[yourdfpy.Link, Array]], needs_mass: bool) -> Link:
    """One rigid body from a link and all that is fixed to it (parallel-axis theorem)."""
    bodies = []
    for part, pose in parts:
        inertial = part.inertial
        if inertial is None or inertial.mass is None:
            continue
        origin = pose @ (np.eye(4) if inertial.origin is None else inertial.origin)
        tensor = np.zeros((3, 3)) if inertial.inertia is None else np.asarray(inertial.inertia, dtype=float)
        _check_inertia(path, part.name, float(inertial.mass), tensor)
        bodies.append((float(inertial.mass), origin[:3, 3], origin[:3, :3] @ tensor @ origin[:3, :3].T))
    merged = tuple(part.name for part, _ in parts)
    mass = sum(m for m, _, _ in bodies)
    if mass <= 0:
        if needs_mass:
            raise ModelError(f"{path}: link {name} moves but has no mass; expected an <inertial> on it")
        return Link(name, 1.0, np.zeros(3), np.eye(3) * 1e-3, (), merged)
    com = sum((m * c for m, c, _ in bodies), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for m, c, tensor in bodies:
        d = c - com
        inertia += tensor + m * (d @ d * np.eye(3) - np.outer(d, d))
    return Link(name, mass, com, inertia, (), merged)


def _check_inertia(path: Path, name: str, mass: float, tensor: Array) -> None:
    if mass < 0:
        raise ModelError(f"{path}: link {name} has mass {mass:g} kg, expected a positive one")
    if not np.isfinite(tensor).all():
        raise ModelError(f"{path}: link {name} has an inertia that is not finite")
    moments = np.linalg.eigvalsh(tensor)
    small = 1e-6 * max(moments[2], 1e-12)
    if moments[0] < -small or moments[0] + moments[1] < moments[2] - small:
        found = ", ".join(f"{m:.3g}" for m in moments)
        raise ModelError(
            f"{path}: link {name} has principal moments of inertia {found} kg·m², which no body has; expected all to be "
            "positive and none larger than the other two together"
        )


def _joint(path: Path, joint: yourdfpy.Joint, origin: Array, parent: int) -> Joint:
    axis = np.array([1.0, 0.0, 0.0]) if joint.axis is None else np.asarray(joint.axis, dtype=float)
    norm = float(np.linalg.norm(axis))
    if not norm > 0:
        raise ModelError(f"{path}: joint {joint.name} has axis {axis}, expected a direction")
    limit, dynamics = joint.limit, joint.dynamics

    def value(source: object, key: str, default: float) -> float:
        found = getattr(source, key, None)
        return default if found is None else float(found)

    unlimited = joint.type == "continuous" or limit is None
    lower = -np.inf if unlimited else value(limit, "lower", 0.0)
    upper = np.inf if unlimited else value(limit, "upper", 0.0)
    if lower > upper:
        raise ModelError(f"{path}: joint {joint.name} has lower limit {lower:g} above its upper limit {upper:g}")
    return Joint(
        name=joint.name,
        prismatic=joint.type == "prismatic",
        parent=parent,
        origin=origin,
        axis=axis / norm,
        lower=lower,
        upper=upper,
        effort=value(limit, "effort", np.inf) or np.inf,
        velocity=value(limit, "velocity", np.inf) or np.inf,
        friction=value(dynamics, "friction", 0.0),
        damping=value(dynamics, "damping", 0.0),
    )


def rpy_from_rotation(rotation: Array) -> tuple[float, float, float]:
    """URDF's roll, pitch, yaw [rad] of a rotation matrix; yaw is 0 at the pole."""
    pitch = float(np.arctan2(-rotation[2, 0], np.hypot(rotation[0, 0], rotation[1, 0])))
    if np.hypot(rotation[0, 0], rotation[1, 0]) < 1e-12:
        return float(np.arctan2(-rotation[1, 2], rotation[1, 1])), pitch, 0.0
    return float(np.arctan2(rotation[2, 1], rotation[2, 2])), pitch, float(np.arctan2(rotation[1, 0], rotation[0, 0]))


def write_urdf(model: Model, *, spheres: bool = True) -> str:
    """The model as a URDF: inertials and joints only, with its contact spheres as collision where asked for.

    Limits, effort, friction and damping are left out: they are the adapter's to set. Numbers have 17 digits, so that
    every engine reads the same machine; rotations are cleaned of rounding first.
    """
    lines = [f"<robot name={quoteattr(model.name)}>"]
    for link in model.links:
        lines.append(f"<link name={quoteattr(link.name)}><inertial><origin xyz={_xyz(link.com)}/>")
        i = link.inertia
        lines.append(
            f'<mass value="{link.mass!r}"/><inertia ixx="{float(i[0, 0])!r}" ixy="{float(i[0, 1])!r}" '
            f'ixz="{float(i[0, 2])!r}" iyy="{float(i[1, 1])!r}" iyz="{float(i[1, 2])!r}" izz="{float(i[2, 2])!r}"/></inertial>'
        )
        for sphere in link.spheres if spheres else ():
            lines.append(
                f"<collision><origin xyz={_xyz(sphere.center)}/><geometry>"
                f'<sphere radius="{sphere.radius!r}"/></geometry></collision>'
            )
        lines.append("</link>")
    for i, joint in enumerate(model.joints):
        rotation = rotation_from_quaternion(quaternion_from_rotation(joint.origin[:3, :3]))
        kind = "prismatic" if joint.prismatic else "continuous"
        lines.append(
            f'<joint name={quoteattr(joint.name)} type="{kind}">'
            f"<origin xyz={_xyz(joint.origin[:3, 3])} rpy={_xyz(np.array(rpy_from_rotation(rotation)))}/>"
            f"<parent link={quoteattr(model.links[joint.parent].name)}/><child link={quoteattr(model.links[i + 1].name)}/>"
            f"<axis xyz={_xyz(joint.axis)}/>"
            + ('<limit lower="-1e9" upper="1e9" effort="1e9" velocity="1e9"/>' if joint.prismatic else "")
            + "</joint>"
        )
    return "\n".join([*lines, "</robot>", ""])


def _xyz(vector: Array) -> str:
    return '"' + " ".join(repr(float(v)) for v in vector) + '"'
