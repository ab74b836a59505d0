"""One recording ready to be simulated: the plant, the commands, the start, and what was measured."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from functools import cached_property

import numpy as np
from realitygap_engines import GRAVITY, Physics, State
from realitygap_engines.errors import as_its_outcome
from realitygap_engines.model.robot import Array

from realitygap.files.errors import InputError, standing
from realitygap.recording import Recording, read_recording
from realitygap.recording.sections import fitting_cases, unused_keys
from realitygap.robot.effects.place import known, place
from realitygap.robot.held import stated_start
from realitygap.robot.plant import Plant, build_plant
from realitygap.scenario.effort import fitted_factors
from realitygap.scenario.file import RunCase, ScenarioFile
from realitygap.scenario.schema import EffectSpec, EffortStream, Scenario
from realitygap.simulate.commands import Commands, going_on
from realitygap.simulate.drive_gain import Weighed, drive_gains, with_gains
from realitygap.simulate.feasible import check_steps, check_supply
from realitygap.simulate.flight import Launch, launch
from realitygap.simulate.follow import Followed, check_clear, check_maps, follow
from realitygap.simulate.inputs import integral_of, supply_of
from realitygap.simulate.midway import Midway
from realitygap.simulate.motion import first_goals, play, read_animation
from realitygap.simulate.opened import opened
from realitygap.simulate.rollout import Rollout, Stretch, rolled, steps_of
from realitygap.simulate.start import resting_twist, start_state
from realitygap.trace.sampled import Gather, sampled
from realitygap.trace.trace import Trace

Read = Callable[..., Recording]
"""A reader with the arguments of `read_recording`."""
PART = 1 << 16
"""Steps that are held at a time where not all of them are asked for."""
AFTER = 1.0
"""How long an animation goes on after its last keyframe [s]."""


@dataclass(frozen=True)
class Experiment:
    """One motion of a scenario.

    Attributes:
        name: of the recording, or of the scenario where nothing was recorded.
        scenario: with the overrides of this run.
        plant: with the scenario's effects.
        recording: what was measured; None where nothing was.
        commands: on the simulation's clock.
        begin: the recording's time at which the simulation starts [s].
        duration: of the simulation [s].
        use: train, held_out or None.
        window: what is judged, on the recording's clock [s].
        where: the scenario file and the key that the recording stands at.
        overrides: the scenario's keys that this run sets, as JSON.
        notes: sentences on what the recording shows to be wrong in the model, and was changed, and on what the scenario
            says of recordings and none of them takes.
        followed: the measured motion, where the joints follow it; None where they are driven.
        midway: the measured state in which it starts, where that is in the middle of a motion.
    """

    name: str
    scenario: Scenario
    plant: Plant
    recording: Recording | None
    commands: Commands
    begin: float
    duration: float
    use: str | None = None
    window: tuple[float, float] = (-np.inf, np.inf)
    where: str = ""
    overrides: str = ""
    notes: tuple[str, ...] = ()
    followed: Followed | None = None
    midway: Midway | None = None

    def with_plant(self, plant: Plant) -> "Experiment":
        """The same motion on another plant."""
        return replace(self, plant=plant)

    @cached_property
    def thrown(self) -> Launch | None:
        """How a free body was thrown; None for what stands or lies."""
        if self.scenario.robot.base != "free" or self.recording is None:
            return None
        return launch(self.plant.loaded(), self.recording.trace)

    def start(self, timestep: float | None = None) -> State:
        """The state at which a simulation with this step [s], by default the scenario's, starts; found once."""
        state = replace(self._begun)
        if self.scenario.robot.base == "free":
            # engines keep velocities half a step before positions: without this a flight falls g·h·t/2 too far
            early = 0.5 * (timestep or self.scenario.timestep)
            state.base_linear = state.base_linear + np.array([0.0, 0.0, GRAVITY * early])
        return state

    @cached_property
    def _begun(self) -> State:
        return _start(self)


def experiments(
    file: ScenarioFile,
    *,
    read: Read = read_recording,
    only: Sequence[str] = ("*",),
    effects: Sequence[EffectSpec] = (),
) -> list[Experiment]:
    """Every motion of a scenario: one per recording, or the one animation where nothing was recorded.

    Args:
        file: the scenario.
        read: what reads a recording; one that remembers saves time where many variants of a scenario are prepared.
        only: patterns over the recordings' names; the others are not read.
        effects: beside those of the scenario.

    Raises:
        InputError: for whatever is wrong with the scenario's files.
    """
    cases = fitting_cases(file)
    if not cases:
        if file.scenario.motion is None or file.scenario.motion.keyframes is None:
            raise InputError(f"{file.path}: recordings.runs: found none; expected recordings or motion: keyframes")
        return [_prepare(file, file.scenario, file.scenario.name, None, read, effects, {})]
    fitted = file.scenario.effort_is_fitted  # of all runs, whichever are asked for
    chosen = [case for case in cases if fitted or any(fnmatchcase(case.name, p) for p in only)]
    plants: dict[int, Plant] = {}
    found = [_prepare(file, case.scenario, case.name, case, read, effects, plants) for case in chosen]
    if fitted:
        found = _with_fitted_gains(file, found)
    if unused := unused_keys(file, cases):
        found = [replace(e, notes=(*unused, *e.notes)) for e in found]
    return [e for e in found if any(fnmatchcase(e.name, p) for p in only)]


def _with_fitted_gains(file: ScenarioFile, found: Sequence[Experiment]) -> list[Experiment]:
    """The same with the drive gains that the scenario leaves to be fitted."""
    effort = file.scenario.recordings.effort if file.scenario.recordings is not None else None
    names = found[0].plant.model.joint_names
    joints = fitted_factors(effort, names, file.path) if isinstance(effort, EffortStream) else []
    runs = []
    for e in found:
        if e.followed is None or e.recording is None or e.recording.trace.effort is None:
            raise InputError(
                f"{file.path}: recordings.effort.factor: found fit, which needs `motion: {{followed: true}}` and the "
                f"effort in every run; expected a number"
            )
        runs.append(Weighed(e.plant, e.followed, e.start(), e.recording.trace.effort))
    with standing(f"{file.path}: "):
        gains, errors = drive_gains(runs, joints)
    told = ", ".join(f"{names[j]} {g:.4g} ± {d:.2g}" for j, g, d in zip(joints, gains, errors, strict=True))
    out = []
    for e in found:
        assert e.recording is not None
        plant, recording = with_gains(e.plant, e.recording, joints, gains)
        out.append(replace(e, plant=plant, recording=recording, notes=(*e.notes, f"drive gains fitted: {told}")))
    return out


def _prepare(
    file: ScenarioFile,
    scenario: Scenario,
    name: str,
    case: RunCase | None,
    read: Read,
    effects: Sequence[EffectSpec],
    plants: dict[int, Plant],
) -> Experiment:
    """`plants` are those that were made already, by their scenario's id: most runs share both."""
    run = case.run if case else None
    if id(scenario) not in plants:
        plant = build_plant(file, scenario)
        with standing(f"{file.path}: "):
            plants[id(scenario)] = place(plant, [*scenario.effects, *effects])
    plant = plants[id(scenario)]
    recording, notes = None, list[str]()
    if case is not None:
        told = {"mimics": plant.model.mimics, "limits": plant.model.limits}
        with standing(f"{file.path}: {case.key}.path: ", file=file.path):
            recording = read(case.path, scenario, plant.model.joint_names, file=file.path, **told)
        check_supply(file, scenario, recording)
        if recording.trace.position is not None:
            plant, notes = plant.passing(recording.trace.position)
    commands, begin, duration = _commands(file, scenario, plant, recording)
    followed = _followed(file, scenario, recording, [*scenario.effects, *effects])
    if followed is None:
        check_steps(file, scenario, name, duration, len(plant.model.joints))
    else:
        notes.append(followed.told(plant.model.joint_names))
    experiment = Experiment(
        name=name,
        scenario=scenario,
        plant=plant,
        recording=recording,
        commands=commands,
        begin=begin,
        duration=duration,
        use=run.use if run else None,
        window=run.judged if run else (-np.inf, np.inf),
        where=f"{file.path}: {case.key}" if case else str(file.path),
        overrides=json.dumps(run.overrides, sort_keys=True) if run else "{}",
        notes=tuple(notes),
        followed=followed,
    )
    with standing(f"{file.path}: "):  # said now rather than after other motions were simulated
        start = experiment.start()
        if followed is not None:
            check_clear(plant, followed, start)
            check_maps(plant, supply=followed.supply is not None)
    return experiment


def _commands(
    file: ScenarioFile, scenario: Scenario, plant: Plant, recording: Recording | None
) -> tuple[Commands, float, float]:
    """Commands on the simulation's clock, where that clock starts in the recording, and how long it runs."""
    n = len(plant.model.joints)
    begin, duration = 0.0, 0.0
    if recording is not None:
        begin = float(recording.trace.time[0])
        duration = float(recording.trace.time[-1]) - begin
    motion = scenario.motion
    if motion is not None and motion.keyframes is not None:
        path = file.existing(motion.keyframes, "motion.keyframes", "an animation file")
        with standing(f"{file.path}: motion.keyframes: "):
            animation = read_animation(path)
            start = first_goals(path, animation, plant.model)
            if recording is not None and recording.trace.position is not None:
                start = recording.trace.position[0]
            commands, length = play(path, animation, plant.model, start)
        return commands, begin, duration or length + AFTER
    if recording is None or scenario.follows or not len(recording.command_time):
        return Commands(np.zeros(1), np.full((1, n), np.nan), held=not scenario.follows), begin, duration
    held = motion is None or motion.held
    return going_on(Commands(recording.command_time - begin, recording.command, held), duration), begin, duration


def _followed(
    file: ScenarioFile, scenario: Scenario, recording: Recording | None, effects: Sequence[EffectSpec]
) -> Followed | None:
    """The measured motion, where the joints are to follow it."""
    if not scenario.follows or recording is None:
        return None
    for spec in effects:
        reason = known(spec.effect).unseen_when_followed
        if reason:
            raise InputError(f"{file.path}: effects: {spec.effect} where the motion is followed: {reason}; take it out")
    assert recording.trace.position is not None
    return Followed(recording.trace.time, recording.trace.position, supply_of(recording, 0.0))


def _start(experiment: Experiment) -> State:
    plant, recording, scenario = experiment.plant, experiment.recording, experiment.scenario
    n = len(plant.model.joints)
    wanted = scenario.robot.start
    position: Array = np.zeros(n)
    if wanted == "recording" and recording is not None and recording.trace.position is not None:
        position = recording.trace.position[0] + plant.drive["offset"]
    elif wanted in ("recording", "keyframe") and scenario.motion is not None and scenario.motion.keyframes is not None:
        goals = experiment.commands.value[min(1, len(experiment.commands.value) - 1)]
        position = np.nan_to_num(goals) + plant.drive["offset"]  # a servo holds its reading there
    elif wanted == "keyframe":
        raise InputError("robot.start: found keyframe, but the motion has none; expected recording, zero or angles")
    elif isinstance(wanted, dict):
        position = stated_start(plant.model, wanted)
    if not np.isfinite(position).all():
        bad = plant.model.joint_names[int(np.flatnonzero(~np.isfinite(position))[0])]
        raise InputError(f"{experiment.name}: the first measured position of {bad} is missing")
    springs = plant.drive["stiffness"] > 0.0  # whose encoders are on the rotors
    position = position - np.where(springs, resting_twist(plant, experiment.commands, position), 0.0)
    trace = recording.trace if recording is not None and plant.model.floating else None
    thrown = experiment.thrown
    return start_state(
        plant,
        position,
        stand_on=scenario.robot.stand_on,
        base_position=thrown.position if thrown else _first(trace, "base_position"),
        base_quaternion=thrown.quaternion if thrown else _first(trace, "base_quaternion"),
        base_linear=thrown.linear if thrown else _first(trace, "base_linear"),
        base_angular=thrown.angular if thrown else _first(trace, "base_angular"),
    )


def _first(trace: Trace | None, signal: str) -> Array | None:
    value = getattr(trace, signal) if trace is not None else None
    return None if value is None or not np.isfinite(value[0]).all() else value[0]


def simulate(
    experiment: Experiment,
    engine: str,
    *,
    step_rate: float | None = None,
    at: Array | None = None,
    gather: Gather = sampled,
) -> Rollout:
    """Simulate one motion in one engine; the trace is on the recording's clock.

    The trace has every step; or, with times [s] `at`, shape (t,), what `gather` makes of its parts, of `PART` steps
    each, and of these times: what it says then, but for the commands.

    A motion that is followed is not integrated over time: its trace holds the smoothed readings and the effort that
    they take, at the measured stamps. In place of smaller steps, a higher `step_rate` adds its standard error to the
    effort.

    Raises:
        Unsupported, Diverged, Failed: as they say.
    """
    scenario, plant, recording = experiment.scenario, experiment.plant, experiment.recording
    of_joint = scenario.effort_measures == "joint"
    if experiment.followed is not None:
        finer = (step_rate or 0.0) > scenario.physics.step_rate
        with as_its_outcome(engine):
            done = follow(engine, plant, experiment.followed, experiment.start(), of_joint=of_joint, off=finer)
        return done if at is None else replace(done, trace=gather([done.trace], at))
    physics = Physics(1.0 / (step_rate or scenario.physics.step_rate), scenario.physics.solver_iterations, plant.ground)
    supply = supply_of(recording, experiment.begin)
    integral = integral_of(scenario, plant, recording, experiment.commands, experiment.begin)
    midway, h = experiment.midway, physics.timestep
    start = experiment.start(h) if midway is None else midway.state(plant, h)
    steps = steps_of(experiment.duration + h, h)
    with as_its_outcome(engine), opened(engine, plant.machine(), physics) as simulation:
        parts = rolled(
            simulation,
            plant,
            experiment.commands,
            start,
            steps,
            steps if at is None else PART,
            supply=supply,
            joint_effort=of_joint,
            integral=integral,
        )
        walls: list[float] = []
        found = (_on_recording(part, experiment, walls) for part in parts)
        trace = next(found) if at is None else gather(found, at)
        return Rollout(trace, steps, sum(walls), simulation.settings)


def _on_recording(part: Stretch, experiment: Experiment, walls: list[float]) -> Trace:
    """A part of a simulation on the recording's clock; `walls` takes how long it took."""
    walls.append(part.wall)
    return replace(part.trace, time=part.trace.time + experiment.begin)
