"""Tosses of a free body: simulated from the measured state and held against flight, impact, slide and rest."""

from collections.abc import Sequence

import numpy as np
import realitygap_engines as engines
from realitygap_engines import Diverged, Failed, Ground, Physics
from realitygap_engines.errors import as_its_outcome
from realitygap_engines.model.robot import Array

from realitygap.recording.frames import angle_between
from realitygap.simulate.experiment import Experiment
from realitygap.simulate.flight import flying
from realitygap.simulate.rollout import rollout
from realitygap.trace.trace import Trace

BLOWN_UP = 10.0
"""The error of a toss that blows up in the simulation: as far as it can be, with half a turn everywhere."""


def toss_error(simulated: Trace, measured: Trace, half_width: float) -> float:
    """e_q = mean |Δp|² / w + mean Δθ², with positions in m, the body's half width w in m and angles in rad.

    As published in Acosta, Yang, Posa: Validating Robotics Simulators on Real-World Impacts (2022). There a simulation
    starts at the last sample before the first contact; here at the first sample.
    """
    s = simulated.at(measured.time)
    assert s.base_position is not None and measured.base_position is not None
    assert s.base_quaternion is not None and measured.base_quaternion is not None
    far = np.sum((s.base_position - measured.base_position) ** 2, axis=1)
    turned = angle_between(s.base_quaternion, measured.base_quaternion)
    return float(np.mean(far) / half_width + np.mean(turned**2))


def half_width(experiment: Experiment) -> float:
    """How far the body's contact points reach along its widest axis [m]."""
    spheres = experiment.plant.model.links[0].spheres
    return float(max(np.abs(s.center).max() + s.radius for s in spheres))


def toss_errors(engine: str, ground: Ground, tosses: Sequence[Experiment], step_rate: float) -> Array:
    """e_q of every toss in an engine, opened once: over all samples, and from the last before the impact. Shape (k, 2).

    Raises:
        Unsupported: where the engine does not know such a ground.
    """
    first = tosses[0]
    physics = Physics(1.0 / step_rate, first.scenario.physics.solver_iterations, ground)
    width = half_width(first)
    errors = []
    with engines.load(engine).open(first.plant.machine(), physics) as simulation:
        for toss in tosses:
            assert toss.recording is not None
            measured = toss.recording.trace
            start, length = toss.start(physics.timestep), toss.duration + physics.timestep
            try:
                with as_its_outcome(engine):
                    trace = rollout(simulation, toss.plant, toss.commands, start, length).trace
            except (Diverged, Failed):
                errors.append((BLOWN_UP, BLOWN_UP))
                continue
            shifted = Trace(
                trace.time + toss.begin,
                trace.joints,
                base_position=trace.base_position,
                base_quaternion=trace.base_quaternion,
            )
            late = measured.between(impact(toss), np.inf)
            errors.append((toss_error(shifted, measured, width), toss_error(shifted, late, width)))
    return np.array(errors)


def impact(toss: Experiment) -> float:
    """The recording's time of the last sample before the body touches the ground [s]; of the first where it lies."""
    assert toss.recording is not None
    trace = toss.recording.trace
    assert trace.base_position is not None and trace.base_quaternion is not None
    count = flying(toss.plant.model, trace.base_position, trace.base_quaternion)
    return float(trace.time[max(count - 1, 0)])
