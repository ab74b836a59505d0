"""Masses and inertias that no link has, or that no servo of the robot could move as it was measured."""

from collections.abc import Sequence

import numpy as np
from realitygap_engines import GRAVITY
from realitygap_engines.law.dynamics import Dynamics
from realitygap_engines.model.robot import Model
from scipy.signal import savgol_filter

from realitygap.check.mistake import Mistake
from realitygap.check.observed import Observed
from realitygap.check.servo import limit, stiffness
from realitygap.check.words import joined
from realitygap.robot.plant import Plant
from realitygap.trace.trace import Array

WIDE, ABSURD = 5.0, 30.0
"""A body whose mass lies further from its centre than this many times the robot's reach is none; the second certain."""
HEAVY = 30.0
"""A robot that needs this many times more effort than its servos gave is not of that mass: gains and constants are off
by less than `WEAK`, and friction comes on top."""
LIGHT = 1e-3 * 6.0
"""And one that needs this share of it or less is not either, unless friction is all there is: a servo whose effort was
measured was then 170 times too large."""
ODD = 100.0
"""A single link that is this many times heavier than the next is in another unit: 30 is a rotor beside its housing."""
THOUSAND = 1000.0
SMOOTHED = 0.15
"""s: over which positions are smoothed for accelerations."""
SAMPLES = 200


def link_mistakes(plant: Plant) -> list[Mistake]:
    """Inertias that are far too large for the size of a robot, and a link that is far heavier than all others."""
    model = plant.model
    reach = _reach(model)
    out = []
    first = 0 if model.floating else 1
    for i in range(first, len(model.links)):
        link = model.links[i]
        if reach <= 0 or not _turns(model, i):
            continue
        gyration = float(np.sqrt(np.linalg.eigvalsh(link.inertia)[-1] / link.mass))
        if gyration > WIDE * reach:
            sentence = (
                f"the inertia of link {link.name} puts its mass of {link.mass:.3g} kg {gyration:.3g} m from its centre, "
                f"and the whole robot reaches {reach:.3g} m: an inertia in another unit than kg·m², or a mass in "
                "another than kg; expected both to fit the link's size"
            )
            certainty = "certain" if gyration > ABSURD * reach else "likely"
            out.append(Mistake("impossible_link", certainty, _joint_of(model, i), sentence, "robot.urdf"))
    masses = np.array([link.mass for link in model.links[first:]])
    if len(masses) > 2:
        order = np.argsort(masses)
        heaviest, after = masses[order[-1]], masses[order[-2]]
        if heaviest > ODD * after and heaviest > 20.0 and np.median(masses) > 1e-3:
            link = model.links[first + int(order[-1])]
            sentence = (
                f"link {link.name} weighs {heaviest:.4g} kg and the next heaviest {after:.3g} kg: grams, as it seems; "
                "expected kg"
            )
            out.append(Mistake("grams", "certain", _joint_of(model, first + int(order[-1])), sentence, "robot.urdf"))
    return out


def load_mistakes(observed: Sequence[Observed]) -> list[Mistake]:
    """Masses that the servos could not have moved as measured, by a factor of a thousand; of robots that stand fixed.

    The effort that the measured motion needs (rigid bodies, no friction) beside the measured effort or, where there is
    none, beside what the servos gave at most for the measured errors.
    """
    for o in observed:
        if o.plant.model.floating or not o.follows.any() or len(o.clock) < 20:
            continue
        needed, given = np.sqrt(np.mean(needed_effort(o) ** 2, axis=0)), _given(o)
        judged = np.isfinite(given) & (given > 0) & (o.follows | np.isfinite(_measured(o)))
        if not judged.any():
            continue
        ratio = np.where(judged, needed / np.where(judged, given, 1.0), 0.0)
        j = int(np.argmax(ratio))
        unit = "N" if o.prismatic(j) else "N·m"
        if ratio[j] > HEAVY:
            sentence = (
                f"moving {o.joints[j]} as measured takes {needed[j]:.3g} {unit} (rms), and its servo gave about "
                f"{given[j]:.2g} {unit}: masses a thousand times too large, as of grams, or inertias; expected kg and "
                "kg·m²"
            )
            return [Mistake("grams", "certain", _suspects(o, j), sentence, "robot.urdf", (o.name,))]
        if ratio[judged].max() < LIGHT and judged.all():
            sentence = (
                f"moving {o.joints[j]} as measured takes {needed[j]:.2g} {unit} (rms), and its servo gave about "
                f"{given[j]:.2g} {unit}: masses a thousand times too small, as it seems; expected kg"
            )
            return [Mistake("grams", "likely", _suspects(o, j), sentence, "robot.urdf", (o.name,))]
    return []


def needed_effort(o: Observed) -> Array:
    """The joint efforts that a measured motion takes without friction [N·m or N], of a fixed base. Shape (m, n)."""
    width = min(max(5, 2 * round(0.5 * SMOOTHED / o.step) + 1), len(o.clock) // 2 * 2 - 1)
    q, w, a = (savgol_filter(o.position, width, 3, deriv=k, delta=o.step, axis=0) for k in range(3))
    dynamics, base = Dynamics(o.plant.model), np.zeros(13)
    base[3:7] = _base_quaternion(o.plant)
    gravity = np.array([0.0, 0.0, -GRAVITY])
    rows = np.unique(np.linspace(0, len(q) - 1, SAMPLES).astype(int))
    out = np.empty((len(rows), len(o.joints)))
    armature = np.diag(o.plant.drive["armature"])
    for k, row in enumerate(rows):
        dynamics.update(np.ascontiguousarray(q[row]), np.ascontiguousarray(w[row]), base, gravity)
        out[k] = (dynamics.inertia + armature) @ a[row] + dynamics.bias
    return out


def _base_quaternion(plant: Plant) -> Array:
    from realitygap_engines.model.robot import quaternion_from_rotation, rotation_from_rpy

    roll, pitch = plant.base_tilt
    return quaternion_from_rotation(rotation_from_rpy(roll, 0, 0) @ rotation_from_rpy(0, pitch, 0))


def _measured(o: Observed) -> Array:
    """The rms of the measured effort; NaN where there is none. Shape (n,)."""
    if o.effort is None:
        return np.full(len(o.joints), np.nan)
    known = np.isfinite(o.effort)
    squares = np.where(known, o.effort, 0.0) ** 2
    return np.asarray(np.where(known.any(axis=0), np.sqrt(squares.sum(axis=0) / np.maximum(known.sum(axis=0), 1)), np.nan))


def _given(o: Observed) -> Array:
    """What the servos gave, about: as measured, or by their stiffness for the errors, within their limits. Shape (n,)."""
    error = np.nanquantile(np.where(np.isfinite(o.command), np.abs(o.command - o.position), 0.0), 0.9, axis=0)
    by_error = np.where(o.plant.drive["ki"] > 0, np.inf, stiffness(o) * error)
    by_law = np.where(o.follows, np.minimum(by_error, limit(o)), np.nan)
    return np.asarray(np.where(np.isfinite(_measured(o)), _measured(o), by_law))


def _suspects(o: Observed, j: int) -> tuple[str, ...]:
    """The joints that carry the link that is out of proportion, or else every joint that moves links from there on."""
    masses = np.array([link.mass for link in o.plant.model.links[1:]])
    heaviest = int(np.argmax(masses))
    if len(masses) > 1 and masses[heaviest] > HEAVY * np.median(np.delete(masses, heaviest)):
        return (o.joints[heaviest],)
    return o.joints


def _joint_of(model: Model, link: int) -> tuple[str, ...]:
    return (model.joints[link - 1].name,) if link else tuple(model.joint_names)


def _turns(model: Model, link: int) -> bool:
    """Whether a link turns at all: a revolute joint or a floating base carries it."""
    if model.floating:
        return True
    while link > 0:
        joint = model.joints[link - 1]
        if not joint.prismatic:
            return True
        link = joint.parent
    return False


def _reach(model: Model) -> float:
    """How far the robot reaches from its base, stretched out [m]: offsets of joints, centres of mass and contact."""
    far = np.zeros(len(model.links))
    for i, link in enumerate(model.links):
        if i:
            joint = model.joints[i - 1]
            far[i] = far[joint.parent] + float(np.linalg.norm(joint.origin[:3, 3]))
    own = [
        max([float(np.linalg.norm(x.com)), *(float(np.linalg.norm(s.center)) + s.radius for s in x.spheres)])
        for x in model.links
    ]
    return float(np.max(far + np.array(own)))
