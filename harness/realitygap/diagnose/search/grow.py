"""Moves that add: a finding, several at once, a richer shape, a value for every joint of a group; or one for all.

Forward selection.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import begun_again, everyday, richer
from realitygap.diagnose.data.changes import Change, ModelKey, Suspect, clash, model_key, stands_beside
from realitygap.diagnose.fit.responses import single
from realitygap.diagnose.search.evidence import EQUAL, Scored
from realitygap.diagnose.search.linear import linear_at
from realitygap.diagnose.search.prune import pruned
from realitygap.diagnose.search.rivals import FAR, LOOSER
from realitygap.diagnose.search.round import Round, told_change
from realitygap.robot.plant import Plant

TRIED = 4
"""Suspects that are tried one by one: those of most predicted gain, also where none has any. A friction beside a
play that had been fitted without it had a predicted gain below zero, and gained 118 where both were fitted."""
BEYOND = 2
"""The same of those that are far from linear, which were simulated at few sizes and whose predicted gain is too small;
and of those that lead the right way, as little of them as would. A torque that falls with speed did nothing at 8 N·m
and too much at 4, from where its fit gained 136, at 5.3."""
AT_ONCE = 3
"""Suspects that are tried together, as two that mean nothing alone, beside all that the linearised model would take."""
FITTED = 3
"""Ways that are fitted: those that gain most in a quick fit."""
HOPEFUL = 0.5
"""A quick fit finds at least this share of what a way gains: two steps take most of the way (`fit.FEW`). One that has
less in it is judged as a rival is (`exchange.FAR`)."""
SURE = 3.0
"""A gain in evidence beyond the logarithm of the number of suspects: odds of 20 to 1 against chance for all of them."""


Way = tuple[list[Change], float]
"""A model with more in it, and the evidence that it has to gain."""
Ways = Sequence[Way]


def grown(
    round_: Round, keep: Sequence[Suspect], failed: set[ModelKey], again: bool, ways: Ways | None = None
) -> Scored | None:
    """The best model with more in it, of all ways or of these, without what that makes superfluous; None where nothing
    gains enough.

    What each way gains is judged beyond what it needs: the limit for every finding, and for a shape odds of 20 : 1.
    Where there are more findings than before they gain more than `round_.little` as well; where there are fewer they
    may lose what those that go would have to gain.
    `keep` is never superfluous.
    `failed` are moves, told by the findings that they add and take away, that gained too little in a round before:
    many, where a model has many findings. Those that gain too little now join them. `again`: they are tried too, if
    nothing else gains enough.
    """
    here = model_key(round_.now.fit.changes)
    moves = [(way, needs, here ^ model_key(way)) for way, needs in (_ways(round_) if ways is None else ways)]
    first = [m for m in moves if m[2] not in failed]
    last = [m for m in moves if m[2] in failed]
    return _best(round_, keep, first, failed) or (_best(round_, keep, last, failed) if again else None)


def _best(
    round_: Round, keep: Sequence[Suspect], moves: Sequence[tuple[list[Change], float, ModelKey]], failed: set[ModelKey]
) -> Scored | None:
    """The best of some moves; None where none gains enough."""
    tried = []
    fitted = round_.simulations.side_by_side(round_.adjusted, [way for way, _, _ in moves])
    for (way, needs, move), quick in zip(moves, fitted, strict=True):
        fewer = len(round_.now.fit.changes) - len(way)
        if quick is not None and fewer > 0:
            needs = -max(fewer * round_.limit, round_.little(quick))
        gain = -np.inf if quick is None else quick.evidence - round_.now.evidence
        least = needs if quick is None or fewer >= 0 else max(needs, round_.little(quick))
        if quick is not None and (gain > HOPEFUL * least if least > 0.0 else gain - least > -FAR * round_.limit):
            tried.append((quick.evidence - needs, quick, needs, move))
        else:
            failed.add(move)
    better: list[tuple[float, Scored]] = []
    for estimate, near, needs, move in sorted(tried, key=lambda t: -t[0])[:FITTED]:
        if better and (round_.late or estimate < max(spare for spare, _ in better) - EQUAL):
            break
        scored = round_.criterion.refined(near)
        if scored is None:
            continue
        if len(scored.fit.changes) > len(round_.now.fit.changes) + 1:
            scored = pruned(round_, scored, keep)
            needs = round_.limit * max(len(scored.fit.changes) - len(round_.now.fit.changes), 0)
        if scored.evidence - round_.now.evidence > needs:
            round_.led(scored)
        gain = scored.evidence - round_.now.evidence
        here = {a.suspect for a in round_.now.fit.changes}
        new = [c for c in scored.fit.changes if c.suspect not in here]
        if scored.fit.changes:
            round_.say(f"  {'; '.join(told_change(c) for c in new or scored.fit.changes)}: {gain:+.1f}")
        more = len(scored.fit.changes) > len(here)
        least = max(round_.asked(scored, round_.now, needs), round_.little(scored) if more else -np.inf)
        if gain >= least:
            better.append((scored.evidence - needs, scored))
        else:
            failed.add(move)
            round_.short.update((c.suspect, (gain, least)) for c in new)
            if more and gain >= needs:
                round_.near.append(scored)
    most = max((spare for spare, _ in better), default=0.0)
    equal = [scored for spare, scored in better if spare > max(most - EQUAL, round_.now.evidence)]
    return min(equal, key=lambda s: len(s.fit.names), default=None)


def _ways(round_: Round) -> list[Way]:
    """Models with more in them, and the evidence that each has to gain."""
    return [*_with_one(round_), *_with_several(round_), *_at_each(round_), *_shaped(round_), *_begun_again(round_)]


def _with_one(round_: Round) -> list[Way]:
    """One suspect more, those of most predicted gain; at every joint as well, or at each with a value of its own."""
    accepted, limit = list(round_.now.fit.changes), round_.limit
    firsts = _most_predicted(round_)
    whole = {b.suspect for b in round_.blocks if b.start.kind == "whole"}
    far = [s for s in firsts if s.suspect in whole][:BEYOND]
    ways: list[Way] = []
    for start in far:  # a limit that is hardly reached has no slope to follow
        other = guess(round_.simulations.problem, start.suspect)
        if other.free == start.free:
            ways.append(([*accepted, other], limit))
    leading = [c for c in round_.lines.limits().values() if c not in firsts]
    ways += [([*accepted, change], limit) for change in leading[:BEYOND]]
    for start in [*firsts[:TRIED], *(s for s in far if s not in firsts[:TRIED])]:
        ways.append(([*accepted, start], limit))
        each = _each(round_, start, accepted) or _everywhere(round_, start)
        if each:
            ways.append(([*accepted, *each], limit * len(each)))
    return ways


def _most_predicted(round_: Round) -> list[Change]:
    """The starts of most predicted gain: all that have any, and `TRIED` at least."""
    first: dict[tuple[Suspect, tuple[str, ...]], Change] = {}
    for p in [*(p for p in round_.candidates if p.gain > 0.0), *round_.linear_gains]:
        start = p.block.start.first
        if p.gain > 0.0 or len(first) < TRIED:
            first.setdefault((start.suspect, start.free), start)
    return list(first.values())


def _with_several(round_: Round) -> list[Way]:
    """Several suspects more at once: those that the linearised model would take, and those of a plain fit."""
    accepted, limit, plant = list(round_.now.fit.changes), round_.limit, round_.simulations.problem.plant
    sensible = [p.block for p in round_.candidates if not p.block.start.first.absurd(plant)]
    several = linear_at(round_.look, sensible).several(limit)
    numbers = sorted({min(len(several), AT_ONCE), len(several)} - {0, 1})
    ways = [([*accepted, *(p.block.start.first for p in several[:n])], limit * n) for n in numbers]
    return ways + [([*accepted, *plain], limit) for plain in _plain_fits(round_)]


def _at_each(round_: Round) -> list[Way]:
    """What was found for all joints of a group, with a value at each."""
    accepted, ways = list(round_.now.fit.changes), list[Way]()
    for change in accepted:
        beside = [c for c in accepted if c is not change]
        each = _each(round_, change, beside)
        if each and change.free:
            ways.append(([*beside, *each], round_.limit * (len(each) - 1)))
    return ways


def _shaped(round_: Round) -> list[Way]:
    """What was found with a richer shape, that of all joints of an effect at once."""
    accepted, plant, ways = list(round_.now.fit.changes), round_.simulations.problem.plant, list[Way]()
    for of in alike(accepted):
        beside = [c for c in accepted if c not in of]
        tries = [tuple(with_shape(plant, c, looser) for c in of) for looser in LOOSER]
        for shaped in dict.fromkeys(tries):
            number = sum(new is not old for new, old in zip(shaped, of, strict=True))
            if number:
                ways.append(([*beside, *shaped], SURE * number))
    return ways


def _begun_again(round_: Round) -> list[Way]:
    """What was found from other values."""
    accepted, plant, ways = round_.now.fit.changes, round_.simulations.problem.plant, list[Way]()
    for change in accepted:
        again = begun_again(plant, change)
        if again != change:
            ways.append(([again if c is change else c for c in accepted], EQUAL))
    return ways


def shared(round_: Round) -> Ways:
    """Models with one value for all joints of a group in place of one at each, for when nothing gains any more."""
    accepted, ways = round_.now.fit.changes, []
    for of in alike(accepted):
        together = one_for_all(round_.everyone, of)
        if together is not None:
            rest = [c for c in accepted if c not in of]
            ways.append(([*rest, together], round_.limit * (1 - len(of))))
    return ways


def alike(changes: Sequence[Change]) -> list[list[Change]]:
    """What was fitted, by effect."""
    out: dict[str, list[Change]] = {}
    for change in changes:
        if change.free:
            out.setdefault(change.suspect.effect, []).append(change)
    return list(out.values())


def with_shape(plant: Plant, change: Change, looser: float) -> Change:
    """A change with its shape freed too, or as it is where there is none to free.

    A limit beside one that is there already begins at so many times its first size: from one that is too tight no fit
    finds back, and one that is too loose does nothing.
    """
    shaped = richer(plant, change)
    if shaped is None or shaped.free == change.free:
        return change
    return shaped.at({n: looser * shaped.parameters[n] for n in shaped.free if not np.isfinite(change.parameters[n])})


def one_for_all(everyone: Sequence[Suspect], alike: Sequence[Change]) -> Change | None:
    """One value for all joints of a group in place of one at each; None where they are no group."""
    joints = {i for c in alike for i in c.suspect.indices}
    groups = [s for s in everyone if s.effect == alike[0].suspect.effect and set(s.indices) == joints]
    if len(alike) < 2 or not groups or any(c.free != alike[0].free for c in alike):
        return None
    names = alike[0].parameters
    middle = {n: float(np.median([c.parameters[n] for c in alike])) for n in names}
    return Change(groups[0], tuple(middle.items()), alike[0].free)


def _plain_fits(round_: Round) -> list[list[Change]]:
    """All that a plain fit would have free beside the accepted model, where the linearised model leads: alone, and
    beside each of those that are far from linear that would gain most there. What limits a motion shows little before
    its friction and gains are right, and these are mended in its place. Once less is predicted than is explained, what
    the linearised model says is superfluous is left out: near by it is true.
    """
    lines, plain = round_.lines, _plain_blocks(round_)
    suspect = [b.suspect for b in lines.blocks]
    alone = lines.gain(plain)
    if len(plain) < 2 or alone <= 0.0:
        return []
    beside: dict[tuple[Suspect, tuple[str, ...]], tuple[float, int]] = {}
    for i, block in enumerate(lines.blocks):
        if block.start.kind == "linear" or block.columns.shape[1] > 1:
            continue
        which, gain = (suspect[i], block.start.first.free), lines.gain(_free(round_, plain, i), i)
        if gain > (beside[which][0] if which in beside else alone):
            beside[which] = gain, i
    ways = []
    for tried in [None, *(i for _, i in sorted(beside.values(), key=lambda b: -b[0])[:BEYOND])]:
        free = plain if tried is None else _free(round_, plain, tried)
        if alone < round_.explained:
            free = lines.earning(free, round_.limit, tried)
        far = [] if tried is None else [lines.blocks[tried].start.tries[0]]
        if len(free) + len(far) > 1:
            ways.append([*(p.change for p in lines.together(free, tried)), *far])
    return ways


def _free(round_: Round, plain: Sequence[int], tried: int) -> list[int]:
    """The blocks of a plain fit that can stand beside one."""
    blocks = round_.blocks
    return [k for k in plain if not clash(blocks[k].suspect, blocks[tried].suspect)]


def _plain_blocks(round_: Round) -> list[int]:
    """The numbers of the blocks of a plain fit: at single joints where that can be."""
    problem = round_.simulations.problem
    chosen: dict[tuple[str, int], int] = {}
    for number, block in enumerate(round_.blocks):
        suspect = block.suspect
        for i in suspect.indices if everyday(problem, suspect) and block.start.kind == "linear" else ():
            known = chosen.setdefault((suspect.effect, i), number)
            if len(suspect.indices) < len(round_.blocks[known].suspect.indices):
                chosen[suspect.effect, i] = number
    return list({round_.blocks[n].suspect: n for n in chosen.values()}.values())


def _everywhere(round_: Round, start: Change) -> list[Change]:
    """The effect of one joint at all where it would gain enough, as joints of a robot are alike; none if at one
    alone.
    """
    if not single(start.suspect):
        return []
    found = {start.suspect: start}
    for p in round_.linear_gains:
        alike = p.block.suspect.effect == start.suspect.effect and p.block.start.first.free == start.free
        if alike and single(p.block.suspect) and p.gain > round_.limit:
            found.setdefault(p.block.suspect, p.change)
    return list(found.values()) if len(found) > 1 else []


def _each(round_: Round, change: Change, beside: Sequence[Change]) -> list[Change]:
    """The change of a group as one at every joint of it; none where it is at one joint."""
    group = change.suspect
    if len(group.indices) < 2:
        return []
    alone = [s for s in round_.everyone if s.effect == group.effect and len(s.indices) == 1]
    inside = [s for s in alone if s.indices[0] in group.indices]
    free = [s for s in inside if stands_beside(s, [b.suspect for b in beside])]
    return [replace(change, suspect=s) for s in free] if len(free) > 1 else []
