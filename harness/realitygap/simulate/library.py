"""Simulation as a library: one motion of a scenario in one engine, and what was measured of it."""

import glob
from collections.abc import Sequence

from realitygap.files.errors import InputError, did_you_mean
from realitygap.files.validation import validate
from realitygap.recording.recording import Recording
from realitygap.scenario.added_effects import Effect, added_effects
from realitygap.scenario.engine_names import engine_names
from realitygap.scenario.file import ScenarioFile, Source, load_scenario
from realitygap.scenario.plain import plain
from realitygap.scenario.schema import EffectSpec
from realitygap.scenario.world import PhysicsSpec
from realitygap.simulate import experiment as one
from realitygap.trace.trace import Trace


def simulate(
    scenario: Source,
    engine: str,
    *,
    run: str | None = None,
    effects: Effect | Sequence[Effect] = (),
    step_rate: float | None = None,
) -> Trace:
    """One motion of a scenario in one engine, at the full step rate and on the recording's clock.

    Args:
        scenario: a scenario, the path of one, or a dict that says the same.
        engine: its name, as in `realitygap engines`.
        run: the recording whose commands are followed, by its name; None where there is one, or no recording at all.
        effects: physics that is added to the scenario's own, as `rg.effects` makes it. To replace an effect that the
            scenario has, override its `effects`.
        step_rate: steps per second [Hz], in place of the scenario's.

    Raises:
        InputError, ModelError: for whatever is wrong with the scenario, its files, or the arguments.
        Unsupported: where the engine cannot express the scenario.
        Diverged: where the simulation blows up.
        Failed: where the engine itself gives up.
    """
    (name,) = engine_names([engine], "engine")
    if step_rate is not None:
        validate("(simulate)", PhysicsSpec, plain({"step_rate": step_rate}))
    file = load_scenario(scenario)
    added = added_effects(file, effects)
    return one.simulate(_experiment(file, run, added), name, step_rate=step_rate).trace


def read_run(scenario: Source, run: str | None = None) -> Recording:
    """What was measured in one recording of a scenario; None where there is one.

    Raises:
        InputError, ModelError: for whatever is wrong with the scenario or its files.
    """
    file = load_scenario(scenario)
    recording = _experiment(file, run, []).recording
    if recording is None:
        raise InputError(f"{file.path}: recordings.runs: found none; expected a recording to read")
    return recording


def _experiment(file: ScenarioFile, run: str | None, effects: Sequence[EffectSpec]) -> one.Experiment:
    names = [case.name for case in file.cases()]
    if run is None and len(names) > 1:
        raise InputError(f"{file.path}: run: is missing; expected one of {', '.join(names)}")
    if run is not None and run not in names:
        known = f"expected one of {', '.join(names)}{did_you_mean(run, names)}" if names else "the scenario has none"
        raise InputError(f"{file.path}: run: found {run}; {known}")
    (found,) = one.experiments(file, only=["*" if run is None else glob.escape(run)], effects=effects)
    return found
