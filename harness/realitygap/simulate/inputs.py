"""What a simulation takes from a recording beside its commands: the supply, and what PID servos had gathered."""

from dataclasses import replace

from realitygap.recording import Recording
from realitygap.robot.plant import Plant
from realitygap.scenario.schema import Scenario
from realitygap.simulate.commands import Commands
from realitygap.simulate.start import start_integral
from realitygap.trace.trace import Array


def supply_of(recording: Recording | None, begin: float) -> tuple[Array, Array] | None:
    """Times on the simulation's clock [s] and voltages [V], shapes (k,); None where no supply was recorded."""
    if recording is None or not len(recording.supply):
        return None
    return recording.supply_time - begin, recording.supply


def integral_of(
    scenario: Scenario, plant: Plant, recording: Recording | None, commands: Commands, begin: float
) -> Array | None:
    """What PID servos have gathered at the beginning [N·m or N], shape (n,); None where nothing was recorded."""
    if recording is None:
        return None
    of_motor = scenario.effort_measures == "motor"
    measured = recording.trace if of_motor else replace(recording.trace, effort=None)
    return start_integral(plant, measured, commands, begin)
