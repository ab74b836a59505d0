"""Which stream of a recording is the command, which the state, and which the effort: guesses, with their reasons."""

import re
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from realitygap.init.names import by_stem, joint_of
from realitygap.init.probe import Contents, JointStream
from realitygap.recording.commands import held_at
from realitygap.recording.delay import MOVING, mean_squared_difference

STATE = re.compile(r"state|measured|feedback|actual|sensor|encoder", re.IGNORECASE)
COMMAND = re.compile(r"command|cmd|goal|target|desired|reference|setpoint", re.IGNORECASE)
DUTY = re.compile(r"duty|pwm", re.IGNORECASE)
CURRENT = re.compile(r"current|amp", re.IGNORECASE)
TOLD = {
    "velocity": re.compile(r"veloc|speed", re.IGNORECASE),
    "duty": DUTY,
    "effort": re.compile(r"effort|torque", re.IGNORECASE),
}
"""What a command is, where its topic says so."""
NOT_POSITION = re.compile(r"effort|torque|velocity|current|pwm|duty", re.IGNORECASE)
LONGEST_LEAD = 0.5  # s


@dataclass(frozen=True)
class Role:
    """A stream in a role, and why."""

    stream: JointStream
    reason: str


@dataclass(frozen=True)
class Roles:
    """The streams of a scenario; `meaning` is what the command is: position, velocity, duty or effort. `order` are the
    joints of a command whose messages name none, `topics` those of commands that come in one for each joint.
    """

    state: Role | None = None
    command: Role | None = None
    meaning: str = "position"
    effort: Role | None = None
    order: tuple[str, ...] = ()
    topics: dict[str, str] = field(default_factory=dict)


def roles_of(contents: Contents) -> Roles:
    """The roles of a bag's joint streams, from their names and from what they hold."""
    streams = contents.joint_streams
    controllers = [s for s in streams if s.controller]
    goals = [s for s in streams if s.goal]
    positions = [s for s in streams if "position" in s.signals and not s.controller and not s.goal]
    measured = [s for s in positions if not _says_command(s)]
    if not measured and controllers:
        told = Role(controllers[0], "a controller's state holds both what it measures and what it asks for")
        return Roles(told, told, effort=_effort(told.stream, streams))
    if not measured:
        return Roles()
    state = max(measured, key=_like_a_state)
    others = [s for s in positions if s is not state and set(s.joints) & set(state.joints)]
    leads = {s.topic: lead(s, state) for s in others}
    bare = not STATE.search(state.topic) and not COMMAND.search(state.topic)
    if bare and len(others) == 1 and (found := leads[others[0].topic]) is not None and found < 0:
        # names say nothing, and the one taken for the state comes first: it is the command
        state, others = others[0], [state]
        leads = {others[0].topic: -found}
    roles = Roles(Role(state, _state_reason(state)), effort=_effort(state, streams))
    commands = [s for s in others if COMMAND.search(s.topic) or (leads[s.topic] or 0.0) > 0]
    if commands:
        chosen = max(commands, key=lambda s: (bool(COMMAND.search(s.topic)), leads[s.topic] or 0.0))
        return replace(roles, command=Role(chosen, _command_reason(chosen, state, leads[chosen.topic])))
    asked = [s for s in controllers if set(s.joints) & set(state.joints)]
    if asked:
        return replace(roles, command=Role(asked[0], "a controller's state holds what it asks for"))
    if goals:
        return replace(roles, command=Role(goals[0], "its type is that of a command"))
    if (single := commands_by_joint(contents, state)) is not None:
        return replace(roles, command=single[0], meaning=single[1], topics=single[2])
    unnamed = unnamed_command(contents.unnamed, state)
    if unnamed is not None:
        return replace(roles, command=unnamed[0], order=unnamed[1])
    other = other_command(contents, state)
    return roles if other is None else replace(roles, command=other[0], meaning=other[1], order=other[2])


def why_no_state(contents: Contents) -> list[str]:
    """What keeps topics with the robot's joints from being the state, of a bag that has none."""
    asked = [s.topic for s in contents.joint_streams if "position" in s.signals and (s.goal or _says_command(s))]
    empty = [s.topic for s in contents.joint_streams if "position" not in s.signals and not _says_command(s)]
    reasons = [f"all positions of {', '.join(empty)} are NaN or left out"] if empty else []
    return [*reasons, *([f"the positions of {', '.join(asked)} are commands by name or type"] if asked else [])]


def other_states(contents: Contents, roles: Roles) -> list[str]:
    """The topics that say that they are states of the same joints as the one that was taken."""
    taken = [role.stream for role in (roles.state, roles.command) if role is not None]
    return [
        s.topic
        for s in contents.joint_streams
        if "position" in s.signals and s not in taken and not s.controller and STATE.search(s.topic)
        if roles.state is not None and set(s.joints) & set(roles.state.stream.joints)
    ]


def _says_command(stream: JointStream) -> bool:
    return bool(COMMAND.search(stream.topic)) and not STATE.search(stream.topic)


def other_command(contents: Contents, state: JointStream) -> tuple[Role, str, tuple[str, ...]] | None:
    """A stream whose name says that it commands something else than positions; what, and the joints in its order.

    Where its messages name no joints, the order is the robot's, as nothing that was measured tells it.
    """
    for stream in contents.joint_streams:
        if "position" in stream.signals or not COMMAND.search(stream.topic):
            continue
        if "velocity" in stream.signals:
            return Role(stream, "its name says command, and it holds velocities"), "velocity", ()
        if "effort" in stream.signals:
            within_one = float(np.nanmax(np.abs(stream.signals["effort"]))) <= 1.0
            meaning = "duty" if within_one and DUTY.search(stream.topic) else "effort"
            return Role(stream, "its name says command, and it holds efforts"), meaning, ()
    for stream in contents.unnamed:
        meant = [meaning for meaning, name in TOLD.items() if name.search(stream.topic)]
        fits = stream.signals["position"].shape[1] == len(state.joints)
        if meant and fits and COMMAND.search(stream.topic):
            reason = f"its name says command and {meant[0]}; its values name no joints, and this is the robot's order"
            return Role(stream, reason), meant[0], state.joints
    return None


def commands_by_joint(contents: Contents, state: JointStream) -> tuple[Role, str, dict[str, str]] | None:
    """Topics of one value each whose names say that they command a joint: one of them, what they command, and all by
    joint. Of several kinds, as of controllers that took turns, positions come first.
    """
    streams = [*contents.single, *(s for s in contents.unnamed if s.signals["position"].shape[1] == 1)]
    by_topic = {s.topic: s for s in streams if COMMAND.search(s.topic)}
    named = {joint for topic in by_topic if (joint := joint_of(topic, state.joints)) is not None}
    joints = [joint for joint in state.joints if joint in named] or state.joints
    if len(joints) == 1 < len(state.joints):  # of the only joint of a robot, any topic is
        by_topic = {topic: s for topic, s in by_topic.items() if joint_of(topic, state.joints) is not None}
    kinds = {_meaning(found[joints[0]]): found for found in by_stem(list(by_topic), joints).values()}
    for meaning in ("position", *TOLD):
        if meaning in kinds:
            topics = {joint: kinds[meaning][joint] for joint in joints}
            said = "" if meaning == "position" else f" and {meaning}"
            reason = f"topics of one value each, whose names say command{said} and which joint"
            return Role(by_topic[topics[joints[0]]], reason), meaning, topics
    return None


def _meaning(topic: str) -> str:
    return next((meaning for meaning, name in TOLD.items() if name.search(topic)), "position")


def unnamed_command(streams: list[JointStream], state: JointStream) -> tuple[Role, tuple[str, ...]] | None:
    """The stream of values without names that may command the joints of a state, and in which order.

    The order is that in which the values are closest to the measured positions, over the time that both have.
    """
    for stream in sorted(streams, key=lambda s: not COMMAND.search(s.topic)):
        values, measured = stream.signals["position"], state.signals["position"]
        if values.shape[1] > measured.shape[1] or NOT_POSITION.search(stream.topic):
            continue
        both = _shared(stream, state)
        if both.sum() < 2:
            continue
        asked = held_at(stream.time, values, state.time[both])
        distance = ((asked[:, :, None] - measured[both][:, None, :]) ** 2).mean(axis=0)
        _, columns = linear_sum_assignment(np.nan_to_num(distance, nan=1e9))
        order = tuple(state.joints[j] for j in columns)
        return Role(
            stream, "its values name no joints; in this order they are closest to the measured positions"
        ), order
    return None


def _shared(stream: JointStream, state: JointStream) -> NDArray[np.bool_]:
    """The samples of a state from the time that a stream has values of. Shape (t,)."""
    return np.asarray((state.time >= stream.time[0]) & (state.time <= stream.time[-1]))


def unfit_commands(contents: Contents, state: JointStream) -> dict[str, str]:
    """Why topics that are commands by their names, and whose values name no joints, are none for those of a state, and
    how a scenario takes them, by topic.
    """
    out = {}
    for stream in contents.unnamed:
        count, joints = stream.signals["position"].shape[1], state.joints
        if not COMMAND.search(stream.topic) or (count == len(joints) and NOT_POSITION.search(stream.topic)):
            continue
        if _shared(stream, state).sum() < 2:
            out[stream.topic] = "it has no values from the time in which the joints were measured"
            continue
        named = [*joints, *(["NAME"] * (count - len(joints)))] if count > len(joints) else joints[:count]
        meaning = next((f", as: {m}" for m, name in TOLD.items() if name.search(stream.topic)), "")
        out[stream.topic] = (
            f"it holds {count} value{'s' * (count > 1)} that name no joints, for {len(joints)} that were measured; "
            f"`motion: {{recorded: {stream.topic}{meaning}, joints: [{', '.join(named)}]}}` takes it, where joints has "
            "a name for every value, in their order"
        )
    return out


def lead(command: JointStream, state: JointStream) -> float | None:
    """The time [s] by which one stream of positions comes before another; None where that cannot be told."""
    if len(command.time) < 2 or len(state.time) < 2:
        return None
    joints = [j for j in command.joints if j in state.joints]
    start, end = max(command.time[0], state.time[0]), min(command.time[-1], state.time[-1])
    step = min(float(np.median(np.diff(s.time))) for s in (command, state)) / 2.0
    if not end - start > 10 * step:
        return None
    even = np.arange(start, end, step)
    sampled = []
    for stream in (command, state):
        columns = [stream.signals["position"][:, stream.joints.index(j)] for j in joints]
        sampled.append(np.column_stack([np.interp(even, stream.time, np.nan_to_num(c)) for c in columns]))
    moving = (np.ptp(sampled[0], axis=0) > MOVING) & (np.ptp(sampled[1], axis=0) > MOVING)
    if not moving.any():
        return None
    error, lags = mean_squared_difference(sampled[0][:, moving], sampled[1][:, moving])
    near = np.abs(lags * step) <= LONGEST_LEAD
    best = int(np.argmin(error[near]))
    at_the_edge = best in (0, int(near.sum()) - 1)  # no least difference in between: the streams do not fit
    return None if at_the_edge else float(lags[near][best] * step)


def _like_a_state(stream: JointStream) -> float:
    named = 4.0 * bool(STATE.search(stream.topic)) - 4.0 * bool(COMMAND.search(stream.topic))
    dynamic = 0.5 * stream.kind.endswith("DynamicJointState")  # a JointState holds the same
    return named + len(stream.joints) / 100.0 + ("velocity" in stream.signals) + ("effort" in stream.signals) - dynamic


def _state_reason(state: JointStream) -> str:
    parts = ["its name says state"] if STATE.search(state.topic) else []
    held = [name for name in ("velocity", "effort") if name in state.signals]
    if held:
        parts.append(f"it holds {' and '.join(held)}")
    return ", ".join(parts) or "it holds positions"


def _command_reason(command: JointStream, state: JointStream, ahead: float | None) -> str:
    parts = ["its name says command"] if COMMAND.search(command.topic) else []
    if ahead is not None and ahead > 0:
        parts.append(f"it comes {1e3 * ahead:.0f} ms before {state.topic}")
    return ", ".join(parts) or "it holds positions and is not the state"


def _effort(state: JointStream, streams: list[JointStream]) -> Role | None:
    if "effort" in state.signals:
        return Role(state, "unit and place of measurement are not in the recording")
    for s in streams:
        bare = "effort" in s.signals and "position" not in s.signals
        if bare and not COMMAND.search(s.topic) and not DUTY.search(s.topic):
            return Role(s, "its unit is not known")
    return None
