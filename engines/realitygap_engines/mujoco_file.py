"""The machine of the MuJoCo adapter as a MJCF file, number by number, so that plain MuJoCo simulates the same.

The adapter's integrator, `discrete`, takes what is native at the end of a step: damping, and position gains too, which
the servos of our law have at its start. Without ground the file is stepped by `Euler` with explicit damping instead,
where neither matters. `discrete` has dry friction at the end of a step, too, f·R = −B·v' − a: to `Euler` that is a row
with B/(1 + h·B) in place of B. Contacts have no such translation, so that on the ground the file keeps `discrete`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

import mujoco
import numpy as np

from realitygap_engines.engine import Physics
from realitygap_engines.model.robot import Array, Joint, Model, quaternion_from_rotation
from realitygap_engines.mujoco import FRICTION_SOLIMP, FRICTION_SOLREF, build_spec, soften

COMPILER = {
    "angle": "radian",
    "autolimits": "false",
    "fusestatic": "false",
    "boundmass": "0",
    "boundinertia": "0",
    "balanceinertia": "false",
    "inertiafromgeom": "false",
}


@dataclass(frozen=True)
class Spring:
    """A spring on a joint: `stiffness` [N·m/rad or N/m], at rest at `rest` [rad or m]."""

    stiffness: float = 0.0
    rest: float = 0.0


JointValues = tuple[Joint, float, Spring, tuple[float, float]]
"""A joint, its offset and spring, and the solref of its dry friction."""


def mjcf_text(
    model: Model,
    physics: Physics,
    *,
    base: Array,
    offset: Array,
    springs: Sequence[Spring],
    actuators: Sequence[Element],
    comments: Sequence[str] = (),
) -> str:
    """A MJCF file of a model.

    Args:
        model: with the damping, friction and armature that the file gives its joints.
        physics: time step, ground and gravity.
        base: the rotation (3, 3) of a fixed base.
        offset: what to add to a joint's position in the file for its true one, [rad or m]. Shape (n,).
        springs: one for each joint.
        actuators: elements of `<actuator>`, in the order of their controls.
        comments: what stands at the head of the file, one line each.
    """
    spec = build_spec(model, physics)
    compiled = spec.compile()
    if physics.ground is not None and physics.ground.stiffness is not None:
        soften(compiled, physics.ground)
    root = Element("mujoco", model=model.name or "robot")
    for line in comments:
        root.append(Comment(f" {line.replace('--', '- -')} "))
    SubElement(root, "compiler", COMPILER)
    discrete = steps_as_adapter(physics)
    root.append(_option(spec.option, discrete))
    world = SubElement(root, "worldbody")
    for geom in spec.worldbody.geoms:
        world.append(_geom(geom))
    solref = FRICTION_SOLREF if discrete else _explicit(physics.timestep)
    joints = {j.name: (j, float(o), s, solref) for j, o, s in zip(model.joints, offset, springs, strict=True)}
    for body in spec.worldbody.bodies:
        world.append(_body(body, joints, None if model.floating else base))
    if compiled.npair:
        contact = SubElement(root, "contact")
        for i, pair in enumerate(spec.pairs):
            contact.append(_pair(pair, compiled, i))
    followers = [(j.name, j.mimic) for j in model.joints if j.mimic is not None]
    if followers:
        equality = SubElement(root, "equality")
    for name, mimic in followers:  # MuJoCo counts from `ref`, which takes the offsets of both encoders away
        stiff = {"solref": numbers((2 * physics.timestep, 1.0)), "solimp": "0.9999 0.9999 0.001 0.5 2"}
        polynomial = numbers((mimic.offset, mimic.multiplier, 0, 0, 0))
        SubElement(equality, "joint", stiff, joint1=name, joint2=mimic.joint, polycoef=polynomial)
    if actuators:
        SubElement(root, "actuator").extend(actuators)
    indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + tostring(root, encoding="unicode") + "\n"


def steps_as_adapter(physics: Physics) -> bool:
    """Whether the file has the adapter's integrator, `discrete`; else `Euler` without implicit damping."""
    return physics.ground is not None


def numbers(values: Any) -> str:
    """Numbers as MJCF writes them, with all their digits."""
    return " ".join(f"{v:.17g}" for v in np.atleast_1d(np.asarray(values, dtype=float)))


def _option(option: Any, discrete: bool) -> Element:
    element = Element(
        "option",
        timestep=numbers(option.timestep),
        gravity=numbers(option.gravity),
        integrator="discrete" if discrete else "Euler",
        cone="elliptic",
        impratio=numbers(option.impratio),
        tolerance=numbers(option.tolerance),
        iterations=str(option.iterations),
    )
    flag = SubElement(element, "flag", autoreset="disable")
    if not discrete:
        flag.set("eulerdamp", "disable")
    return element


def _body(
    body: Any, joints: dict[str, tuple[Joint, float, Spring, tuple[float, float]]], turned: Array | None
) -> Element:
    element = Element("body", name=body.name, pos=numbers(body.pos), quat=numbers(body.quat))
    if turned is not None:
        element.set("quat", numbers(quaternion_from_rotation(turned)))
    for joint in body.joints:
        if joint.type == mujoco.mjtJoint.mjJNT_FREE:
            SubElement(element, "freejoint", name="base")
        else:
            element.append(_joint(joint, *joints[joint.name]))
    SubElement(
        element, "inertial", pos=numbers(body.ipos), mass=numbers(body.mass), fullinertia=numbers(body.fullinertia)
    )
    for geom in body.geoms:
        element.append(_geom(geom))
    for child in body.bodies:
        element.append(_body(child, joints, None))
    return element


def _explicit(h: float) -> tuple[float, float]:
    """The solref of dry friction whose row has B/(1 + h·B), where B = 2/(dmax·timeconst) is the adapter's."""
    (timeconst, ratio), dmax = FRICTION_SOLREF, FRICTION_SOLIMP[1]
    return timeconst + 2.0 * h / dmax, ratio


def _joint(spec: Any, joint: Joint, offset: float, spring: Spring, solref: tuple[float, float]) -> Element:
    element = Element(
        "joint",
        name=spec.name,
        type="slide" if joint.prismatic else "hinge",
        axis=numbers(spec.axis),
        armature=numbers(joint.armature),
        damping=numbers(joint.damping),
        frictionloss=numbers(joint.friction),
        solreffriction=numbers(solref),
        solimpfriction=numbers(spec.solimp_friction),
    )
    if offset:
        element.set("ref", numbers(-offset))
    if spring.stiffness:
        element.set("stiffness", numbers(spring.stiffness))
        element.set("springref", numbers(spring.rest - offset))
    if spec.limited:
        element.set("limited", "true")
        element.set("range", numbers(np.asarray(spec.range) - offset))
        element.set("solreflimit", numbers(spec.solref_limit))
        element.set("solimplimit", numbers(spec.solimp_limit))
    return element


def _geom(geom: Any) -> Element:
    plane = geom.type == mujoco.mjtGeom.mjGEOM_PLANE
    element = Element(
        "geom",
        name=geom.name,
        type="plane" if plane else "sphere",
        size=numbers(geom.size if plane else geom.size[:1]),
        pos=numbers(geom.pos),
        contype=str(geom.contype),
        conaffinity=str(geom.conaffinity),
    )
    if not plane:
        element.set("priority", str(geom.priority))
        element.set("condim", str(geom.condim))
        element.set("friction", numbers(geom.friction))
        element.set("solref", numbers(geom.solref))
        element.set("solimp", numbers(geom.solimp))
        element.set("mass", "0")
    return element


def _pair(pair: Any, compiled: Any, i: int) -> Element:
    return Element(
        "pair",
        geom1=pair.geomname1,
        geom2=pair.geomname2,
        condim=str(pair.condim),
        friction=numbers(pair.friction),
        solref=numbers(compiled.pair_solref[i]),
        solimp=numbers(compiled.pair_solimp[i]),
        solreffriction=numbers(pair.solreffriction),
    )
