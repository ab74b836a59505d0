"""Whether everything that a scenario leaves out is there to be left out."""

from collections.abc import Sequence
from fnmatch import fnmatchcase

from realitygap.files.errors import InputError
from realitygap.scenario.file import ScenarioFile
from realitygap.simulate.experiment import Experiment


def check_excluded(file: ScenarioFile, experiments: Sequence[Experiment]) -> None:
    """Make sure that everything that is left out is there, in the robot of one of the experiments at least.

    Raises:
        InputError: for a pattern that matches nothing.
    """
    models = [e.plant.model for e in experiments]
    names = [n for m in models for n in (*m.joint_names, *(["base"] if m.floating else []))]
    for e in experiments:
        for pattern in e.scenario.recordings.exclude if e.scenario.recordings else []:
            if not any(fnmatchcase(n, pattern) for n in names):
                raise InputError(
                    f"{file.path}: recordings.exclude: {pattern} matches no joint; the robot has "
                    f"{', '.join(dict.fromkeys(names))}"
                )
