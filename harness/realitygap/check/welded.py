"""Joints that `robot.hold` welds as they were not measured, and that were told to move."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from realitygap_engines.model.robot import Model

from realitygap.check.mistake import Mistake
from realitygap.check.motion import MOVES, SLIDES
from realitygap.check.observed import Observed, Read
from realitygap.check.words import joined
from realitygap.files.errors import InputError
from realitygap.robot.held import held_joints
from realitygap.robot.plant import whole_model
from realitygap.scenario.file import ScenarioFile
from realitygap.scenario.joint_names import recorded_names
from realitygap.scenario.schema import LEFT_OUT, Columns, Recordings, Scenario, Stream, Units
from realitygap.trace.trace import Array

ONE_BY_ONE = 8
"""Held joints whose commands are asked for one by one, where a recording does not hold those of all of them."""


def welded_mistakes(file: ScenarioFile, observed: Sequence[Observed], read: Read) -> list[Mistake]:
    """Joints that were commanded far from where they are held: they moved, as it seems, and moved others."""
    out = []
    for o in observed:
        motion = o.scenario.motion
        if not o.scenario.robot.hold or motion is None or motion.recorded is None or motion.meaning != "position":
            continue
        model = whole_model(file, o.scenario)
        held = held_joints(file, model, o.scenario.robot.hold)
        told = {}
        for j, command in _commands(file, o, model, list(held), read).items():
            away = np.abs(command - held[j]).max()
            if away > (SLIDES if model.joints[j].prismatic else MOVES):
                unit = "m" if model.joints[j].prismatic else "rad"
                name = model.joint_names[j]
                where = f"{name} is welded at {held[j]:.3g} {unit} and was commanded from"
                told[name] = f"{where} {command.min():.3g} to {command.max():.3g} {unit}"
        if told:
            sentence = (
                f"{', '.join(told.values())}: the simulation lacks a motion that other joints felt, as it seems; "
                f"expected the measured position of {joined(list(told))} in the recording, without `hold`, or `hold` "
                "where it stood"
            )
            out.append(Mistake("held_joint", "likely", tuple(sorted(told)), sentence, "robot.hold", (o.name,)))
    return out


def _commands(file: ScenarioFile, o: Observed, model: Model, held: list[int], read: Read) -> dict[int, Array]:
    """The recorded commands [rad or m] of those held joints that have some, by their index: read as if measured."""
    driven = next((name for name, c in zip(o.joints, o.recording.command.T, strict=True) if np.isfinite(c).any()), None)

    def of(joints: list[int]) -> dict[int, Array]:
        if driven is None:
            return {}
        names = [driven, *(model.joint_names[j] for j in joints)]  # beside it a column without a name is nobody's
        try:
            trace = read(o.recording.path, _as_measured(file, o, model, names), names, file=file.path).trace
        except InputError:
            return {}
        if trace.joints != tuple(names) or trace.position is None:  # as of a reader that knows one scenario alone
            return {}
        return dict(zip(joints, trace.position.T[1:], strict=True))

    found = of(held)
    if not found and 1 < len(held) <= ONE_BY_ONE:
        found = {j: command for joint in held for j, command in of([joint]).items()}
    return found


def _as_measured(file: ScenarioFile, o: Observed, model: Model, names: list[str]) -> Scenario:
    """The scenario in which what some joints are commanded is what was measured of them, and nothing else."""
    motion, recordings = o.scenario.motion, o.scenario.recordings
    assert motion is not None
    assert motion.recorded is not None
    assert recordings is not None
    topic, stated = motion.recorded if isinstance(motion.recorded, str) else "command", recordings.columns
    called = dict(zip(model.joint_names, recorded_names(recordings.joints, model.joint_names, file.path), strict=True))
    by_columns = o.holder == "table" and (topic == "command" or topic.startswith("/"))
    column = stated.command if by_columns else topic
    if o.holder == "table" and isinstance(column, str):
        column = _stem(column, called[names[0]])
    columns: dict[str, Any] = {"position": column, "velocity": LEFT_OUT}
    if o.holder != "data set":
        units = {"position": stated.units.command, "time": stated.units.time}
        columns |= {"time": stated.time, "units": Units.model_validate(units)}
    alone = Recordings(
        state=Stream(topic=topic, joints=motion.joints) if motion.joints else topic,
        joints={name: called[name] for name in names if called[name] != name},
        columns=Columns.model_validate(columns),
        dataset=recordings.dataset,
        episode=recordings.episode,
        part=recordings.part,
    )
    return o.scenario.model_copy(update={"motion": None, "recordings": alone})


def _stem(column: str, name: str) -> str:
    """What a column is called without the joint that it is of, as one of a single joint may be named."""
    from realitygap.recording.readers.table import FORMS  # loads pandas, which takes long, and few hold joints

    parts = (form.format("", name) for form in FORMS)
    return next((column.removeprefix(p).removesuffix(p) for p in parts if p in column), column)
