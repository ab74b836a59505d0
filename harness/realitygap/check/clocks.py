"""Clocks: times in another unit, streams that do not overlap, and streams whose clocks differ by an offset."""

import numpy as np

from realitygap.check.follow import DELAYS, LAGS, following, slowest
from realitygap.check.mistake import Mistake
from realitygap.check.observed import Mask, Observed
from realitygap.check.velocity import travel_slopes
from realitygap.check.words import FAR_BETTER, WEAKEST

SLOW, FAST = 0.2, 2e-5
"""s: a robot's motion is not recorded less often than this (a servo's bandwidth is some Hz, which needs ten samples a
second), and no bus is read more often than 50 000 times a second."""
FINE = 0.025
"""s: what is left of rows that repeat one another's time still shows the motion of a servo at this spacing."""
CERTAIN_SLOW = 1.0
"""s: at this spacing nothing is left of any motion of a servo."""
SEARCHED = 5.0
"""s: offsets that are searched for, either way, within two fifths of the recording."""
COARSE = 0.05
"""s: the least step of that search."""
BEFORE = -0.1
"""s: a measurement that comes this much before its command was stamped by another clock."""
LATE = 1.0
"""s: and one this much later too; less may be a controller that waits."""
EXPLAINED = 0.9
"""The share of a motion's variance that a shifted command explains: 0.91 to 1 was measured on five machines."""
CHOSEN = 2.0
"""An offset is the best of hundreds that are tried, so it has to be better by this factor more than `FAR_BETTER`."""

ENOUGH = 0.97
"""Where a delay and a lag that a servo may have explain so much, an offset has nothing to add."""


def time_unit(o: Observed, judged: Mask) -> list[Mistake]:
    """Times that are a thousand or a million times too long or too short, or so coarse that most rows repeat one.

    The travel by the reported velocity over the travel of the position is then that factor, at all joints (n,) that are
    judged.
    """
    slopes = travel_slopes(o, judged)
    by_velocity = float(np.median(np.abs(slopes))) if len(slopes) else 1.0  # a sign is another mistake
    key = f"{o.key}.path"
    if coarse := _coarse(o):
        certain = o.period >= CERTAIN_SLOW
        return [Mistake("coarse_times", "certain" if certain else "likely", o.joints, coarse, key, (o.name,))]
    for factor, name in ((1e3, "ms"), (1e6, "µs"), (1e9, "ns")):
        seen = f"; the velocities confirm it: they sum up to {by_velocity:.3g} times the positions' travel"
        fits = factor / 3.0 < by_velocity < factor * 3.0
        if o.period >= SLOW and SLOW <= o.period < SLOW * factor * 10 and (fits or not len(slopes)):
            certain = fits or o.period >= CERTAIN_SLOW
            sentence = (
                f"the samples of {o.name} are {o.period:.3g} s apart, as those of no recorded motion{seen * fits}: "
                f"times in {name}, as it seems; expected seconds; divide the times by {factor:g}"
            )
            if o.holder == "table":
                sentence += f", or say `units: {{time: {name.replace('µ', 'u')}}}` under recordings.columns"
            return [Mistake("milliseconds", "certain" if certain else "likely", o.joints, sentence, key, (o.name,))]
    fits = 1 / 3000.0 < by_velocity < 3e-3 and len(slopes) > 0
    if o.period <= FAST or (fits and o.period <= 100 * FAST):
        sentence = (
            f"the samples of {o.name} are {o.period:.3g} s apart, as those of no bus: times that were divided by 1000 "
            "once too often, as it seems; expected seconds"
        )
        return [Mistake("milliseconds", "certain", o.joints, sentence, key, (o.name,))]
    return []


def _coarse(o: Observed) -> str:
    """What is said of times that lack fractions of a second: most rows repeat one, so that less is left than shows a
    motion, or they are dates, which are in no other unit; "" of others.
    """
    same = max((lack for lack in o.recording.absent if lack.kind == "repeats"), key=lambda m: m.part, default=None)
    wanted = "; expected times with fractions of a second: log them so"
    if same is not None and same.part > 0.5 and o.period > FINE:
        told = f"the times of {o.name} have a resolution of {o.period:.3g} s: {same.text}"
        return f"{told}{wanted}, or number the rows in steps of their period where they came evenly"
    if o.recording.dated and o.period >= SLOW:
        return f"the samples of {o.name} are {o.period:.3g} s apart, as those of no recorded motion{wanted}"
    return ""


def no_overlap(o: Observed) -> list[Mistake]:
    """Commands that all lie before or after the measurement."""
    r = o.recording
    if r.command_kind is None or not len(r.command_time):
        return []
    start, end = float(r.trace.time[0]), float(r.trace.time[-1])
    sent = r.command_time[np.isfinite(r.command).any(axis=1)]
    if not len(sent):
        return []
    if (len(sent) > 1 and sent[-1] < start - o.period) or sent[0] > end:
        sentence = (
            f"commands come from {sent[0]:.3f} to {sent[-1]:.3f} s and states from {start:.3f} to {end:.3f} s, so that "
            "none was in force while the robot was measured; expected streams of one time, stamped by one clock"
        )
        return [Mistake("no_overlap", "certain", o.joints, sentence, "motion.recorded", (o.name,))]
    return []


def clock_offset(o: Observed, moving: Mask) -> list[Mistake]:
    """Commands and states that fit far better when one of them is shifted by more than a bus and a servo take.

    All joints are shifted alike; a servo may be `WEAK` times slower than its numbers say. A periodic motion fits
    shifted by a period, too: it is told only where no allowed delay does as well.
    """
    length = float(o.clock[-1] - o.clock[0])
    chosen = np.flatnonzero(moving)
    reach = min(SEARCHED, 0.4 * length)
    if not len(chosen) or reach < 0.3:
        return []
    lags = [lag for lag in LAGS if lag <= slowest(o)]
    every = max(1, round(COARSE / 2 / o.step))
    command, position, spacing = o.command[::every, chosen], o.position[::every, chosen], every * o.step
    either, fit = following(command, position, spacing, lags=lags)
    allowed = np.nan_to_num(np.diag(fit.share))
    if allowed.mean() > ENOUGH:
        return []
    step = max(COARSE, spacing)
    grid = step * np.arange(-round(reach / step), round(reach / step) + 1)
    best = (0.0, 0.0)
    for delay in grid[(grid <= BEFORE) | (grid > DELAYS[-1])]:
        _, fit = following(command, position, spacing, delays=[delay], lags=lags[:2], edges=False)
        share, slope = np.nan_to_num(np.diag(fit.share)), np.nan_to_num(np.diag(fit.slope))
        score = float(np.mean(np.where(slope > WEAKEST, share, 0.0)))
        if score > best[1]:
            best = (float(delay), score)
    offset, score = best
    turned = float(np.nan_to_num(np.diag(either.share)).mean())  # a sine shifted by half a period is a flipped one
    if score < EXPLAINED or 1.0 - max(float(allowed.mean()), turned) < CHOSEN * FAR_BETTER * (1.0 - score):
        return []
    certain = offset <= BEFORE or offset >= LATE
    order = "later than" if offset > 0 else "before"
    sentence = (
        f"states come {abs(offset):.2f} s {order} their commands: shifted by that, the commands explain {score:.1%} of "
        f"the motion, and with any delay that a servo has {allowed.mean():.1%}; expected streams that are stamped by "
        "one clock"
    )
    return [
        Mistake("clock_offset", "certain" if certain else "likely", o.joints, sentence, "motion.recorded", (o.name,))
    ]
