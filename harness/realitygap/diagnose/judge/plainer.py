"""Plainer names after all, where a richer one says no more of the same law than laws are off by.

The search asks that too, as long as it has time: a round that is late tells which names cannot be told apart, and looks
for no others. Dry friction of 0.11 N·m was left told by side, as 0.096 and 0.126 N·m, and the plain one was likelier.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.changes import Change, Suspect, clash
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.held_out import as_wide, predicted
from realitygap.diagnose.likelihood.floors import measure
from realitygap.diagnose.search.apart import compare
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.rivals import FAR, ODDS, Rival
from realitygap.diagnose.search.search import Found
from realitygap.diagnose.search.simpler import narrower


def plainer(simulations: Simulations, found: Found, everyone: Sequence[Suspect], keep: Collection[Suspect]) -> Found:
    """What was found with the plainest name of the same law for each finding that says as much, all values fitted anew:
    likelier than the richer one, or as likely, or apart from it by no more than such laws are off by. `keep` stays, and
    what held-out runs speak for. The richer name is told as one that cannot be told from it.
    """
    for change in found.best.fit.changes:
        if change.suspect not in {*keep, *found.adjusted}:
            plain = _plain(simulations, found, change, everyone)
            found = found if plain is None else _renamed(simulations, found, change.suspect, plain)
    return found


def _plain(simulations: Simulations, found: Found, change: Change, everyone: Sequence[Suspect]) -> Scored | None:
    """The likeliest model with a plainer name that says as much in the place of a finding, the plain name last."""
    yardstick, best = found.yardstick, found.best
    rest = [c for c in best.fit.changes if c.suspect != change.suspect]
    said = list[Scored]()
    for suspect in everyone:
        if not narrower(suspect, change.suspect) or any(clash(suspect, c.suspect) for c in rest):
            continue
        quick = yardstick.fit([*rest, guess(yardstick.problem, suspect)], best.fit, "quick")
        if quick is None or best.evidence - quick.evidence > FAR * found.limit:
            continue
        full = yardstick.refined(quick)
        if full is not None and _says_as_much(simulations, found, change.suspect, full):
            said.append(full)
    return max(said, key=lambda scored: scored.evidence, default=None)


def _says_as_much(simulations: Simulations, found: Found, suspect: Suspect, plain: Scored) -> bool:
    """Whether a model with a plainer name says as much as the one that was found, and held-out runs do not speak for
    the richer one.
    """
    best, yardstick = found.best, found.yardstick
    likely = best.evidence - plain.evidence < ODDS or yardstick.alike(best.fit, plain.fit, suspect)
    return likely and predicted(simulations, found.floors, best.fit.changes, plain.fit.changes).worse


def _renamed(simulations: Simulations, found: Found, before: Suspect, plain: Scored) -> Found:
    """What was found with another name in the place of a finding; it is the last change of its model."""
    name = plain.fit.changes[-1].suspect
    without, gains, rivals = dict(found.without), dict(found.gains), dict(found.rivals)
    alone, others = without.pop(before, None), rivals.pop(before, [])
    gains.pop(before, None)
    if alone is not None:
        without[name], gains[name] = alone, plain.evidence - alone.evidence
    richer = Rival(before, found.best, *compare(found.yardstick.channels, plain, found.best))
    rivals[name] = [richer, *(r for r in others if name not in r.suspects)]
    least = {**found.least, name: found.least.get(before, found.limit)}
    return replace(
        found,
        best=plain,
        cautious=as_wide(found.yardstick.cautious(plain.fit), found.cautious),
        floors=measure(simulations, plain.fit.changes),
        gains=gains,
        without=without,
        rivals=rivals,
        least=least,
    )
