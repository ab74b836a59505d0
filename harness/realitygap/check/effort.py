"""Measured efforts beside what the scenario's servos would give for the measured errors."""

import numpy as np

from realitygap.check.follow import WEAK, Following, following
from realitygap.check.mistake import Mistake
from realitygap.check.observed import Mask, Observed
from realitygap.check.servo import limit, servo_effort
from realitygap.check.words import FAR_BETTER, joined
from realitygap.trace.trace import Array

DELAYS = (0.0, 0.05, 0.1, 0.15, 0.2)
"""s: of the command on its way to the servo; the error that a servo saw is that of an earlier command."""
THOUSAND = 1000.0
CLEAR = 0.6
"""The share of an effort that its servo's law explains where a unit or a sign is read off the slope."""
FITS = 0.8
"""And where it is told from that of another joint."""
STRONG = 0.1
"""An effort below this share of a servo's limit is friction and noise."""
BRAKING = 3.0
"""A dc servo that brakes at its no-load speed gives twice its stall torque; the rest is for its constants."""
IMPOSSIBLE = 10.0
"""Beyond this many times the limit no wrong constant is left to blame."""
UNRELATED = 0.02
"""What a servo's law explains of an effort that has nothing to do with it."""


def effort_mistakes(o: Observed, judged: Mask) -> list[Mistake]:
    """Efforts in another unit, with another sign, too large for any servo, or another joint's, where judged (n,)."""
    if o.effort is None or o.is_followed:
        return []
    known = np.isfinite(o.effort).all(axis=1)
    if known.mean() < 0.3 or known.sum() < 50:
        return []
    effort = o.effort[known]
    laws = [servo_effort(o, delay)[known] for delay in DELAYS]
    fits = [following(law, effort, o.step, delays=(0.0,), lags=(0.0,))[0] for law in laws]
    out: list[Mistake] = []
    lost = []
    for j in np.flatnonzero(judged & (np.abs(effort).max(axis=0) > 0)):
        found = _size(o, int(j), effort[:, j], fits) or _sign(o, int(j), effort[:, j], laws, fits)
        if found is not None:
            out.append(found)
        else:
            lost.append(int(j))
    swapped = _swapped(o, fits, [*lost, *_of_kind(o, out, "flipped_sign"), *_of_kind(o, out, "effort_direction")])
    if swapped:
        inside = set(swapped[0].joints)
        out = [m for m in out if not inside & set(m.joints)]
    return [*out, *swapped]


def _of_kind(o: Observed, mistakes: list[Mistake], kind: str) -> list[int]:
    return [o.joints.index(m.joints[0]) for m in mistakes if m.kind == kind]


def _best(fits: list[Following], i: int, j: int) -> tuple[float, float]:
    """Share and slope of the delay that fits best, of an effort (column j) by a law (row i)."""
    share = [float(np.nan_to_num(f.share[i, j])) for f in fits]
    k = int(np.argmax(share))
    return share[k], float(fits[k].slope[i, j])


def _size(o: Observed, j: int, effort: Array, fits: list[Following]) -> Mistake | None:
    """An effort that is a thousand times what the servo gives, or beyond anything it can give."""
    joint, most = o.joints[j], limit(o)[j]
    large = float(np.quantile(np.abs(effort), 0.95))
    share, slope = _best(fits, j, j)
    unit = "N" if o.prismatic(j) else "N·m"
    for factor, word in ((THOUSAND, "larger"), (1.0 / THOUSAND, "smaller")):
        by_slope = share > CLEAR and 1 / WEAK < abs(slope) / factor < WEAK
        by_limit = factor > 1 and large > IMPOSSIBLE * most and 0.01 * most < large / factor < BRAKING * most
        if by_slope or by_limit:
            told = f"{abs(slope):.3g} times what its servo gives (explains {share:.0%})" if by_slope else ""
            told = told or f"up to {large:.4g} {unit}, and its servo gives at most {most:.3g} {unit}"
            sentence = (
                f"the effort of {joint} is {told}: a thousand times {word}, as a current in mA is than one in A; "
                f"expected {unit}; give recordings.effort.factor in {unit} per recorded unit"
            )
            return Mistake("milliamperes", "certain", (joint,), sentence, "recordings.effort", (o.name,))
    if large > BRAKING * most:
        sentence = (
            f"the effort of {joint} is {large:.4g} {unit} or more for a twentieth of the time, and its servo gives at "
            f"most {most:.3g} {unit}; expected {unit} of this servo; check recordings.effort.factor and the servo"
        )
        certainty = "certain" if large > IMPOSSIBLE * most else "likely"
        return Mistake("effort_size", certainty, (joint,), sentence, "recordings.effort", (o.name,))
    return None


def _sign(o: Observed, j: int, effort: Array, laws: list[Array], fits: list[Following]) -> Mistake | None:
    """An effort that pushes away from the command at any delay, that has no sign, or that has nothing to do with it."""
    joint, law = o.joints[j], laws[0][:, j]
    on = np.isfinite(law)
    most = limit(o)[j] if np.isfinite(limit(o)[j]) else float(np.nanmax(np.abs(law), initial=0.0))
    if on.mean() < 0.4 or np.quantile(np.abs(law[on]), 0.95) < STRONG * min(most, 1e12):
        return None
    shares = np.array([float(np.nan_to_num(f.share[j, j])) for f in fits])
    slopes = np.array([float(np.nan_to_num(f.slope[j, j])) for f in fits])
    key = "recordings.effort"
    if shares.max() > CLEAR and (slopes < 0).all():
        sentence = (
            f"the effort of {joint} goes against its error: {slopes[shares.argmax()]:.2f} times what its servo gives "
            f"(explains {shares.max():.0%}), at any delay: its sign is flipped; expected it to push towards the command"
        )
        return Mistake("flipped_sign", "certain", (joint,), sentence, key, (o.name,))
    tail = np.quantile(np.abs(law[on]), 0.95)
    against = float(np.mean(law[on] < -0.3 * tail)), float(np.mean(law[on] > 0.3 * tail))
    small = 0.05 * np.quantile(np.abs(effort), 0.95)
    if min(against) > 0.1 and (effort.min() >= -small or effort.max() <= small):
        sentence = (
            f"the effort of {joint} never changes its sign, and its error does: a magnitude, as it seems; expected it "
            "to push towards the command; leave it out with `effort: none`"
        )
        return Mistake("effort_direction", "likely", (joint,), sentence, key, (o.name,))
    smooth = _smooth(effort) and float(np.quantile(np.abs(effort), 0.95)) > STRONG * most
    if smooth and shares.max() < UNRELATED and min(against) > 0.1:
        sentence = (
            f"its servo's law explains {shares.max():.1%} of the effort of {joint}; expected it to push towards the "
            "command: an effort of another joint or another time, as it seems"
        )
        return Mistake("effort_direction", "likely", (joint,), sentence, key, (o.name,))
    return None


def _smooth(value: Array) -> bool:
    """Whether a signal is more than noise: neighbours are alike."""
    centred = value - value.mean()
    return bool(centred[1:] @ centred[:-1] > 0.9 * (centred @ centred))


def _swapped(o: Observed, fits: list[Following], joints: list[int]) -> list[Mistake]:
    """Efforts that fit one another's servos far better than their own."""
    source = {}
    for j in joints:
        found = [(*_best(fits, i, j), i) for i in range(len(o.joints)) if i != j]
        if not found:
            return []
        share, slope, i = max(found)
        own, a = _best(fits, j, j)
        own = own if a > 0 else 0.0
        if share > FITS and slope > 0 and 1.0 - own > FAR_BETTER * (1.0 - share):
            source[j] = i
    pairs = [j for j in source if source.get(source[j]) == j]
    if not pairs:
        return []
    told = joined([f"the effort of {o.joints[j]} is what the servo of {o.joints[source[j]]} gives" for j in pairs])
    names = tuple(sorted(o.joints[j] for j in pairs))
    sentence = f"{told}; expected every joint's own"
    return [Mistake("swapped_joints", "certain", names, sentence, "recordings.effort", (o.name,))]
