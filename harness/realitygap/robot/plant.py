"""The plant: model, drives, ground and sensors of one simulation, as a scenario states them and effects edit them."""

from __future__ import annotations

import copy
import fnmatch
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from realitygap_engines import Ground
from realitygap_engines.errors import ModelError
from realitygap_engines.model.hold import hold
from realitygap_engines.model.inertia import together
from realitygap_engines.model.read import read_model
from realitygap_engines.model.robot import Joint, Model

from realitygap.files.errors import InputError, standing
from realitygap.robot.drive import CASCADE, DC, MEANINGS, PID, SPEED, TORQUE, Array, neutral_drive
from realitygap.robot.effort_map import EffortMap
from realitygap.robot.held import held_joints, stated_start
from realitygap.robot.servos import check_command, servos_of
from realitygap.scenario.effort import effort_factors
from realitygap.scenario.file import ScenarioFile
from realitygap.scenario.schema import EffortStream, Scenario
from realitygap.scenario.servos import AnyServo, DcServo, EffortServo, PidServo, RecordedSupply, VelocityServo
from realitygap.scenario.world import GroundSpec

PAST = 0.01
"""A position further than this [rad or m] beyond a limit has passed it."""


@dataclass
class Plant:
    """Everything that a simulation is made of, apart from the engine. Effects edit a copy of it.

    Attributes:
        model: the robot; the drives' armature is put into it when it is opened.
        drive: Shape (n,) of `DRIVE`.
        ground: what it stands on.
        delay: from recorded command to servo [s]. Shape (n,).
        velocity_lag, velocity_scale: low-pass time [s] and scale of the reported velocity. Shape (n,).
        base_tilt: roll and pitch of a fixed base [rad]. Shape (2,).
        efforts: further joint efforts over time, as functions of times (t,) [s] -> Shape (t, n).
        maps: efforts that depend on measured variables.
        payloads: by the index of a link, the mass [kg] and the place x, y, z in its frame [m] of a load fixed to it.
        reached: how fast each joint went where its motion was recorded [rad/s or m/s]; None where none was. Shape (n,).
        travelled: the widest range that each joint moved over in one motion [rad or m], likewise. Shape (n,).
        lagged: how far each joint was from its position command at most [rad or m], likewise. Shape (n,).
        exerted: the most that motors were told or measured to give [N·m or N], 0 where neither is known. Shape (n,).
    """

    model: Model
    drive: NDArray[np.void]
    ground: Ground | None
    delay: Array
    velocity_lag: Array
    velocity_scale: Array
    base_tilt: Array
    efforts: list[Callable[[Array], Array]] = field(default_factory=list)
    maps: list[EffortMap] = field(default_factory=list)
    payloads: dict[int, tuple[float, float, float, float]] = field(default_factory=dict)
    reached: Array | None = None
    travelled: Array | None = None
    lagged: Array | None = None
    exerted: Array | None = None

    def copy(self) -> Plant:
        """A plant that can be edited without changing this one."""
        out = copy.copy(self)
        out.drive = self.drive.copy()
        for name in ("delay", "velocity_lag", "velocity_scale", "base_tilt"):
            setattr(out, name, getattr(self, name).copy())
        out.efforts, out.maps, out.payloads = list(self.efforts), list(self.maps), dict(self.payloads)
        return out

    def given(self, time: Array) -> Array:
        """The further joint efforts at times (t,) [s], all together [N·m or N]. Shape (t, n)."""
        out = np.zeros((len(time), len(self.drive)))
        for law in self.efforts:
            out += law(time)
        return out

    def passing(self, position: Array) -> tuple[Plant, list[str]]:
        """This plant without the limits that measured positions (t, n) pass, and a sentence on each: where a robot has
        been, it has no stop.
        """
        joints, notes = list(self.model.joints), []
        known = np.isfinite(position).all(axis=1)
        reach = position if known.all() else position[known]
        for i, joint in enumerate(joints if len(reach) else []):
            if reach[:, i].min() < joint.lower - PAST:
                joints[i] = replace(joints[i], lower=-np.inf)
                notes.append(_passed(joint, "lower", joint.lower))
            if reach[:, i].max() > joint.upper + PAST:
                joints[i] = replace(joints[i], upper=np.inf)
                notes.append(_passed(joint, "upper", joint.upper))
        return (replace(self, model=replace(self.model, joints=tuple(joints))) if notes else self), notes

    def loaded(self) -> Model:
        """The model with its payloads."""
        links = list(self.model.links)
        for i, (mass, *place) in self.payloads.items():
            load = (mass, np.array(place), np.zeros((3, 3)))
            m, com, inertia = together([(links[i].mass, links[i].com, links[i].inertia), load])
            links[i] = replace(links[i], mass=m, com=com, inertia=inertia)
        return replace(self.model, links=tuple(links)) if self.payloads else self.model

    def machine(self) -> Model:
        """The model as an engine gets it: with payloads, and the rotor inertia of drives rigid to their joint."""
        elastic = (self.drive["backlash"] > 0) | (self.drive["stiffness"] > 0)
        return self.loaded().with_armature(np.where(elastic, 0.0, self.drive["armature"]))

    def inertia(self) -> Array:
        """The inertia of every joint's child link about its axis, with the rotor [kg·m² or kg]. Shape (n,).

        What a joint really moves is more (further links) or less (its parent gives way).
        """
        own, links = [], self.loaded().links[1:]
        axes, centers = [j.axis for j in self.model.joints], [k.com for k in links]
        arms = np.cross(np.reshape(axes, (-1, 3)), np.reshape(centers, (-1, 3)))  # at once: of single ones it is slow
        for joint, link, arm in zip(self.model.joints, links, arms, strict=True):
            own.append(link.mass if joint.prismatic else joint.axis @ link.inertia @ joint.axis + link.mass * arm @ arm)
        return np.asarray(np.array(own) + np.maximum(self.drive["armature"], 1e-9))


def _contact_links(scenario: Scenario) -> list[str] | None:
    """The links that touch the ground: what stands on nothing needs no shapes, and no meshes."""
    asked = scenario.robot.contact_links
    nowhere = scenario.robot.base == "fixed" and scenario.ground_spec is None
    return [] if asked is None and nowhere else asked


def whole_model(file: ScenarioFile, scenario: Scenario) -> Model:
    """The robot of a scenario, before any joint is held.

    Raises:
        InputError: where its file is not there.
        ModelError: for a file that cannot be used.
    """
    robot = scenario.robot
    path = file.existing(robot.urdf, "robot.urdf", "a URDF or MJCF file")
    try:
        return read_model(
            path,
            floating=robot.base != "fixed",
            packages={k: file.resolve(v, f"robot.packages.{k}") for k, v in robot.packages.items()},
            contact_links=_contact_links(scenario),
        )
    except ModelError as error:
        raise ModelError(f"{file.path}: robot.urdf: {error}") from None


def build_plant(file: ScenarioFile, scenario: Scenario | None = None) -> Plant:
    """The plant that a scenario states, without its effects.

    Raises:
        InputError: for a servo pattern that matches nothing, or a position outside the limits.
        ModelError: for a robot's file that cannot be used.
    """
    scenario = scenario or file.scenario
    robot = scenario.robot
    whole = whole_model(file, scenario)
    model = hold(whole, held := held_joints(file, whole, robot.hold))
    if isinstance(robot.start, dict):
        with standing(f"{file.path}: "):
            stated_start(model, robot.start)
    n = len(model.joints)
    if robot.base == "free" and n:
        raise InputError(
            f"{file.path}: robot.base: found free, but the robot has {n} joints; expected floating or fixed"
        )
    drive = neutral_drive(n)
    drive["coulomb"] = drive["static"] = [j.friction for j in model.joints]
    drive["viscous"] = [j.damping for j in model.joints]
    drive["armature"] = model.armature
    drive["effort_limit"] = [j.effort for j in model.joints]
    drive["velocity_limit"] = [j.velocity for j in model.joints]
    if scenario.motion is not None:
        drive["meaning"] = MEANINGS[scenario.motion.meaning]
    if scenario.follows:
        _check_followed(file, scenario)
        effort = scenario.recordings.effort if scenario.recordings is not None else None
        if isinstance(effort, EffortStream) and effort.measures == "motor":
            factor = np.abs(effort_factors(effort, model.joint_names, file.path))
            drive["current_factor"] = drive["torque_constant"] = factor
    taken = {i for i, joint in enumerate(model.joints) if joint.mimic is not None}  # another joint's servo moves these
    servos, notes = servos_of(scenario, model)
    for i, servo in enumerate(servos):
        matched = match_joints(model, servo.joints)
        if not matched:
            welded = [whole.joint_names[j] for j in match_joints(whole, servo.joints) if j in held]
            why = f" that moves, as robot.hold holds {', '.join(welded)}" if welded else ""
            raise InputError(
                f"{file.path}: servos[{i}].joints: {', '.join(servo.joints)} matches no joint{why}; "
                f"the robot has {', '.join(model.joint_names)}"
            )
        check_command(file, f"servos[{i}]", servo, scenario)
        for j in sorted(set(matched) - taken):
            _fit_servo(drive, j, servo)
        taken |= set(matched)
    limp = [j for j in range(n) if j not in taken]
    if limp and not scenario.follows:
        drive["effort_limit"][limp] = np.inf  # of no motor: a pole had 100 N·m, and friction of 0.01 N·m·s/rad
        notes = [*notes, f"no servo, move freely: {', '.join(model.joint_names[j] for j in limp)}"]
    notes += [f"{j.name} mimics {j.mimic.joint}, and has no servo" for j in model.joints if j.mimic is not None]
    model = replace(model, notes=(*model.notes, *notes))
    return Plant(
        model=model,
        drive=drive,
        ground=ground(scenario.ground_spec),
        delay=np.zeros(n),
        velocity_lag=np.zeros(n),
        velocity_scale=np.ones(n),
        base_tilt=np.zeros(2),
    )


def _check_followed(file: ScenarioFile, scenario: Scenario) -> None:
    """What a motion that is followed needs, and what has no place beside it."""
    if scenario.servos:
        raise InputError(
            f"{file.path}: servos: found {len(scenario.servos)} beside motion: {{followed: true}}; expected none, as "
            "no servo drives a motion that is followed (its armature and friction can stand under effects)"
        )
    if scenario.robot.base != "fixed":
        raise InputError(
            f"{file.path}: robot.base: found {scenario.robot.base}; expected fixed, as what the ground does to a robot "
            "is not known from a motion that is followed"
        )
    if scenario.effort_measures == "none":
        raise InputError(
            f"{file.path}: recordings.effort: found none; expected the measured effort, with which the one that the "
            "followed motion takes is compared"
        )


def ground(spec: GroundSpec | None) -> Ground | None:
    """The ground as engines know it."""
    return None if spec is None else Ground(spec.friction, spec.stiffness, spec.damping)


def match_joints(model: Model, patterns: list[str] | str) -> list[int]:
    """The joints that one of the patterns matches, in the model's order."""
    wanted = [patterns] if isinstance(patterns, str) else patterns
    return [i for i, name in enumerate(model.joint_names) if any(fnmatch.fnmatchcase(name, p) for p in wanted)]


def _fit_servo(drive: NDArray[np.void], j: int, servo: AnyServo) -> None:
    d = drive[j]
    if "armature" in servo.model_fields_set:  # else what the robot's file says
        d["armature"] = servo.armature
    if servo.friction is not None:
        d["coulomb"] = d["static"] = servo.friction.coulomb
        d["viscous"] = servo.friction.viscous
    if isinstance(servo, DcServo):
        d["kind"] = DC
        d["gain"], d["duty_limit"] = servo.gain, servo.duty_limit
        d["torque_constant"], d["resistance"] = servo.torque_constant, servo.resistance
        if isinstance(servo.supply, RecordedSupply):
            d["recorded_supply"] = 1
        else:
            d["supply"] = servo.supply
    elif isinstance(servo, PidServo):
        d["kind"] = PID
        d["kp"], d["ki"], d["kd"] = servo.kp, servo.ki, servo.kd
    elif isinstance(servo, EffortServo | VelocityServo):
        d["kind"], d["gain"] = (TORQUE if isinstance(servo, EffortServo) else SPEED), servo.gain
    else:
        d["kind"] = CASCADE
        d["gain"], d["kv"], d["kp"] = servo.gain, servo.kv, servo.kp


def _passed(joint: Joint, side: str, limit: float) -> str:
    unit, scale = (" m", 1.0) if joint.prismatic else ("°", 180 / np.pi)
    return (
        f"{joint.name} was measured past the URDF's {side} limit of {limit * scale:.4g}{unit}: the stop is elsewhere; "
        "simulated without that limit"
    )
