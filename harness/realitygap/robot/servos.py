"""The servos of a scenario: those that it names, or else what the robot's own file says drives its joints."""

import glob
from collections.abc import Sequence
from typing import Any

from pydantic import TypeAdapter
from realitygap_engines.model.robot import Actuator, Model

from realitygap.files.errors import InputError
from realitygap.scenario.file import ScenarioFile
from realitygap.scenario.schema import Scenario
from realitygap.scenario.servos import AnyServo


def servos_of(scenario: Scenario, model: Model) -> tuple[list[AnyServo], list[str]]:
    """The servos, and a sentence where they come from the robot's file."""
    there = [actuator for actuator in model.actuators if actuator.joint in model.joint_names]  # not of held joints
    if scenario.servos or scenario.follows or not there:
        return scenario.servos, []
    servos = [TypeAdapter(AnyServo).validate_python(written(actuator)) for actuator in there]
    return servos, [f"no servos in the scenario: those of {len(servos)} actuators in the robot's file are used"]


def check_command(file: ScenarioFile, key: str, servo: AnyServo, scenario: Scenario) -> None:
    """Make sure that a servo is told what it takes.

    Raises:
        InputError: for a velocity or effort servo whose commands are something else, and for velocities told to others.
    """
    motion = scenario.motion
    if motion is None:
        return
    told = "position" if motion.keyframes is not None else motion.meaning
    takes = {"effort": ("effort",), "velocity": ("velocity",)}.get(servo.kind, ("position", "duty", "effort"))
    if told not in takes:
        raise InputError(
            f"{file.path}: {key}.kind: found {servo.kind}, which takes commands that are {' or '.join(takes)}, but the "
            f"motion's are {told}; expected `motion: {{recorded: ..., as: {takes[0]}}}` or another kind of servo"
        )


def written(actuator: Actuator) -> dict[str, Any]:
    """An actuator as a servo is written in a scenario."""
    return {"joints": glob.escape(actuator.joint), "kind": actuator.kind, **actuator.values}


def written_together(actuators: Sequence[Actuator]) -> list[dict[str, Any]]:
    """The same with one servo for all that are alike."""
    alike: dict[tuple[object, ...], list[Actuator]] = {}
    for actuator in actuators:
        alike.setdefault((actuator.kind, *sorted(actuator.values.items())), []).append(actuator)
    return [{**written(group[0]), "joints": [glob.escape(a.joint) for a in group]} for group in alike.values()]
