"""Which finding stands for which truth.

A name is right where effect and target are the truth's, where the truth stands among the first three of the named
effect's `cannot_tell_from`, or where the named effect is an exact twin of the truth that stands before it in the table.
"""

import fnmatch
from typing import Any

LISTED = 3
"""So many of `cannot_tell_from` count."""
Finding = dict[str, Any]


def places(target: Any, joints: list[str]) -> frozenset[str]:
    """What a target means: the joints that its patterns match, or its own name for a link, the base or the ground."""
    patterns = [target] if isinstance(target, str) else [str(x) for x in target]
    matched = [j for j in joints if any(fnmatch.fnmatchcase(j, p) for p in patterns)]
    return frozenset(matched or patterns)


def same(named: Finding, effect: str, target: Any, joints: list[str]) -> bool:
    """Whether a name is an effect at a target."""
    return named["effect"] == effect and places(named["target"], joints) == places(target, joints)


def is_right(finding: Finding, truth: Finding, joints: list[str]) -> bool:
    """Whether a finding counts as the truth."""
    names = [finding, *finding.get("cannot_tell_from", [])[:LISTED]]
    if any(same(n, truth["effect"], truth["target"], joints) for n in names):
        return True
    return any(same(finding, effect, target, joints) for effect, target in truth["twins"])


def match(findings: list[Finding], truths: list[Finding], joints: list[str]) -> list[int | None]:
    """The truth that each finding stands for, each at most once: plain names before alternatives."""
    out: list[int | None] = [None] * len(findings)
    left = set(range(len(truths)))
    for plain in (True, False):
        for i, finding in enumerate(findings):
            for k in sorted(left) if out[i] is None else []:
                t = truths[k]
                ok = same(finding, t["effect"], t["target"], joints) if plain else is_right(finding, t, joints)
                if ok:
                    out[i] = k
                    left.discard(k)
                    break
    return out


def spread(told: list[Finding], joints: list[str]) -> list[Finding]:
    """Findings or truths with one entry for each place: a value for all joints counts at each of them."""
    return [
        {**x, "target": place, "cannot_tell_from": _there(x.get("cannot_tell_from", [])[:LISTED], place, joints)}
        for x in told
        for place in sorted(places(x["target"], joints))
    ]


def _there(others: list[Finding], place: str, joints: list[str]) -> list[Finding]:
    """The same alternatives for one place of a finding."""
    return [{**o, "target": place} if place in places(o["target"], joints) else o for o in others]
