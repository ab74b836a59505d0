"""Whether a finding does more than laws are ordinarily off by: what does not is no name, but a value to adjust.

Evidence tells that something is there, and how imperfect a machine's laws look beside it: with a droop of the torque
constant in the model, all laws may look eight times better than ordinary, so that it seems to stand out. A droop of 4 %
is one all the same. Of 45 findings beside nearly right laws, planted at two seeds, that were true the least did 1.2
times what laws of its kind are off by, or what none of them could do; of four that were false three did 0.4 to 0.7 of
it, and what the fourth did beyond all laws together was no more than chance.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.responses import residuals
from realitygap.diagnose.search.imperfections import SHARE
from realitygap.diagnose.search.search import Found
from realitygap.diagnose.search.yardstick import Yardstick


@dataclass(frozen=True)
class Done:
    """What a finding does to the training runs, as lengths in standard deviations of all samples together.

    Attributes:
        whole: all of it, where laws are exact.
        beyond: what is left of it where the laws of what was not found are ordinarily off.
        ordinary: what laws of its kind are ordinarily off by, where it sits.
    """

    whole: float
    beyond: float
    ordinary: float

    def named(self, limit: float) -> bool:
        """Whether it is more than laws are off by: what they could not do gains what a name has to, and either it is
        larger than what laws of its kind are off by, or they could not do most of it.
        """
        told = 0.5 * self.beyond**2 >= limit
        return told and (self.whole > self.ordinary or self.beyond**2 > 0.5 * self.whole**2)


def tolerated(simulations: Simulations, found: Found, told: Collection[Suspect]) -> Found:
    """What was found with what laws are ordinarily off by as no findings (`Found.adjusted`), which changes no value.

    What the recordings `told` by themselves stays named.
    """
    done = {s: d for s, d in all_done(simulations, found).items() if s not in told}
    return replace(found, adjusted=tuple(s for s, d in done.items() if not d.named(found.limit)))


def all_done(simulations: Simulations, found: Found) -> dict[Suspect, Done]:
    """What each finding does that is of a kind of law, or an effort without one, which may stand for any."""
    yardstick, fit = found.yardstick, found.best.fit
    asked = [c for c in fit.changes if c.suspect.kind.law in SHARE or c.suspect.table is not None]
    rest = [[c for c in fit.changes if c is not change] for change in asked]
    still, *without = residuals(simulations, [fit.changes, *rest], yardstick.train, yardstick.floors.coarse)
    exact, laws = yardstick.stood, yardstick.tolerant(fit)
    out = {}
    for change, answer in zip(asked, without, strict=True):
        if still is None or answer is None:
            continue
        suspect, does = change.suspect, np.nan_to_num(answer - still)
        whole, beyond = (float(np.linalg.norm(metric(does))) for metric in (exact, laws.metric))
        kinds = SHARE if suspect.table is not None else (suspect.kind.law,)
        out[suspect] = Done(whole, beyond, max(laws.imperfect.get(k, 1.0) * _off(yardstick, suspect, k) for k in kinds))
    return out


def _off(yardstick: Yardstick, suspect: Suspect, law: str) -> float:
    """What laws of a kind are known to, of what they do where a suspect sits."""
    return SHARE[law] * float(np.linalg.norm([yardstick.wrong.does.get((law, j), 0.0) for j in suspect.joints]))
