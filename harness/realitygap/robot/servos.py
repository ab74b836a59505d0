"""The servos of a scenario: those that it names, or else what the robot's own file says drives its joints."""

import glob
from collections.abc import Sequence
from typing import Any

from pydantic import TypeAdapter
from realitygap_engines.model.robot import Actuator, Model

from realitygap.scenario.schema import AnyServo, Scenario


def servos_of(scenario: Scenario, model: Model) -> tuple[list[AnyServo], list[str]]:
    """The servos, and a sentence where they come from the robot's file."""
    if scenario.servos or not model.actuators:
        return scenario.servos, []
    servos = [TypeAdapter(AnyServo).validate_python(written(actuator)) for actuator in model.actuators]
    return servos, [f"no servos in the scenario: those of {len(servos)} actuators in the robot's file are used"]


def written(actuator: Actuator) -> dict[str, Any]:
    """An actuator as a servo is written in a scenario."""
    return {"joints": glob.escape(actuator.joint), "kind": actuator.kind, **actuator.values}


def written_together(actuators: Sequence[Actuator]) -> list[dict[str, Any]]:
    """The same with one servo for all that are alike."""
    alike: dict[tuple[object, ...], list[Actuator]] = {}
    for actuator in actuators:
        alike.setdefault((actuator.kind, *sorted(actuator.values.items())), []).append(actuator)
    return [{**written(group[0]), "joints": [glob.escape(a.joint) for a in group]} for group in alike.values()]
