"""Velocity: what is reported as such, beside the derivative of the position.

Travel by velocity and by position over a stretch of time are compared, for every pair of joints: unlike a derivative,
travel does not amplify the quantum of an encoder. A sensor may low-pass and scale: `recording.faults` tells that.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from realitygap.check.counts import PER_RAD
from realitygap.check.follow import Following, following
from realitygap.check.mistake import Mistake
from realitygap.check.observed import Mask, Observed
from realitygap.check.words import FACTORS, FAR_BETTER, factor_of, joined, unit
from realitygap.recording.faults import STRETCH
from realitygap.recording.noise import FEWEST, beyond_noise
from realitygap.recording.readers.units import RPM
from realitygap.scenario.schema import Stream
from realitygap.trace.trace import Array

QUANTA = 20.0
"""A joint moves by so many quanta within a stretch, or its velocity is not judged."""
APART = 10
"""Stretches beside one another: of 8000 joints at rest, of 20 to 200 samples of white noise, two fits of 100 had a
share above `FITS` with four such stretches, none with ten."""
FITS = 0.8
"""The share of the travel that a velocity explains where it belongs to the position: 0.95 to 1 was measured."""
NOTHING = 0.25
"""What one that does not belong to it may explain by chance: as two motions of the same robot do."""
NEAR_RPM = 1.15
"""So near to revolutions per minute a velocity may be in them: with what filters take off a fast motion."""
SENSOR = 3.0
"""A scale further from 1 is not a sensor's."""


def travels(o: Observed) -> tuple[Array, Array, Mask] | None:
    """Travel by position and by velocity over stretches of time [rad or m], and which joints with a velocity move.

    Shapes (k, n), (k, n), (n,). None where no velocity was recorded, or too little to tell motion from noise.
    """
    if o.velocity is None or len(o.clock) < FEWEST:
        return None
    span = max(1, min(round(STRETCH / o.step), len(o.clock) // APART))
    means = 0.5 * (o.velocity[1:] + o.velocity[:-1]) * o.step
    summed = np.vstack([np.zeros(len(o.joints)), np.cumsum(np.nan_to_num(means), axis=0)])
    by_position = o.position[span:] - o.position[:-span]
    largest = np.abs(by_position).max(axis=0)
    spread = by_position.std(axis=0)
    moves = (largest > QUANTA * o.quantum) & beyond_noise(by_position, o.position)
    moves &= spread > 1e-9 * (1.0 + np.abs(o.position).max(axis=0))
    known = np.isfinite(largest) & np.isfinite(o.velocity).any(axis=0)
    return by_position, summed[span:] - summed[:-span], np.asarray(moves & known)


def _fit(o: Observed) -> tuple[Following, Mask, Mask] | None:
    """Velocity travel (columns) by position travel (rows), which joints move, and whose velocity is there."""
    found = travels(o)
    if found is None:
        return None
    by_position, by_velocity, moves = found
    fit, _ = following(by_position, by_velocity, o.step, delays=(0.0,))
    return fit, moves, np.asarray(by_velocity.std(axis=0) > 0)


def travel_slopes(o: Observed, judged: Mask) -> Array:
    """Travel by velocity over travel by position, of the judged joints (n,) where the one explains the other. Shape
    (m,).
    """
    found = _fit(o)
    if found is None:
        return np.zeros(0)
    fit, moves, told = found
    share, slope = np.diag(fit.share), np.diag(fit.slope)
    return np.asarray(slope[judged & moves & told & (share > FITS)])


def opposed(o: Observed) -> Mask:
    """Joints whose velocity clearly has the sign against its position. Shape (n,)."""
    found = _fit(o)
    if found is None:
        return np.zeros(len(o.joints), dtype=bool)
    fit, moves, told = found
    with np.errstate(invalid="ignore"):
        return np.asarray(moves & told & (np.diag(fit.share) > FITS) & (np.diag(fit.slope) < 0))


def usual_slopes(observed: Sequence[Observed]) -> dict[str, float]:
    """The median over recordings of what each joint's velocity is of its position's derivative, where it is known.

    A sensor has one scale in all of them; a few quick moves between coarse readings may show another.
    """
    slopes: dict[str, list[float]] = {}
    for o in observed:
        found = _fit(o)
        if found is not None:
            fit, moves, told = found
            with np.errstate(invalid="ignore"):
                known = moves & told & (np.diag(fit.share) > FITS)
            for j in np.flatnonzero(known):
                slopes.setdefault(o.joints[j], []).append(float(fit.slope[j, j]))
    return {joint: float(np.median(values)) for joint, values in slopes.items()}


def velocity_mistakes(o: Observed, judged: Mask, usual: Mapping[str, float]) -> list[Mistake]:
    """Velocities with another unit, another sign, another joint's, or nobody's, at the joints (n,) that are judged.

    `usual` holds `usual_slopes` of all recordings of the robot.
    """
    found = _fit(o)
    if found is None:
        return []
    fit, moves, told = found
    share, slope = np.nan_to_num(fit.share), np.nan_to_num(fit.slope)
    key = o.line("velocity")
    out: list[Mistake] = []
    lost: list[int] = []
    for j in np.flatnonzero(judged & moves):
        joint, own, a = o.joints[j], share[j, j], slope[j, j]
        if not told[j]:
            sentence = (
                f"the velocity of {joint} never changes while its position moves; expected its derivative, or none: "
                f"{_without(o)}"
            )
            out.append(Mistake("velocity", "certain", (joint,), sentence, key, (o.name,)))
            continue
        if own < FITS:
            lost.append(int(j))
            continue
        factor = None if _as_of_counts(float(a)) else factor_of(o, int(j), float(a), weakest=0.5)
        if factor is not None:
            kind, times = factor
            sentence = (
                f"the velocity of {joint} is {abs(a):.3g} times the derivative of its position (explains {own:.1%}): "
                f"a factor of {times:.3g}, as of a unit; expected {unit(o, int(j))}/s{_told_units(o, kind, times)}"
            )
            out.append(Mistake(kind, "certain", (joint,), sentence, key, (o.name,), "velocity"))
        elif a < 0:
            sentence = (
                f"the velocity of {joint} is {a:.2f} times the derivative of its position (explains {own:.1%}): its "
                "sign is flipped; expected the same sense of rotation for both"
            )
            out.append(Mistake("flipped_sign", "certain", (joint,), sentence, key, (o.name,)))
        elif not 1.0 / SENSOR < usual.get(joint, a) < SENSOR:
            sentence = (
                f"the velocity of {joint} is {a:.3g} times the derivative of its position (explains {own:.1%}), more "
                f"than a sensor is off; expected a factor near 1{_told_rpm(o, float(a))}"
            )
            out.append(Mistake("velocity", "likely", (joint,), sentence, key, (o.name,)))
    return out + _of_others(o, share, slope, lost, key)


def _as_of_counts(slope: float) -> bool:
    """Whether a velocity is what counts make of rad, or rad of counts: closer to that than to thousandths."""
    off, between = abs(np.log(abs(slope))), np.sqrt(FACTORS["thousandths"] / PER_RAD)
    return bool(abs(off - np.log(PER_RAD)) < np.log(between))


def _without(o: Observed) -> str:
    """What to do about a velocity that is none, by what holds it."""
    state = None if o.scenario.recordings is None else o.scenario.recordings.state
    if o.holder != "bag" or state is None:
        return "`velocity: none` under recordings.columns leaves it out"
    if isinstance(state, Stream) and state.velocity is not None:
        return "recordings.state without `velocity` leaves it out"
    topic = state.topic if isinstance(state, Stream) else state
    return f"recordings.state: {{topic: {topic}, names: name, position: position}} leaves it out"


def _told_units(o: Observed, kind: str, times: float) -> str:
    """How a scenario says the unit of a velocity that is so many times too large, or does without it."""
    if o.holder == "data set":
        return f" where positions are in recordings.dataset.units: {_without(o)}"
    said = kind == "degrees" and times > 1.0
    return ", or `units: {velocity: deg}` under recordings.columns" if said else ""


def _told_rpm(o: Observed, slope: float) -> str:
    """How a scenario says that a velocity is in revolutions per minute, where it may be."""
    if o.holder == "data set" or abs(np.log(slope * RPM)) > np.log(NEAR_RPM):
        return ""
    return ": revolutions per minute are told by `units: {velocity: rpm}` under recordings.columns"


def _of_others(o: Observed, share: Array, slope: Array, lost: list[int], key: str) -> list[Mistake]:
    """Velocities that fit another joint's position, or none."""
    source = {}
    for j in lost:
        i = int(np.argmax(share[:, j]))
        better = share[i, j] > FITS and (1.0 - share[j, j]) > FAR_BETTER * (1.0 - share[i, j])
        if i != j and better and 0.5 < slope[i, j] < 2.0:
            source[j] = i
    swapped = {j for j in source if source[j] in source}
    out = []
    if swapped:
        names = tuple(sorted(o.joints[j] for j in swapped))
        pairs = joined([f"the velocity of {o.joints[j]} is that of {o.joints[source[j]]}" for j in sorted(swapped)])
        shares = ", ".join(f"{share[source[j], j]:.1%}" for j in sorted(swapped))
        sentence = f"{pairs} (explains {shares}); expected every joint's own"
        out.append(Mistake("swapped_joints", "certain", names, sentence, key, (o.name,)))
    for j in lost:
        if j not in swapped and share[j, j] < NOTHING:
            sentence = (
                f"the derivative of its position explains {share[j, j]:.1%} of the velocity of {o.joints[j]}; expected "
                f"more than 95 %: a velocity of another joint, another time, or none: {_without(o)}"
            )
            out.append(Mistake("velocity", "likely", (o.joints[j],), sentence, key, (o.name,)))
    return out
