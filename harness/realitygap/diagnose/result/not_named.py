"""Sentences that say why what was found is not named."""

from __future__ import annotations

from collections.abc import Collection

from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.judge.held_out import Against
from realitygap.diagnose.result.odds import odds
from realitygap.page.style import number


def beaten(suspect: Suspect) -> str:
    """Why a finding is adjusted that an unnamed effort explains better."""
    return (
        f"{suspect} is adjusted and not named: an unnamed effort in its place explains the recordings better, and does "
        "no more itself than laws are ordinarily off by"
    )


def wide(suspect: Suspect) -> str:
    """Why a finding is adjusted whose interval did tell it, before others were adjusted beside it."""
    return f"{suspect} is adjusted and not named: beside what else is, its interval holds what the model has already"


def usual(suspect: Suspect) -> str:
    """Why a finding is adjusted that laws may be off by, once others are adjusted beside it."""
    return (
        f"{suspect} is adjusted and not named: beside what else is, it does no more than laws of its kind may be off "
        "by, and the held-out gap is hardly larger without it"
    )


def vague(suspect: Suspect, adjusted: Collection[Suspect]) -> str:
    """Why a finding is not named whose interval does not tell it, of those that are adjusted or of none."""
    instead = f"{suspect} is {'adjusted and ' * (suspect in adjusted)}not named: "
    if suspect in adjusted and len(adjusted) > 1:
        return f"{instead}before others were adjusted beside it, its 95 % interval held what the model has already"
    return f"{instead}its 95 % interval holds what the model has already"


def held_out_against(suspect: Suspect, told: Against) -> str:
    """Why held-out runs speak against a finding."""
    if told.widens:
        before, after = map(number, told.gaps)
        return f"{suspect} widens the held-out gap, from {before} to {after} floors: not named"
    if told.silent:
        return f"{suspect} is not named: it shows on training runs only; hold out a run that shows it, too"
    gain, error = told.verdict.gain, told.verdict.error
    if gain <= 0.0:
        return (
            f"{suspect} is not named: it helps on training runs only, and with it held-out runs are {odds(-gain)} "
            "times less probable"
        )
    more = f"{suspect} is not named: with it held-out runs are {odds(gain)} times more probable"
    if told.verdict.worse:
        return f"{more}, which may be chance (in logarithms {gain:.1f} ± {error:.1f})"
    return f"{more}, and it explains less than laws leave that are only nearly right"
