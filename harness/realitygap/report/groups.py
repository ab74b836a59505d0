"""Whose gaps are averaged: joints that move or do not, by their kind where a table has both, and the base.

The unit of a gap follows from its signal and the kind of its joint, so a group has one unit per signal.
"""

import pandas as pd

from realitygap.compare.gap import JOINT_SIGNALS, unit_of

SECTIONS = ("moving", "unmoving", "base")
KINDS = ("", " revolute", " prismatic")
GROUPS = tuple(f"{section}{kind}" for section in SECTIONS for kind in (KINDS if section != "base" else ("",)))
PRISMATIC = {unit_of(signal, True)[0] for signal in JOINT_SIGNALS}


def by_kind(gaps: pd.DataFrame) -> pd.DataFrame:
    """The table of gaps, with the kind of joint in its column `group` where it has joints of both kinds."""
    joints, slides = gaps["group"] != "base", gaps["unit"].isin(PRISMATIC)
    if slides[joints].nunique() < 2:
        return gaps
    kind = slides.map({True: KINDS[2], False: KINDS[1]}).where(joints, "")
    return gaps.assign(group=gaps["group"] + kind)


def groups(gaps: pd.DataFrame) -> list[str]:
    """The groups of a table, in the order people read them."""
    found = set(gaps["group"])
    return [group for group in GROUPS if group in found]


def joints_of(group: str) -> str:
    """A group in words: moving joints, unmoving prismatic joints, the base."""
    return "the base" if group == "base" else f"{group} joints"


def kinds(gaps: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
    """The joints of every kind in words, which are empty where a table has one kind, and their rows."""
    out = []
    for kind in KINDS:
        rows = gaps[gaps["group"].isin([f"moving{kind}", f"unmoving{kind}"])]
        if not rows.empty:
            out.append((f" of{kind} joints" if kind else "", rows))
    return out
