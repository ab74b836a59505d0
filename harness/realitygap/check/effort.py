"""Measured efforts beside what the scenario's servos make of the measured errors.

By the servo: effort = a·error + b·speed + c·rate of the command (+ d·gathered error), by least squares. Whatever the
back-EMF, the derivative gain and friction are, `a` is the servo's stiffness, and above zero. A law with its own numbers
would not do: while a joint moves freely, stiffness and damping nearly cancel, and a gain that is a little off turns the
sign of what is left, as a delay that is a little off does. By the load, on a fixed base: effort = a·(what rigid bodies
take) + friction, and `a` is near 1; where it is, whatever the servo does is physics. All signals are smoothed alike, so
that the law between them stays.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from realitygap.check.follow import WEAK
from realitygap.check.mistake import Certainty, Mistake
from realitygap.check.observed import Mask, Observed
from realitygap.check.servo import limit, stiffness, working_error
from realitygap.check.words import FAR_BETTER, effort_unit, joined
from realitygap.trace.trace import Array

DELAYS = (0.0, 0.05, 0.1, 0.15, 0.2)
"""s: of the command on its way to the servo; the error that a servo saw is that of an earlier command."""
THOUSAND = 1000.0
CLEAR = 0.6
"""The share of an effort that its servo explains where a unit or a sign is read off the stiffness."""
PART = 0.3
"""And the least share of what the speed leaves that the error explains."""
ALONE = 3e-3
"""And the least share of an effort that nothing else explains: along one sine the speed does, up to rounding."""
FITS = 0.8
"""And where an effort is told from that of another joint: the law is exact, up to what is clipped and noise."""
EXACT = 0.98
"""An effort that fits its own joint so well is looked for at no other: joints that move alike fit each other's."""
BRAKING = 3.0
"""A dc servo that brakes at its no-load speed gives twice its stall torque; the rest is for its constants."""
IMPOSSIBLE = 10.0
"""Beyond this many times the limit, or the stiffness, no wrong constant is left to blame."""
SURE = 0.9
"""And where nothing but the servo tells the sign, on a floating base."""
SMOOTHED = 0.05
"""s: the mean over which effort and its causes are compared; a derivative gain makes spikes of held commands."""
STRONG = 0.1
"""An effort below this share of a servo's limit is friction and noise."""
UNRELATED = 0.05
"""What a servo explains of an effort that has nothing to do with it."""


@dataclass(frozen=True)
class EffortFit:
    """The fit of an effort.

    Attributes:
        share: of its variance that is explained.
        part: what the error (or the load) explains of what all else leaves.
        ratio: effort per error over the servo's own stiffness (or effort per load).
        alone: the share of its variance that nothing but the error (or the load) explains.
    """

    share: float
    part: float
    ratio: float
    alone: float = 1.0

    @property
    def clear(self) -> bool:
        """Whether a unit or a sign can be read off the ratio."""
        return self.share > CLEAR and self.part > PART and self.alone > ALONE

    @property
    def sign_fits(self) -> bool:
        """Whether it says that the sign is right."""
        return self.part > PART and self.ratio > 0

    @property
    def size_fits(self) -> bool:
        """Whether it says that the unit is right, too."""
        return self.part > PART and 1 / IMPOSSIBLE < self.ratio < IMPOSSIBLE


def effort_mistakes(o: Observed, judged: Mask, *, weighed: bool) -> list[Mistake]:
    """Efforts in another unit, with another sign, too large for any servo, or another joint's, where judged (n,).

    `weighed`: whether the links' masses are believed, so that what moving them takes tells something.
    """
    if o.effort is None or len(o.clock) < 50:
        return []
    out: list[Mistake] = []
    wrong: list[int] = []
    load = o.needed_effort if weighed and not o.plant.model.floating else None
    for j in np.flatnonzero(judged & np.isfinite(o.effort).any(axis=0)):
        by_load = _fit_load(o, int(j), load), _fit_load(o, int(j), load, rotor=True)
        fits = [fit_servo(o, int(j), int(j), delay) for delay in DELAYS] if o.follows[j] else [EffortFit(0.0, 0.0, 1.0)]
        found = _size(o, int(j), fits, *by_load) or _sign(o, int(j), fits, *by_load)
        if found is not None:
            out.append(found)
        if o.follows[j] and (found is not None or max(f.share for f in fits) < EXACT):
            wrong.append(int(j))
    swapped = _swapped(o, wrong)
    if swapped:
        out = [m for m in out if not set(swapped[0].joints) & set(m.joints)]
    return [*out, *swapped]


def pushed(o: Observed, j: int) -> float:
    """How much of what moving a joint takes is told by the side on which its command is, beside position and speed.

    A servo that is far too weak for its motion pushes towards the command with all it has; a measurement of another
    motion does not know where the command was. 0 on a floating base.
    """
    if o.plant.model.floating:
        return 0.0
    error = o.command[:, j] - o.position[:, j]
    on = np.isfinite(error)
    error = np.where(on, error, 0.0)
    side = np.tanh(error / (0.1 * error[on].std() + 1e-12))
    beside = [np.ones(len(side)), o.position[:, j], np.gradient(o.position[:, j], o.step)]
    fit = _solved(o, beside, side, o.needed_effort[:, j], on, 1.0)
    return fit.part if fit.ratio > 0 else 0.0


def _fit_load(o: Observed, j: int, load: Array | None, *, rotor: bool = False) -> EffortFit:
    """The effort of a joint by what moving its links takes, beside dry and viscous friction.

    With `rotor`, also beside a rotor behind a gear, of which models often say nothing, as heavy as it likes up to what
    some joint of the robot carries: a flange of 0.2 g·m² sits on a wrist's rotor of 1 kg·m², whose acceleration along a
    sine goes against the weight of the hand.
    """
    assert o.effort is not None
    known = np.isfinite(o.effort[:, j])
    if load is None or known.sum() < 50:
        return EffortFit(0.0, 0.0, 1.0)
    speed = np.gradient(o.position[:, j], o.step)
    slow = 0.1 * np.quantile(np.abs(speed), 0.9) + 1e-12
    beside = [np.ones(len(speed)), speed, np.tanh(speed / slow)]
    alike = [k for k in range(len(o.joints)) if o.prismatic(k) == o.prismatic(j)]
    heaviest = (o.acceleration[:, j], float(o.carried[alike].max())) if rotor else None
    return _solved(o, beside, load[:, j], o.effort[:, j], known, 1.0, heaviest)


def fit_servo(o: Observed, j: int, i: int, delay: float) -> EffortFit:
    """The effort of joint j by the error, speed and gathered error of joint i."""
    assert o.effort is not None
    error = working_error(o, delay)[:, i]
    on = np.isfinite(error) & np.isfinite(o.effort[:, j])
    if on.sum() < 50:
        return EffortFit(0.0, 0.0, 1.0)
    error = np.where(on, error, 0.0)
    speed = np.gradient(o.position[:, i], o.step)
    beside = [np.ones(len(speed)), speed, np.gradient(error, o.step) + speed]
    if o.plant.drive["ki"][i] > 0:
        beside.append(np.cumsum(error))
    return _solved(o, beside, error, o.effort[:, j], on, float(stiffness(o)[i]))


def _solved(
    o: Observed,
    beside: list[Array],
    cause: Array,
    effort: Array,
    on: Mask,
    own: float,
    rotor: tuple[Array, float] | None = None,
) -> EffortFit:
    """How much of an effort one signal explains beside others, and its weight over what it should be; `rotor` is one
    more, and its largest weight.
    """
    width = max(1, round(SMOOTHED / o.step))

    def smooth(value: Array) -> Array:
        return np.asarray(uniform_filter1d(np.where(on, value, 0.0), width, mode="nearest")[on])

    x, y = np.column_stack([smooth(v) for v in (*beside, cause)]), smooth(effort)
    heavy = None if rotor is None else (smooth(rotor[0]), rotor[1])
    without = _rest(x[:, :-1], y, heavy)[0]
    left, weights = _rest(x, y, heavy)
    total = float(np.sum((y - y.mean()) ** 2))
    if total <= 0.0 or without <= 0.0 or own <= 0.0:
        return EffortFit(0.0, 0.0, 1.0)
    return EffortFit(1.0 - left / total, 1.0 - left / without, float(weights[-1] / own), (without - left) / total)


def _rest(x: Array, y: Array, rotor: tuple[Array, float] | None = None) -> tuple[float, Array]:
    """The sum of squares that a linear fit leaves, and its weights; that of a rotor, which is none of them, is between
    zero and its largest.
    """
    if rotor is not None:
        turning, most = rotor
        left, (inertia, *weights) = _rest(np.column_stack([turning, x]), y)
        inside = min(max(inertia, 0.0), most)
        return (left, np.array(weights)) if inside == inertia else _rest(x, y - inside * turning)
    scale = np.maximum(np.abs(x).max(axis=0), 1e-300)
    weights = np.linalg.lstsq(x / scale, y, rcond=None)[0]
    return float(np.sum((y - x / scale @ weights) ** 2)), np.asarray(weights / scale)


def _size(o: Observed, j: int, fits: list[EffortFit], load: EffortFit, beside: EffortFit) -> Mistake | None:
    """An effort that is a thousand times what the servo gives, or beyond anything it can give.

    `load` is its fit by what moving its links takes, and `beside` that beside a rotor, which accuses less.
    """
    assert o.effort is not None
    joint, most = o.joints[j], limit(o)[j]
    large = float(np.nanquantile(np.abs(o.effort[:, j]), 0.95))
    best = max(fits, key=lambda f: f.share)
    cause = "what its servo makes of its error"
    if not best.clear and not o.follows[j]:
        best, cause = beside, "what moving its links takes"
    shown = best.clear and (o.follows[j] or best.part > CLEAR)
    unit = effort_unit(o, j)
    told = f"{abs(best.ratio):.3g} times {cause} (explains {best.share:.0%})"
    for factor, word in ((THOUSAND, "larger"), (1.0 / THOUSAND, "smaller")):
        by_slope = shown and 1 / WEAK < abs(best.ratio) / factor < WEAK
        by_limit = not shown and factor > 1 and 0.05 * factor * most < large < BRAKING * factor * most
        if by_slope or by_limit:
            said = told if by_slope else f"up to {large:.4g} {unit}, and its servo gives at most {most:.3g} {unit}"
            sentence = (
                f"the effort of {joint} is {said}: a thousand times {word}, as a current in mA is than one in A; "
                f"expected {unit}; give recordings.effort.factor in {unit} per recorded unit"
            )
            return Mistake("milliamperes", "certain", (joint,), sentence, "recordings.effort", (o.name,))
    by_slope = shown and abs(best.ratio) > IMPOSSIBLE and bool(o.follows[j]) and not load.size_fits  # a gain may be off
    if large > BRAKING * most or by_slope:
        said = told if by_slope else f"{large:.4g} {unit} or more for a twentieth of the time"
        sentence = (
            f"the effort of {joint} is {said}, and its servo gives at most {most:.3g} {unit}; expected {unit} of this "
            "servo; check recordings.effort.factor and the servo"
        )
        certainty: Certainty = "certain" if large > IMPOSSIBLE * most else "likely"
        return Mistake("effort_size", certainty, (joint,), sentence, "recordings.effort", (o.name,))
    return None


def _sign(o: Observed, j: int, fits: list[EffortFit], load: EffortFit, beside: EffortFit) -> Mistake | None:
    """An effort that pushes away from the command at any delay, that has no sign, or that has nothing to do with it; by
    its load as in `_size`.
    """
    assert o.effort is not None
    joint, key = o.joints[j], "recordings.effort"
    known = np.isfinite(o.effort[:, j])
    effort = o.effort[known, j]
    best = max(fits, key=lambda f: f.share)
    against = best.clear and all(f.ratio < 0 for f in fits if f.share > CLEAR)
    along = best.clear and best.ratio > 0
    if beside.clear and beside.part > CLEAR and beside.ratio < 0 and not along:
        against, told = True, f"{beside.ratio:.2f} times what moving its links takes (explains {beside.share:.0%})"
    elif against and not load.sign_fits:
        told = f"{best.ratio:.2f} times what its servo makes of its error at any delay (explains {best.share:.0%})"
        against = best.share > SURE or not o.plant.model.floating
    else:
        against = False
    if against:
        sentence = f"the effort of {joint} is {told}: its sign is flipped; expected it to push towards the command"
        return Mistake("flipped_sign", "certain", (joint,), sentence, key, (o.name,))
    if not o.follows[j]:
        return None
    force = stiffness(o)[j] * working_error(o, 0.0)[known, j]
    force = force[np.isfinite(force)]
    if len(force) < 50:
        return None
    tail, small = np.quantile(np.abs(force), 0.95), 0.05 * np.quantile(np.abs(effort), 0.95)
    both_ways = min(np.mean(force < -0.3 * tail), np.mean(force > 0.3 * tail)) > 0.1
    if both_ways and effort.any() and (effort.min() >= -small or effort.max() <= small) and best.share < FITS:
        sentence = (
            f"the effort of {joint} never changes its sign, and its error does: a magnitude, as it seems; expected it "
            "to push towards the command; leave it out with `effort: none`"
        )
        return Mistake("effort_direction", "likely", (joint,), sentence, key, (o.name,))
    large = np.quantile(np.abs(effort), 0.95) > STRONG * limit(o)[j] and tail > STRONG * limit(o)[j]
    if both_ways and large and _smooth(effort) and best.share < UNRELATED:
        sentence = (
            f"error and speed explain {best.share:.1%} of the effort of {joint}; expected it to push towards the "
            "command: an effort of another joint or another time, as it seems"
        )
        return Mistake("effort_direction", "likely", (joint,), sentence, key, (o.name,))
    return None


def _smooth(value: Array) -> bool:
    """Whether a signal is more than noise: neighbours are alike."""
    centred = value - value.mean()
    return bool(centred[1:] @ centred[:-1] > 0.9 * (centred @ centred))


def _swapped(o: Observed, joints: list[int]) -> list[Mistake]:
    """Efforts that fit one another's servos far better than their own."""
    source = {}
    for j in joints:
        own = max((fit_servo(o, j, j, d) for d in DELAYS[:3]), key=lambda f: f.share if f.ratio > 0 else 0.0)
        base = own.share if own.ratio > 0 else 0.0
        found = [(f.share, i) for i in joints if i != j for d in DELAYS[:3] if (f := fit_servo(o, j, i, d)).ratio > 0]
        share, i = max(found, default=(0.0, j))
        if share > FITS and 1.0 - base > FAR_BETTER * (1.0 - share):
            source[j] = i
    pairs = [j for j in source if source.get(source[j]) == j]
    if not pairs:
        return []
    told = joined([f"the effort of {o.joints[j]} is what the servo of {o.joints[source[j]]} gives" for j in pairs])
    names = tuple(sorted(o.joints[j] for j in pairs))
    return [
        Mistake(
            "swapped_joints", "certain", names, f"{told}; expected every joint's own", "recordings.effort", (o.name,)
        )
    ]
