"""The missing effort of one recording, beside all that it may depend on."""

from dataclasses import dataclass

import numpy as np
from realitygap_engines import Unsupported
from realitygap_engines.errors import as_its_outcome

from realitygap.files.errors import InputError
from realitygap.missing.driven import lacking_driven
from realitygap.missing.followed import lacking_followed
from realitygap.missing.lacking import Lacking
from realitygap.robot.law.effort_map import TURNING
from realitygap.simulate.experiment import Experiment
from realitygap.simulate.follow import Followed, check_clear
from realitygap.simulate.inputs import integral_of, supply_of
from realitygap.trace.trace import Array

BAND = 1.96
"""Standard errors to either side of a band that holds the truth in 95 of 100 cases."""


@dataclass(frozen=True)
class MissingEffort:
    """The effort that would have to be added to a model's joints for it to follow one recording.

    It acts on the joint, as friction does: what brakes is against the speed.

    Attributes:
        name: of the recording.
        engine: whose dynamics the model has.
        use: train, held_out or None.
        joints: n names.
        slides: which of them are prismatic: N in place of N·m, m of rad. Shape (n,).
        time: in the judged window, on the recording's clock [s]. Shape (t,).
        effort: that is missing [N·m or N]. Shape (t, n).
        error: its standard error, from the sensor's noise and what that leaves open. Shape (t, n).
        variables: what it may depend on, by the names of `robot.effort_map.VARIABLES`, and the temperature; those
            that are known. Each shape (t, n).
    """

    name: str
    engine: str
    use: str | None
    joints: tuple[str, ...]
    slides: tuple[bool, ...]
    time: Array
    effort: Array
    error: Array
    variables: dict[str, Array]

    def __repr__(self) -> str:
        sizes = ", ".join(f"{j} {s:.3g}" for j, s in zip(self.joints, self.size, strict=True))
        return f"<MissingEffort {self.name} in {self.engine}: rms {sizes}>"

    @property
    def size(self) -> Array:
        """Its root mean square [N·m or N]. Shape (n,)."""
        return np.asarray(np.sqrt(np.mean(self.effort**2, axis=0)))

    @property
    def band(self) -> tuple[Array, Array]:
        """Between these it lies in 95 of 100 cases. Shapes (t, n)."""
        return self.effort - BAND * self.error, self.effort + BAND * self.error


def missing_of(experiment: Experiment, engine: str) -> MissingEffort:
    """The missing effort of one recording in one engine.

    Raises:
        InputError: where no joint position was measured, or a moving link of a fixed robot touches the ground.
        Unsupported: for a floating base, whose forces from the ground were not measured, for joints that are coupled,
            and for what the engine cannot express.
        Failed: where the engine fails.
    """
    plant, recording = experiment.plant, experiment.recording
    if recording is None or recording.trace.position is None or not plant.model.joints:
        raise InputError(f"{experiment.name}: found no measured joint position, which a missing effort is told from")
    if plant.model.floating:
        raise Unsupported("a missing effort is of a fixed base: what the ground does to a floating one is not known")
    if any(j.mimic is not None for j in plant.model.joints):
        raise Unsupported("a missing effort is of joints that move on their own, not of coupled ones")
    with as_its_outcome(engine):
        found, since = _lacking(experiment, engine)
    time, trace = since + experiment.begin, recording.trace
    aimed = experiment.followed is None and recording.command_kind == "position"
    volts = np.interp(time, recording.supply_time, recording.supply) if len(recording.supply) else None
    told = trace.command if aimed else None
    variables = variables_of(since, found.position, found.velocity, found.load, told, volts, trace.temperature)
    inside = (time >= experiment.window[0]) & (time <= experiment.window[1]) & np.isfinite(found.effort).all(axis=1)
    if not inside.any():
        raise InputError(f"{experiment.name}: found no sample in its window that tells a missing effort")
    return MissingEffort(
        name=experiment.name,
        engine=engine,
        use=experiment.use,
        joints=tuple(plant.model.joint_names),
        slides=tuple(j.prismatic for j in plant.model.joints),
        time=time[inside],
        effort=found.effort[inside],
        error=found.error[inside],
        variables={name: values[inside] for name, values in variables.items()},
    )


def _lacking(e: Experiment, engine: str) -> tuple[Lacking, Array]:
    """What the motion tells, and its stamps since it began [s]."""
    assert e.recording is not None
    trace = e.recording.trace
    assert trace.position is not None
    since, start = trace.time - e.begin, e.start()
    if e.followed is not None:
        assert trace.effort is not None
        of_joint = e.scenario.effort_measures == "joint"
        return lacking_followed(engine, e.plant, e.followed, start, trace.effort, of_joint=of_joint), since
    check_clear(e.plant, Followed(since, trace.position), start)
    integral = integral_of(e.scenario, e.plant, e.recording, e.commands, e.begin)
    supply = supply_of(e.recording, e.begin)
    found = lacking_driven(
        engine, e.plant, start, since, trace.position, e.commands, supply,
        np.zeros(len(trace.joints)) if integral is None else integral, e.scenario.timestep,
    )  # fmt: skip
    return found, since


def variables_of(
    time: Array,
    position: Array,
    velocity: Array,
    load: Array,
    command: Array | None,
    supply: Array | None,
    temperature: Array | None,
) -> dict[str, Array]:
    """What a missing effort may depend on, of what is known, by the names of `effort_map`, and the temperature, which
    that has not. Each shape (t, n).

    Args:
        time: [s]. Shape (t,).
        position: of the joints [rad or m]. Shape (t, n).
        velocity: [rad/s or m/s]. Shape (t, n).
        load: what moving and holding the links takes [N·m or N]. Shape (t, n).
        command: of position servos, NaN where one is off: no error [rad or m]. Shape (t, n).
        supply: [V]. Shape (t,).
        temperature: of the motors [°C]. Shape (t, n).
    """
    out = {"angle": position, "speed": velocity, "load": load}
    if command is not None:
        out["error"] = np.where(np.isfinite(command), command - position, 0.0)
    out["reversal"] = np.column_stack([since_reversal(time, v) for v in velocity.T])
    if supply is not None:
        out["supply"] = np.repeat(supply[:, None], position.shape[1], axis=1)
    if temperature is not None:
        out["temperature"] = temperature
    return out


def since_reversal(time: Array, speed: Array) -> Array:
    """How long ago the speed last changed its sign [s], or the motion began; as an `effort_map` has it. Shape (t,)."""
    moving = np.abs(speed) > TURNING
    heading = np.sign(speed[moving])
    turned = time[moving][1:][np.diff(heading) != 0]
    starts = np.concatenate([time[:1], turned])
    return np.asarray(time - starts[np.searchsorted(turned, time, side="right")])
