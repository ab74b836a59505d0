"""A plant as a MJCF file: what MuJoCo says natively of its drives, and sentences on what it cannot say.

Positions in the file are the encoders' readings, so that a joint offset is part of the file (`ref`).

The drive law takes a share of damping D at the end of a step, the `late` of `law.transmission.weight`, so that
(M + A + late·h·D)·Δω = h·(τ − D·ω). Where the file's steps are explicit, its armature is A + late·h·D: the same step,
for dry friction too. On the ground they are `discrete`, which takes damping and stiffness K, that of position gains
too, at the end of the step: damping is less by h·K there, and armature by what that adds. (While an effort limit
holds, that K is gone, and the file's damping is off by h·K.)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from xml.etree.ElementTree import Element

import numpy as np
from realitygap_engines import Physics
from realitygap_engines.model.robot import rotation_from_rpy
from realitygap_engines.mujoco_file import Spring, mjcf_text, numbers, steps_as_adapter

from realitygap.robot.drive import DC, DUTY, EFFORT, NONE, PID, POSITION, SPEED, TORQUE, Array, neutral_drive
from realitygap.robot.law.transmission import weight
from realitygap.robot.plant import Plant

NATIVE = {
    *("kind", "meaning", "gain", "duty_limit", "supply", "torque_constant", "resistance", "kp", "ki", "kd", "kv"),
    *("effort_limit", "offset", "armature", "coulomb", "viscous", "constant"),
    *("ripple", "ripple_periods", "ripple_phase", "cable_stiffness", "cable_rest"),
}
"""What of a drive a MJCF file says."""
WITH = {
    *("sag_group", "no_load_speed", "protection_share", "profile_acceleration", "stribeck_velocity"),
    *("stribeck_exponent", "load_velocity", "load_exponent", "friction_periods", "friction_phase"),
    *("stop_lower", "stop_upper", "give_damping", "current_factor", "hysteresis_onset"),
}
"""What says nothing without another field, or nothing of how a robot moves."""
WORDS = {
    "recorded_supply": "the supply was recorded",
    "velocity_limit": "the velocity limit of its controller",
    "stall_torque": "torque_speed_limit",
    "sag_resistance": "voltage_sag",
    "heating": "motor_heating",
    "saturation": "motor_saturation",
    "gain_exponent": "gain_law",
    "protection": "effort_limit beyond a position error",
    "profile_speed": "command_profile",
    "real_limit": "effort_limit of the motor",
    "lag": "current_lag",
    "braking": "motor_braking",
    "static": "stribeck_friction",
    "onset": "coulomb_friction that grows from rest",
    "presliding": "dry friction that builds up over an angle",
    "load": "load_dependent_friction",
    "load_static": "load_dependent_friction at rest",
    "lean": "direction_friction",
    "viscous_asymmetry": "direction_friction of what is viscous",
    "stiffness": "joint_compliance",
    "stop_stiffness": "joint_stop",
    "hysteresis": "effort_hysteresis, of the sensor and not of the robot",
}
"""How people call the other fields; the rest is called by its own name."""


def write_mjcf(plant: Plant, physics: Physics) -> tuple[str, list[str]]:
    """The MJCF file of a plant, and what it cannot say; the file says that in its head, too.

    Run by `mj_step` with the commands in `ctrl`, joint for joint, it moves as the plant does in the MuJoCo adapter at
    the same time step, as far as nothing is left out.
    """
    n, h, d = len(plant.model.joints), physics.timestep, plant.drive
    back = np.where((d["kind"] == DC) & (d["meaning"] != EFFORT), d["torque_constant"] ** 2 / d["resistance"], 0.0)
    inside = np.array([_inside(row) for row in d]).reshape(n)
    total = d["viscous"] + back + inside
    late = np.array([float(weight(h * t / i)) for t, i in zip(total, plant.inertia(), strict=True)]).reshape(n)
    damping, more = d["viscous"] + back, h * late * total + 0.25 * h * h * d["cable_stiffness"]
    if steps_as_adapter(physics):
        stiffness = np.array([_stiffness(row, h) for row in d]).reshape(n) + d["cable_stiffness"]
        damping = damping - h * stiffness
        more = more - h * (inside + np.maximum(damping, 0.0) + h * stiffness)
    joints = [
        replace(j, damping=float(b), friction=float(c), armature=float(a + x))
        for j, b, c, a, x in zip(plant.model.joints, damping, d["coulomb"], d["armature"], more, strict=True)
    ]
    lost = [*_lost_of_joints(plant), *_lost(plant)]
    names = plant.model.joint_names
    roll, pitch = plant.base_tilt
    text = mjcf_text(
        replace(plant.machine(), joints=tuple(joints)),
        physics,
        base=rotation_from_rpy(roll, 0, 0) @ rotation_from_rpy(0, pitch, 0),
        offset=d["offset"],
        springs=[Spring(float(row["cable_stiffness"]), float(row["cable_rest"])) for row in d],
        actuators=[
            *(a for i, name in enumerate(names) if (a := _servo(plant, i, name, h)) is not None),
            *(a for i, name in enumerate(names) for a in _passive(d[i], name)),
        ],
        comments=list(_head(names, d["armature"], more, back, lost, h)),
    )
    return text, lost


def _inside(d: np.void) -> float:
    """The damping that is part of a controller, and of an actuator in the file."""
    if d["meaning"] == EFFORT or d["kind"] in (NONE, DC):
        return 0.0
    if d["kind"] == SPEED:
        return float(d["gain"])
    return float(d["kd"] if d["kind"] == PID else d["gain"] * d["kv"])


def _stiffness(d: np.void, h: float) -> float:
    """The position gain of an actuator in the file [N·m/rad or N/m]."""
    if d["meaning"] != POSITION or d["kind"] == NONE or (d["kind"] == DC and d["recorded_supply"]):
        return 0.0
    if d["kind"] == DC:
        return float(d["torque_constant"] / d["resistance"] * d["supply"] * d["gain"])
    # an integral counts to the middle of the step
    return float(d["kp"] + 0.5 * h * d["ki"] if d["kind"] == PID else d["gain"] * d["kv"] * d["kp"])


def _servo(plant: Plant, i: int, name: str, h: float) -> Element | None:
    d, delay = plant.drive[i], float(plant.delay[i])
    if d["kind"] == NONE or (d["kind"] == DC and d["recorded_supply"]):
        return None
    limit = float(d["effort_limit"])
    if d["meaning"] == EFFORT:
        gain = float(d["gain"]) if d["kind"] == TORQUE else 1.0
        servo = _limited(Element("general", name=name, joint=name, gainprm=numbers(gain)), "force", limit)
    elif d["kind"] == SPEED:
        servo = _limited(Element("velocity", name=name, joint=name, kv=numbers(d["gain"])), "force", limit)
    elif d["kind"] == DC:
        torque = float(d["torque_constant"] / d["resistance"] * d["supply"])  # of a duty of 1, at rest
        if d["meaning"] == DUTY:
            servo = Element("general", name=name, joint=name, gainprm=numbers(torque))
            _limited(servo, "ctrl", float(d["duty_limit"]))
        else:
            servo = Element("position", name=name, joint=name, kp=numbers(_stiffness(d, h)))
            _limited(servo, "force", torque * float(d["duty_limit"]))
    elif d["kind"] == PID and (d["ki"] or d["kd"]):
        gains = {"kp": numbers(_stiffness(d, h)), "ki": numbers(d["ki"]), "kv": numbers(d["kd"])}
        servo = Element("pid", gains, name=name, joint=name)
        _limited(servo, "force", limit)
    else:
        servo = Element("position", name=name, joint=name, kp=numbers(_stiffness(d, h)), kv=numbers(_inside(d)))
        _limited(servo, "force", limit)
    if delay:
        servo.set("delay", numbers(delay))
        servo.set("nsample", str(int(np.ceil(delay / h)) + 2))
        servo.set("interp", "linear")
    return servo


def _limited(element: Element, what: str, limit: float) -> Element:
    if np.isfinite(limit):
        element.set(f"{what}limited", "true")
        element.set(f"{what}range", numbers((-limit, limit)))
    return element


def _passive(d: np.void, name: str) -> Iterator[Element]:
    """What acts on a joint whatever its servo is told."""
    if d["constant"]:
        yield Element(
            "general",
            name=f"{name} constant",
            joint=name,
            gainprm="0",
            biastype="affine",
            biasprm=numbers(d["constant"]),
        )
    if d["ripple"]:
        phase = d["ripple_phase"] + d["ripple_periods"] * d["offset"]
        cogging = numbers((-d["ripple"], d["ripple_periods"], phase))
        nothing = {"motorconst": "1e-9 1e-9", "resistance": "1", "input": "none"}  # a motor that is its cogging
        yield Element("dcmotor", nothing, name=f"{name} ripple", joint=name, cogging=cogging)


def _lost_of_joints(plant: Plant) -> Iterator[str]:
    neutral = neutral_drive(len(plant.model.joints))
    for field in plant.drive.dtype.names or ():
        if field in NATIVE or field in WITH:
            continue
        own = plant.drive["coulomb"] if field == "static" else neutral[field]
        there = plant.drive[field] != own
        if field == "velocity_limit":
            there &= plant.drive["kind"] == PID
        if there.any():
            names = ", ".join(np.array(plant.model.joint_names)[there].tolist())
            yield f"{WORDS.get(field, field)} ({names})"


def _lost(plant: Plant) -> Iterator[str]:
    """What is lost of the plant as a whole."""
    if plant.velocity_lag.any() or (plant.velocity_scale != 1.0).any():
        yield "velocity_filter (of the sensors, not of the robot)"
    mimics = [joint.name for joint in plant.model.joints if joint.mimic is not None]
    if mimics:
        yield f"how firmly {', '.join(mimics)} mimic: an equality gives way a little"
    if plant.efforts:
        yield "efforts over time"
    if plant.maps:
        yield "effort_map, an effort that depends on measured variables"
    if plant.ground is not None and plant.ground.stiffness is not None:
        yield "soft_ground, as far as joint damping changes it: it is softer in the file"


def _head(names: list[str], armature: Array, more: Array, back: Array, lost: list[str], h: float) -> Iterator[str]:
    yield "Written by realitygap. Joint positions are what the encoders read; one control for each servo, by joint."
    if more.any():
        told = ", ".join(f"{n} {a:.6g}" for n, a in zip(names, armature, strict=True))
        yield f"Rotor inertia: {told}. In the file it differs by what makes its damping act as ours does"
        yield f"at a time step of {h:g} s; for another one, write it anew."
    if back.any():
        yield "The back-EMF of dc servos is part of the joints' damping, and stays when a servo is off."
    for sentence in lost:
        yield f"Not said here: {sentence}"
