"""A first scenario from what a team has: a URDF and recordings. Every guess says in a comment that it is one."""

import json
import os
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from realitygap_engines.errors import ModelError
from realitygap_engines.model.read import read_model
from realitygap_engines.model.robot import Joint, Model

from realitygap.files.errors import InputError
from realitygap.init.probe import COLUMN_NAMES, Contents, probe
from realitygap.init.roles import Roles, roles_of
from realitygap.recording import read_recording
from realitygap.robot.servos import written_together
from realitygap.scenario.file import load_scenario

FIXED_ROOTS = ("world", "map", "odom", "ground", "table")
LEGS = re.compile(r"foot|ankle|leg|wheel|knee", re.IGNORECASE)
FULL_ERROR = 0.1  # rad: a stiff position servo gives its full effort at about this error
KP_UNKNOWN = 50.0  # N·m/rad, for a joint without effort limit
SUPPLY = 12.0  # V
DAMPING_TIME = 0.005  # s: kd = kp times this, little enough for light links at 1 ms


def init(urdf: Path, bags: list[Path], out: Path) -> Path:
    """Write `scenario.yaml` into a folder and return its path.

    Args:
        urdf: the robot.
        bags: bags, bag folders or tables, in the order of the runs.
        out: the folder, made where it is not there.

    Raises:
        InputError: for a URDF or recording that cannot be used, a recording with none of the robot's joints, or a
            scenario that is already there.
    """
    target = out / "scenario.yaml"
    if target.exists():
        raise InputError(f"{target}: is already there; remove it or give another folder with --out")
    if not bags:
        raise InputError(f"{urdf}: no recordings were given; expected at least one bag or table after the URDF")
    model, fixed = _model(urdf)
    contents = probe(bags[0], model.joint_names)
    roles = roles_of(contents)
    _check(contents, roles, model, urdf)
    out.mkdir(parents=True, exist_ok=True)
    draft = out / ".scenario.yaml.part"
    try:
        draft.write_text(_text(urdf, bags, out, model, fixed, contents, roles), encoding="utf-8")
        loaded = load_scenario(draft)
        for case in loaded.cases():
            read_recording(case.path, case.scenario, model.joint_names, file=target)
        draft.rename(target)
    finally:
        draft.unlink(missing_ok=True)
    return target


def _model(urdf: Path) -> tuple[Model, str | None]:
    """The robot, and why its base must be fixed (None: it need not be)."""
    try:
        return read_model(urdf, floating=True), None
    except ModelError as floating:
        try:
            return read_model(urdf, floating=False), "the root link has no mass"
        except ModelError:
            raise InputError(str(floating)) from None


def _check(contents: Contents, roles: Roles, model: Model, urdf: Path) -> None:
    names = ", ".join(model.joint_names)
    if contents.columns is not None:
        if model.joints and "position" not in contents.columns:
            expected = ", ".join(COLUMN_NAMES["position"])
            raise InputError(
                f"{contents.path}: no column holds the position of {names} of {urdf}; it has {contents.listing}; "
                f"expected one of {expected}, with the joint's name before or behind it where there are several"
            )
    elif model.joints and roles.state is None:
        raise InputError(
            f"{contents.path}: no topic holds the positions of {names} of {urdf}; it has {contents.listing}; expected "
            "a JointState with the joints' names as in the URDF"
        )
    elif not model.joints and not contents.poses:
        raise InputError(
            f"{contents.path}: no topic holds the pose of {urdf}, which has no joints; it has {contents.listing}; "
            "expected a PoseStamped or Odometry"
        )


def _text(
    urdf: Path, bags: list[Path], out: Path, model: Model, fixed: str | None, contents: Contents, roles: Roles
) -> str:
    base, reason = _base(model, fixed, contents)
    lines = [
        "# Written by `realitygap init`. What says GUESS was not in the files: check it, then compare.",
        f"name: {_quoted(urdf.stem)}",
        "robot:",
        f"  urdf: {_quoted(_relative(urdf, out))}",
        f"  base: {base}  # GUESS: {reason}",
    ]
    if model.joints:
        lines += ["", *_servo_lines(model, roles)]
        lines += ["", *_motion(contents, roles)]
    ground = "none" if base == "fixed" else "flat"
    lines += ["", f"ground: {ground}  # GUESS: flat, grass, or friction, stiffness and damping by numbers"]
    lines += ["physics: {step_rate: 1000}", "", "recordings:", *_recordings(contents, roles)]
    return "\n".join([*lines, *_runs(bags, out), ""])


def _base(model: Model, fixed: str | None, contents: Contents) -> tuple[str, str]:
    root = model.links[0].name
    parents = {joint.parent for joint in model.joints}
    ends = [link.name for i, link in enumerate(model.links) if i not in parents]
    if not model.joints:
        return "free", "the robot has no joints"
    if fixed is not None:
        return "fixed", fixed
    if root.lower() in FIXED_ROOTS:
        return "fixed", f"the root link is called {root}"
    if contents.poses or contents.imus:
        return "floating", f"{(contents.poses + contents.imus)[0]} was recorded, as on a robot that moves"
    if len(ends) >= 4 or any(LEGS.search(name) for link in model.links for name in link.merged):
        return "floating", f"the tree has {len(ends)} ends, or names of legs or wheels"
    return "fixed", f"the tree has {len(ends)} {'end' if len(ends) == 1 else 'ends'}, no legs and no wheels"


def _servo_lines(model: Model, roles: Roles) -> list[str]:
    if model.actuators:
        lines = ["# The actuators of the robot's file, as far as servos say them.", "servos:"]
        lines += [f"  - {json.dumps(servo, ensure_ascii=False)}" for servo in written_together(model.actuators)]
        return [*lines, *(f"  # {note}" for note in model.notes if note.startswith("actuator "))]
    return [
        "# GUESS: how the servos work is not in the files. With the data of a servo, `kind: dc` says more.",
        "servos:",
        *_servos(model.joints, roles.meaning),
    ]


def _servos(joints: Sequence[Joint], meaning: str) -> list[str]:
    """One servo per effort and velocity limit of the URDF."""
    groups: dict[tuple[float, float], list[str]] = {}
    for joint in joints:
        groups.setdefault((joint.effort, joint.velocity), []).append(joint.name)
    lines = []
    for (effort, velocity), names in groups.items():
        pattern = '"*"' if len(groups) == 1 else f"[{', '.join(map(_quoted, names))}]"
        lines.append(f"  - joints: {pattern}")
        lines += _dc(effort, velocity) if meaning == "duty" else _pid(effort)
    return lines


def _pid(effort: float) -> list[str]:
    bounded = bool(np.isfinite(effort))
    kp = effort / FULL_ERROR if bounded else KP_UNKNOWN
    why = f"the URDF's effort limit of {effort:g} at {FULL_ERROR:g} rad of error" if bounded else "no effort limit"
    return [
        "    kind: pid",
        f"    kp: {kp:.3g}  # GUESS: {why}",
        f"    kd: {kp * DAMPING_TIME:.3g}  # GUESS: {DAMPING_TIME:g} s times kp",
    ]


def _dc(effort: float, velocity: float) -> list[str]:
    """A motor told its duty that stalls at the URDF's effort limit and runs free at its velocity limit."""
    bounded = bool(np.isfinite([effort, velocity]).all())
    stall, free = (effort, velocity) if bounded else (1.0, 10.0)
    why = "stalls at the URDF's effort limit, runs free at its velocity limit" if bounded else "the URDF has no limits"
    constant = SUPPLY / free
    return [
        "    kind: dc",
        "    gain: 0  # the recorded command is the duty",
        f"    supply: {SUPPLY:g}  # GUESS: volts",
        f"    torque_constant: {constant:.3g}  # GUESS: {why}",
        f"    resistance: {constant * SUPPLY / stall:.3g}  # GUESS: likewise",
    ]


def _motion(contents: Contents, roles: Roles) -> list[str]:
    if contents.columns is not None:
        if "command" in contents.columns:
            return [f"motion: {{recorded: {_quoted(contents.columns['command'])}}}"]
    elif roles.command is not None:
        meaning = "" if roles.meaning == "position" else f", as: {roles.meaning}"
        topic = _quoted(roles.command.stream.topic)
        return [f"motion: {{recorded: {topic}{meaning}}}  # GUESS: {roles.command.reason}"]
    return ["# No command was found: motion: {recorded: TOPIC} or {keyframes: FILE} says what the servos are told."]


def _recordings(contents: Contents, roles: Roles) -> list[str]:
    if contents.columns is not None:
        named = {k: v for k, v in contents.columns.items() if v != COLUMN_NAMES[k][0]}
        inner = ", ".join(f"{k}: {_quoted(v)}" for k, v in named.items())
        lines = [f"  columns: {{{inner}}}  # GUESS: by their names"] if named else []
        if "effort" in contents.columns:
            lines.append("  effort: motor  # GUESS: of the motor, before friction, in N·m or N")
        return lines
    lines = []
    if roles.state is not None:
        lines.append(f"  state: {_quoted(roles.state.stream.topic)}  # GUESS: {roles.state.reason}")
    if roles.effort is not None:
        if roles.state is not None and roles.effort.stream is roles.state.stream:
            lines.append(f"  effort: motor  # GUESS: N·m of the motor, before friction; {roles.effort.reason}")
        else:
            topic = _quoted(roles.effort.stream.topic)
            lines.append(f"  effort: {{topic: {topic}, measures: motor, factor: 1.0}}  # GUESS: {roles.effort.reason}")
    found = (("pose", contents.poses), ("imu", contents.imus), ("battery", contents.batteries))
    for key, topics in found:
        if topics:
            more = f"  # GUESS: there is also {', '.join(topics[1:])}" if topics[1:] else ""
            lines.append(f"  {key}: {_quoted(topics[0])}{more}")
    return lines


def _runs(bags: list[Path], out: Path) -> list[str]:
    """One run per recording; which are fitted is left to the diagnosis, which keeps repetitions together."""
    hint = "  # add use: train or use: held_out; without them a diagnosis keeps every third motion to judge on"
    lines = ["  runs:" + (hint if len(bags) > 1 else "")]
    return lines + [f"    - {{path: {_quoted(_relative(bag, out))}}}" for bag in bags]


def _relative(path: Path, folder: Path) -> str:
    return Path(os.path.relpath(path.absolute(), folder.absolute())).as_posix()


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
