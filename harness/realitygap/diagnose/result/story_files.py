"""The files of a mended model, and what each of them is, for the page."""

from collections.abc import Sequence
from pathlib import Path

from realitygap.diagnose.result.diagnosis import Diagnosis
from realitygap.diagnose.result.revise import BODY, MJCF, SCENARIO, mended_name


def told_files(result: Diagnosis, revised: Sequence[str]) -> list[tuple[str, str]]:
    """Every file of the mended model, by its path in the result folder, and what it is."""
    return [(name, _about(result, Path(name).name)) for name in revised]


def _about(result: Diagnosis, name: str) -> str:
    if name == SCENARIO:
        return "the scenario with the findings in it"
    if name == MJCF:
        return "scenario and robot in one file for plain MuJoCo"
    file = result.problem.file
    own = name == mended_name(file.resolve(file.scenario.robot.urdf, "robot.urdf"))
    who = "the robot" if own else "the robot of runs that have another one"
    if any(c.suspect.effect in BODY for c in result.mended):
        return f"{who}, with the masses and inertias that were found wrong"
    return f"{who} as it was: what was found stands in the scenario"
