"""The first scenario of bags: which topic is what."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from realitygap.files.errors import InputError
from realitygap.init.names import spelt_otherwise
from realitygap.init.probe import Contents, probe
from realitygap.init.roles import COMMAND, CURRENT, Roles, other_states, roles_of, unfit_commands, why_no_state
from realitygap.init.sections import (
    AS_FOLLOWED,
    COMMANDS_BY,
    FOLLOWED,
    NOTHING_DRIVES,
    Motion,
    Sections,
    current_line,
    current_told,
    no_motion,
    quoted,
    runs_of,
)
from realitygap.scenario.joint_names import JOINT, name_patterns


def bag_sections(paths: list[Path], joints: Sequence[str], urdf: Path, out: Path) -> Sections:
    """Motion, recordings and runs of bags that are built like the first one. Joints that its state does not name, while
    it does others, are held. Where it names none, names that differ by what stands before or behind them are theirs,
    or that are spelt otherwise.

    Raises:
        InputError: for a bag that holds none of the robot's joints, or no pose of a robot without joints.
    """
    contents = probe(paths[0], joints)
    roles = roles_of(contents)
    names, said = {joint: joint for joint in joints}, list[str]()
    if joints and roles.state is None and (other := _names(contents, joints)) is not None:
        names, said = other
        contents = probe(paths[0], list(names.values()))
        roles = roles_of(contents)
    if joints and roles.state is None and (reasons := why_no_state(contents)):
        raise InputError(
            f"{contents.path}: {', and '.join(reasons)}; expected a topic with the measured positions of "
            f"{', '.join(joints)}: record one, or name it in a scenario as recordings.state; it has {contents.listing}"
        )
    if joints and roles.state is None:
        raise InputError(
            f"{contents.path}: no topic holds the positions of {', '.join(joints)} of {urdf}; it has "
            f"{contents.listing}{_others(contents)}; expected a JointState with the joints' names as in the URDF: "
            "rename one or the other, or write a scenario whose recordings.joints tells their names"
        )
    if not joints and not contents.poses:
        raise InputError(
            f"{contents.path}: no topic holds the pose of {urdf}, which has no joints; it has {contents.listing}; "
            "expected a PoseStamped or Odometry"
        )
    moving = next(iter(contents.poses + contents.imus), None)
    told = [*_told(contents, roles, joints), *_other_names(contents, roles, list(names.values()))]
    held = tuple(j for j in joints if roles.state is not None and names[j] not in roles.state.stream.joints)
    seen = {j: [s.topic for s in contents.joint_streams if names[j] in s.joints] for j in held}
    own = {name: joint for joint, name in names.items()}
    order = tuple(own[name] for name in roles.order)
    topics = {own[name]: topic for name, topic in roles.topics.items()}
    return Sections(
        _motion(replace(roles, order=order, topics=topics), [joint for joint in joints if joint not in held]),
        [*said, *_recordings(contents, roles)],
        runs_of(paths, out),
        roles.meaning,
        moving,
        told=told,
        followed=_followed(roles),
        angles=_angles(roles),
        held=held,
        unmeasured={joint: topics for joint, topics in seen.items() if topics},
    )


def _patterns(contents: Contents, joints: Sequence[str]) -> list[str]:
    """The names, with `*` for the joint's own, that topics have for all of the joints."""
    return list(dict.fromkeys(p for names in contents.others.values() for p in name_patterns(names, joints)))


def _names(contents: Contents, joints: Sequence[str]) -> tuple[dict[str, str], list[str]] | None:
    """The names that a recording has for the joints where they are others, and the key that says so."""
    if patterns := _patterns(contents, joints):
        stated, also = f'"*": {quoted(patterns[0])}', _also(patterns[1:])
        names = {joint: patterns[0].replace(JOINT, joint) for joint in joints}
    else:
        spelt = (spelt_otherwise(found, joints) for found in contents.others.values())
        names, also = next((found for found in spelt if found), {}), ""
        stated = ", ".join(f"{quoted(joint)}: {quoted(name)}" for joint, name in names.items())
    return (names, [f"  joints: {{{stated}}}  # GUESS: so the recording names the joints{also}"]) if names else None


def _also(others: Sequence[str]) -> str:
    """What else could have been taken."""
    return f"; there is also {', '.join(others)}" if others else ""


def _others(contents: Contents) -> str:
    """Which names stand in the messages of topics with other joints."""
    return "".join(f"; {topic} names {', '.join(names)}" for topic, names in contents.others.items())


def _other_names(contents: Contents, roles: Roles, names: Sequence[str]) -> list[str]:
    """What was left out as its messages name other joints, where something is missing that it may hold."""
    if roles.state is None or (roles.command is not None and roles.effort is not None):
        return []
    return [
        f"{topic} was left out because of the joints that it names: {', '.join(found)}; expected {', '.join(names)}, "
        "as in the state"
        for topic, found in contents.others.items()
    ]


def _followed(roles: Roles) -> bool:
    return roles.command is None and roles.effort is not None


def _current(roles: Roles) -> bool:
    """Whether the effort is in a topic of its own whose name says that it is a current."""
    apart = roles.effort is not None and (roles.state is None or roles.effort.stream is not roles.state.stream)
    return apart and roles.effort is not None and bool(CURRENT.search(roles.effort.stream.topic))


def _angles(roles: Roles) -> tuple[str, ...]:
    """The signals that are angles, or angles per s."""
    if roles.state is None:
        return ()
    measured = [s for s in ("position", "velocity") if s in roles.state.stream.signals]
    told = roles.command is not None and not _followed(roles) and roles.meaning in ("position", "velocity")
    return (*measured, "command") if told else tuple(measured)


def _motion(roles: Roles, joints: Sequence[str]) -> Motion:
    if _followed(roles):
        return FOLLOWED
    if roles.command is None:
        return no_motion("TOPIC")
    items = {"recorded": _topics(roles.topics, joints) if roles.topics else quoted(roles.command.stream.topic)}
    if roles.meaning != "position":
        items["as"] = roles.meaning
    if roles.order:
        items["joints"] = f"[{', '.join(map(quoted, roles.order))}]"
    if roles.command.stream.goal:
        items["held"] = "false"
    return Motion(items, roles.command.reason)


def _topics(topics: Mapping[str, str], joints: Sequence[str]) -> str:
    """The topics of commands by joint, or by one pattern that gives these joints, which are all, the same."""
    patterns = [
        p for p in name_patterns(topics.values(), joints) if all(topics[j] == p.replace(JOINT, j) for j in topics)
    ]
    if len(topics) == len(joints) > 1 and patterns:
        return f'{{"*": {quoted(patterns[0])}}}'
    return f"{{{', '.join(f'{quoted(joint)}: {quoted(topic)}' for joint, topic in topics.items())}}}"


def _recordings(contents: Contents, roles: Roles) -> list[str]:
    lines = []
    if roles.state is not None:
        also = _also(other_states(contents, roles))
        lines.append(f"  state: {quoted(roles.state.stream.topic)}  # GUESS: {roles.state.reason}{also}")
    if roles.effort is not None:
        if roles.state is not None and roles.effort.stream is roles.state.stream:
            lines.append(f"  effort: motor  # GUESS: N·m of the motor, before friction; {roles.effort.reason}")
        else:
            topic = f"topic: {quoted(roles.effort.stream.topic)}, "
            unknown = f"  effort: {{{topic}measures: motor, factor: 1.0}}  # GUESS: {roles.effort.reason}"
            lines.append(current_line(topic, "A", followed=_followed(roles)) if _current(roles) else unknown)
    found = (("pose", contents.poses), ("imu", contents.imus), ("battery", contents.batteries))
    for key, topics in found:
        if topics:
            more = f"  # GUESS: there is also {', '.join(topics[1:])}" if topics[1:] else ""
            lines.append(f"  {key}: {quoted(topics[0])}{more}")
    return lines


def _told(contents: Contents, roles: Roles, joints: Sequence[str]) -> list[str]:
    """What was seen and not used, and what is missing."""
    chosen = [role.stream.topic for role in (roles.state, roles.command, roles.effort) if role is not None]
    chosen += roles.topics.values()
    chosen += [topics[0] for topics in (contents.poses, contents.imus, contents.batteries) if topics]
    spare = [f"{topic} ({kind})" for topic, kind in sorted(contents.kinds.items()) if topic not in chosen]
    told = [f"not used: {', '.join(spare)}"] if spare else []
    if joints and roles.command is None:
        unfit = {} if roles.state is None else unfit_commands(contents, roles.state.stream)
        what = "fitting topic" if unfit else "topic"
        told.append(NOTHING_DRIVES.format(what) if roles.effort is None else AS_FOLLOWED.format(what))
        told += [f"{topic} says by its name that it holds commands, but {why}" for topic, why in unfit.items()]
        if not unfit:
            told.append(COMMANDS_BY.format("topic", COMMAND.pattern.replace("|", ", ")))
    if roles.effort is not None and _current(roles):
        name = roles.effort.stream.topic
        told.append(current_told(f"topic {name}", f"topic: {quoted(name)}, ", "A", followed=_followed(roles)))
    if joints and roles.effort is None:
        told.append("no effort was found: torques are not compared")
    return told
