"""The model of a scenario, with its servos and effects, as a MJCF file."""

from pathlib import Path

from realitygap_engines import Physics

from realitygap.files.errors import InputError
from realitygap.files.whole import write_whole
from realitygap.robot.effects.place import place
from realitygap.robot.mjcf import write_mjcf
from realitygap.robot.plant import build_plant
from realitygap.scenario.file import load_scenario


def write_scenario_mjcf(scenario: Path, target: Path) -> list[str]:
    """Write the MJCF of a scenario as it stands, without what single runs say otherwise, and tell what it cannot say.

    Raises:
        InputError: for a scenario that cannot be used.
    """
    file = load_scenario(scenario)
    try:
        plant = place(build_plant(file), file.scenario.effects)
    except InputError as error:
        raise InputError(f"{scenario}: {error}") from None
    text, lost = write_mjcf(plant, Physics(file.scenario.timestep, ground=plant.ground))
    write_whole(target, text)
    recordings = file.scenario.recordings
    others = [run.path for run in recordings.runs if run.overrides] if recordings else []
    if others:
        lost = [*lost, f"what differs in the runs {', '.join(others)}"]
    return [f"mjcf: {target}", *(f"  it does not say: {sentence}" for sentence in lost)]
