"""Whether a motion can be simulated at all, told before anything is."""

from realitygap.files.errors import InputError
from realitygap.recording import Recording
from realitygap.scenario.file import ScenarioFile
from realitygap.scenario.schema import Scenario
from realitygap.scenario.servos import DcServo, RecordedSupply

LARGEST = 5e8
"""Steps times joints that are simulated at most: seven hours of twenty joints at 1 kHz."""


def check_steps(file: ScenarioFile, scenario: Scenario, name: str, duration: float, joints: int) -> None:
    """Make sure that a motion of a duration [s] ends within hours.

    Raises:
        InputError: where it has too many steps.
    """
    rate, most = scenario.physics.step_rate, LARGEST / max(joints, 1)
    if duration * rate > most:
        raise InputError(
            f"{file.path}: physics.step_rate: found {rate:g}, which makes {duration * rate:.3g} steps of {name} "
            f"({duration:.3g} s); expected at most {most:.3g} steps with {joints} joints"
        )


def check_supply(file: ScenarioFile, scenario: Scenario, recording: Recording) -> None:
    """Make sure that a supply that servos take from the recording is in it.

    Raises:
        InputError: where it is not.
    """
    asked = [
        s.supply.recorded for s in scenario.servos if isinstance(s, DcServo) and isinstance(s.supply, RecordedSupply)
    ]
    if asked and not len(recording.supply):
        raise InputError(f"{file.path}: servos: supply {asked[0]} was not found in {recording.path}")
