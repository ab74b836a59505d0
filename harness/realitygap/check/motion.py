"""Commands beside positions: unit, sign, order, and whether they are of one motion."""

from collections.abc import Sequence

import numpy as np
from realitygap_engines.law.dynamics import Dynamics

from realitygap.check.effort import pushed
from realitygap.check.follow import EXPLAINED, OFTEN, WEAK, Following, following
from realitygap.check.mistake import Mistake
from realitygap.check.observed import Mask, Observed
from realitygap.check.reading import beside_command
from realitygap.check.servo import stiffness
from realitygap.check.velocity import opposed
from realitygap.check.words import FAR_BETTER, STRONGEST, WEAKEST, factor_of, joined, unit, wide

MOVES, SLIDES = 0.1, 0.01
"""rad and m: a command or a position with less range is not told from sag, backlash, friction and offsets."""
QUANTA = 20.0
"""A motion has so many quanta, or its shape is not judged."""
UNEXPLAINED = 0.5
"""What two different motions of one robot explain of one another at most."""
NOTHING, MOST = 0.35, 0.75
"""A command that explains less than this has nothing to do with a motion that is as large as it asks for. Joints that
are weak beside the rest of a robot are thrown about by it, so that this is said of most joints together only, and of
none of a robot that may fall."""
PUSHED = 0.3
"""The share of a motion's effort that the side of its command tells (`effort.pushed`) where a servo at its limit makes
it: 0.52 to 0.78 was seen of drives that are too weak, and at most 0.12 of exchanged measurements of six robots."""
ALIKE = 4.0
"""Two motions are of comparable size within this factor."""


def moving(o: Observed) -> Mask:
    """The joints whose command or position moves enough to judge how one follows the other. Shape (n,)."""
    least = np.array([SLIDES if o.prismatic(j) else MOVES for j in range(len(o.joints))])
    on = np.isfinite(o.command)
    told, seen = wide(o.command), wide(np.where(on, o.position, np.nan))
    shaped = (seen > QUANTA * o.quantum) & (told > 0) & (on.mean(axis=0) > OFTEN)
    return np.asarray(o.follows & shaped & (np.maximum(told, seen) > least))


def motion_mistakes(o: Observed, others: Sequence[Observed]) -> list[Mistake]:
    """What is wrong between commands and positions of one recording; `others` are those of the same robot."""
    chosen = moving(o)
    if not chosen.any():
        return []
    either, along = following(o.command, o.position, o.step)
    units = [m for j in np.flatnonzero(chosen) if (m := _unit(o, either, int(j))) is not None]
    done = {joint for m in units for joint in m.joints}
    swapped = _swapped(o, along, chosen, done)
    done |= {joint for m in swapped for joint in m.joints}
    left = [int(j) for j in np.flatnonzero(chosen) if o.joints[j] not in done]
    flipped = [m for j in left if (m := _flipped(o, either, along, j)) is not None]
    done |= {joint for m in flipped for joint in m.joints}
    left = [j for j in left if o.joints[j] not in done]
    another = _another(o, along, left, int(chosen.sum()), others)
    return [*units, *swapped, *flipped, *another, *beside_command(o, along, left)]


def _unit(o: Observed, fit: Following, j: int) -> Mistake | None:
    """A position that is 57.3 or 1000 times its command, or the other way round.

    No servo turns a joint 11 times further than told. One that turns it a hundredth as far is too weak to be one: the
    command must also lie beyond what the joint can reach, or fit the factor as closely as stiff servos follow.
    """
    share, slope = fit.share[j, j], fit.slope[j, j]
    found = factor_of(o, j, slope) if share >= EXPLAINED else None
    if found is None:
        return None
    kind, factor = found
    joint, certain = o.joints[j], factor > 1.0
    if factor < 1.0:
        limits = o.plant.model.joints[j]
        farthest = float(np.nanmax(np.abs(o.command[:, j])))
        reach = max(abs(limits.lower), abs(limits.upper))
        certain = farthest > (2.0 * reach if np.isfinite(reach) else 4.0 * np.pi)
        close = abs(slope / factor - 1.0) < 0.15 and abs(fit.intercept[j, j]) < 0.15 * wide(o.position)[j]
        if not (certain or close):
            return None
    who = "position" if factor > 1.0 else "command"
    found_so = f"the position of {joint} is {slope:.3g} times its command (explains {share:.1%})"
    sentence = f"{found_so}: {_blamed(o, j, kind, who, max(factor, 1 / factor))}"
    return Mistake(kind, "certain" if certain else "likely", (joint,), sentence, o.line(who), (o.name,), who)


def _blamed(o: Observed, j: int, kind: str, who: str, factor: float) -> str:
    """What is in another unit, and how a scenario says it: a signal, or the other one, where its unit is stated."""
    rad, other = unit(o, j), "command" if who == "position" else "position"
    said = {"degrees": "deg", "thousandths": "mm" if o.prismatic(j) else ""}[kind]
    if said and o.stated_unit(other, j) == said:
        return (
            f"the {other} is in {rad} and not in {said}, as its unit is stated, or the {who} is in {said}, too; "
            f"expected both in {rad}: remove the {other}'s unit from `units` under recordings.columns, or add "
            f"`{who}: {said}`"
        )
    or_say = f", or `units: {{{who}: {said}}}` under recordings.columns" if said and o.holder != "data set" else ""
    return f"the {who} is not in {rad} but {factor:.3g} times as large, as it seems; expected both in {rad}{or_say}"


def _flipped(o: Observed, either: Following, along: Following, j: int) -> Mistake | None:
    """A position that goes against its command.

    Above its resonance a joint does that, too: it must be slow beside a servo that is `WEAK` times weaker than it says.
    """
    share, slope = either.share[j, j], either.slope[j, j]
    if not (share >= 0.8 and -STRONGEST <= slope <= -WEAKEST):
        return None
    if 1.0 - np.nan_to_num(along.share[j, j]) < FAR_BETTER * (1.0 - share):
        return None
    pace, resonance = _pace(o, j), _resonance(o, j)
    if pace > resonance:
        return None
    certain = share >= EXPLAINED and slope < -0.5 and pace < 0.7 * resonance / np.sqrt(WEAK)
    which = "the position" if opposed(o)[j] else "the command or the measurement"
    sentence = (
        f"the position of {o.joints[j]} goes against its command: {slope:.2f} times it (explains {share:.1%}; with the "
        f"same sign {np.nan_to_num(along.share[j, j]):.1%}): the sign of {which} is flipped; expected both to count "
        "as the URDF's axis"
    )
    who = "position" if opposed(o)[j] else "command"
    return Mistake("flipped_sign", "certain" if certain else "likely", (o.joints[j],), sentence, o.line(who), (o.name,))


def _pace(o: Observed, j: int) -> float:
    """The usual angular frequency of a motion [rad/s]: rms speed over spread."""
    q = o.position[:, j]
    return float(np.std(np.gradient(q, o.step)) / np.std(q))


def _resonance(o: Observed, j: int) -> float:
    """The angular frequency [rad/s] at which a joint on its servo's stiffness resonates."""
    d, model = o.plant.drive[j], o.plant.model
    dynamics = Dynamics(model)
    base = np.zeros(13)
    base[3] = 1.0
    dynamics.update(np.nanmedian(o.position, axis=0), np.zeros(len(o.joints)), base, np.zeros(3))
    first = 6 if model.floating else 0
    inertia = dynamics.inertia[first + j, first + j] + d["armature"]
    return float(np.sqrt(stiffness(o)[j] / inertia))


def _swapped(o: Observed, along: Following, chosen: Mask, done: set[str]) -> list[Mistake]:
    """Positions that follow one another's commands far better than their own, in a closed circle.

    A joint that is neither told to move nor moves closes a circle, too.
    """
    n = len(o.joints)
    share, slope = np.nan_to_num(along.share), np.nan_to_num(along.slope)
    told, seen = wide(o.command), wide(o.position)
    least = np.array([SLIDES if o.prismatic(j) else MOVES for j in range(n)])
    source: dict[int, int] = {}
    for j in range(n):
        if o.joints[j] in done or not o.follows[j]:
            continue
        if chosen[j] and seen[j] > least[j]:
            i = int(np.argmax(np.where(o.follows, share[:, j], 0.0)))
            better = share[i, j] >= EXPLAINED and 1.0 - share[j, j] > FAR_BETTER * (1.0 - share[i, j])
            if i != j and better and 0.4 <= slope[i, j] <= STRONGEST and told[i] > least[i]:
                source[j] = i
    targets = set(source.values())
    for j in targets - set(source):  # it is still: does a command that is still, and left over, suit it?
        free = [i for i in source if i not in targets and told[i] < least[i] and seen[j] < least[j]]
        if len(free) == 1 and told[j] > least[j]:
            source[j] = free[0]
    circle = {j for j in source if _returns(source, j)}
    if not circle:
        return []
    names = tuple(sorted(o.joints[j] for j in circle))
    pairs = joined([f"{o.joints[j]} that of {o.joints[source[j]]}" for j in sorted(circle)])
    gains = joined([f"{share[source[j], j]:.1%} against {share[j, j]:.1%}" for j in sorted(circle)])
    sentence = (
        f"these follow one another's command: {pairs} (explains {gains}); expected every joint to follow its own, "
        "under its own name"
    )
    return [Mistake("swapped_joints", "certain", names, sentence, o.line("command"), (o.name,))]


def _returns(source: dict[int, int], start: int) -> bool:
    """Whether following the sources from a joint leads back to it."""
    at = source.get(start)
    for _ in range(len(source)):
        if at is None or at == start:
            break
        at = source.get(at)
    return at == start


def _another(o: Observed, along: Following, left: list[int], count: int, others: Sequence[Observed]) -> list[Mistake]:
    """Positions that move as much as their commands, but otherwise."""
    share = np.nan_to_num(np.diag(along.share))
    told, seen = wide(o.command), wide(o.position)
    lost = [j for j in left if share[j] < UNEXPLAINED and 1 / ALIKE < seen[j] / max(told[j], 1e-12) < ALIKE]
    lost = [j for j in lost if told[j] > (SLIDES if o.prismatic(j) else MOVES)]
    if not lost:
        return []
    names = tuple(sorted(o.joints[j] for j in lost))
    explained = joined([f"{share[j]:.0%}" for j in lost])
    sentence = f"the command explains {explained} of the motion of {joined([o.joints[j] for j in lost])}"
    key = f"{o.key}.path"
    for other in others:
        if other is o or other.joints != o.joints:
            continue
        fit = _by_other(o, other, lost)
        if fit >= EXPLAINED and 1.0 - float(share[lost].mean()) > FAR_BETTER * (1.0 - fit):
            found = f"{sentence}, and that of {other.name} {fit:.1%}: it belongs to that motion"
            return [Mistake("another_motion", "certain", names, found, key, (o.name,))]
    if o.plant.model.floating or len(lost) < MOST * count or share[lost].max() > NOTHING:
        return []
    if any(pushed(o, j) > PUSHED for j in lost):
        return []
    told_so = f"{sentence}, which moves as far, through any lag and gain; expected a measurement of the same motion"
    return [Mistake("another_motion", "likely", names, told_so, key, (o.name,))]


def _by_other(o: Observed, other: Observed, joints: list[int]) -> float:
    """How much of some joints' motion the command of another recording explains, both from their beginning on."""
    clock = o.clock - o.clock[0]
    clock = clock[clock <= other.clock[-1] - other.clock[0]]
    if len(clock) < max(20, 0.4 * len(o.clock)):
        return 0.0
    index = np.clip(np.searchsorted(other.clock - other.clock[0], clock, side="right") - 1, 0, len(other.clock) - 1)
    _, fit = following(other.command[index][:, joints], o.position[: len(clock)][:, joints], o.step)
    return float(np.nan_to_num(np.diag(fit.share)).mean())
