"""What the suite shows: one table of scores, one of goals, and which effect was named for which."""

import csv
import json
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import asdict, fields
from pathlib import Path

import numpy as np
from catalogue import COUNTS, NEARLY
from judge import Score
from planted import TABLE

NOTHING, OTHER_PLACE = "nothing", "other target"
LIMITS = {"one joint": 40.0, "two links": 60.0, "six joints": 120.0, "humanoid": 480.0}
"""Seconds that a diagnosis may take on two cores."""


def write_scores(scores: Iterable[Score], path: Path) -> None:
    """All scores, sorted, without timings."""
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, [f.name for f in fields(Score)], lineterminator="\n")
        writer.writeheader()
        for score in sorted(scores, key=lambda s: s.case):
            row = {
                k: "" if v is None else (f"{v:.4g}" if isinstance(v, float) else v) for k, v in asdict(score).items()
            }
            writer.writerow(row)


def _share(scores: list[Score], test: Callable[[Score], bool | None]) -> str:
    if not scores:
        return "-"
    good = sum(bool(test(s)) for s in scores)
    return f"{100 * good / len(scores):.0f} % ({good}/{len(scores)})"


def _median(values: list[float]) -> str:
    return f"{100 * np.median(values):.1f} %" if values else "-"


def size_of(robot: str) -> str:
    """The class of robot that a time limit is stated for."""
    if robot == "humanoid":
        return "humanoid"
    if robot == "arm":
        return "six joints"
    return "two links" if robot in ("planar", "skew") else "one joint"


def goals(scores: list[Score], seconds: dict[str, float]) -> list[tuple[str, str, str]]:
    """Rows of (what, goal, reached)."""
    by = {k: [s for s in scores if s.kind == k] for k in COUNTS}
    effects = [s for s in scores if s.first_right is not None and s.kind != "half"]
    nearly = [s for s in scores if s.kind.startswith(NEARLY)]
    hidden = [s for s in nearly if s.truths]
    silent = by["nearly_nothing"]
    exact = [s for s in scores if not s.kind.startswith(NEARLY)]
    several = by["several"] + by["nearly_several"]
    rows = [
        ("single effects: first name right", "≥ 98 %", _share(by["single"], lambda s: s.first_right)),
        ("single effects: exactly the right set", "≥ 97 %", _share(by["single"], lambda s: s.exact)),
        ("half the size, 100 Hz, no effort: exact", "≥ 92 %", _share(by["half"], lambda s: s.exact)),
        ("half the size, 100 Hz, no effort: a wrong name", "≤ 5 %", _share(by["half"], lambda s: s.wrong > 0)),
        ("pairs: both named, nothing added", "≥ 95 %", _share(by["pair"], lambda s: s.exact)),
        ("three effects: all named, nothing added", "≥ 90 %", _share(by["triple"], lambda s: s.exact)),
        ("nothing missing: nothing named", "100 %", _share(by["nothing"], lambda s: s.silent)),
        ("outside the list: no wrong name", "≥ 90 %", _share(by["outside"], lambda s: s.silent)),
        ("outside the list: the right variables", "≥ 90 %", _share(_mapped(scores), lambda s: s.variables_right)),
        ("nearly right laws: exact", "≥ 90 %", _share([s for s in hidden if s not in several], lambda s: s.exact)),
        ("nearly right laws: a wrong name", "≤ 5 %", _share(hidden, lambda s: s.wrong > 0)),
        ("nearly right laws, nothing missing: nothing named", "100 %", _share(silent, lambda s: s.silent)),
        ("several at every joint: named", "≥ 80 %", _ratio(several, "names_right", "truths")),
        ("several at every joint: right among named", "≥ 90 %", _ratio(several, "names_right", "names")),
        ("several at every joint: gap removed, median", "≥ 90 %", _removed(several)),
        ("95 % intervals that hold the truth", "≥ 90 %", _ratio(exact, "covered", "fitted")),
        ("95 % intervals, nearly right laws", "≥ 85 %", _ratio(nearly, "covered", "fitted")),
        ("truth among the named and cannot_tell_from", "≥ 95 %", _listed(scores)),
        (
            "parameter error, median",
            "≤ 5 %",
            _median([s.parameter_error for s in effects if s.parameter_error is not None]),
        ),
        ("held-out gap removed, median", "≥ 90 %", _removed(effects)),
    ]
    for name, limit in LIMITS.items():
        taken = [seconds[s.case] for s in scores if size_of(s.robot) == name and s.case in seconds]
        reached = f"median {np.median(taken):.0f} s, longest {max(taken):.0f} s" if taken else "-"
        rows.append((f"time, {name}", f"≤ {limit:.0f} s", reached))
    return rows


def _ratio(scores: list[Score], part: str, whole: str) -> str:
    """A share of counts over all scores."""
    good, total = (sum(getattr(s, name) for s in scores) for name in (part, whole))
    return f"{100 * good / total:.0f} % ({good}/{total})" if total else "-"


def _removed(scores: list[Score]) -> str:
    return _median([s.gap_removed for s in scores if s.gap_removed is not None])


def _listed(scores: list[Score]) -> str:
    total = sum(s.listed + s.unlisted for s in scores)
    good = sum(s.listed for s in scores)
    return f"{100 * good / total:.0f} % ({good}/{total})" if total else "-"


def _mapped(scores: list[Score]) -> list[Score]:
    return [s for s in scores if s.variables_right is not None]


def by_kind(scores: list[Score]) -> list[dict[str, str]]:
    """One row for each kind: how much of it is right, and how honest it is."""
    rows = []
    for kind in [k for k in [*COUNTS, "humanoid"] if any(s.kind == k for s in scores)]:
        chosen = [s for s in scores if s.kind == kind]
        row = {
            "kind": kind,
            "exact": _share(chosen, lambda s: s.exact),
            "a wrong name": _share(chosen, lambda s: s.wrong > 0),
            "of these the laws' own": _ratio(chosen, "besides", "wrong"),
            "named": _ratio(chosen, "names_right", "truths"),
            "right among named": _ratio(chosen, "names_right", "names"),
            "named or listed": _listed(chosen),
            "intervals that hold": _ratio(chosen, "covered", "fitted"),
            "parameter error": _median([s.parameter_error for s in chosen if s.parameter_error is not None]),
            "gap removed": _removed(chosen),
        }
        rows.append(row)
    return rows


def write_kinds(scores: list[Score], path: Path) -> None:
    """The table of `by_kind`, which tells nothing of a single case."""
    rows = by_kind(scores)
    if rows:
        with path.open("w", newline="") as file:
            writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)


def confusion(scores: list[Score]) -> Counter[tuple[str, str]]:
    """(planted, first named) over single effects; a right effect elsewhere is `other target`."""
    counts: Counter[tuple[str, str]] = Counter()
    for s in scores:
        if s.kind.removeprefix(NEARLY) not in ("single", "half", "nothing"):
            continue
        planted = s.truth.split(" @ ")[0]
        named = s.named.split("; ")[0].split(" @ ")[0] or NOTHING
        if s.first_right:
            named = planted  # by name, as one that cannot be told from it, or as its exact twin
        elif named == planted != NOTHING:
            named = OTHER_PLACE
        counts[planted, named] += 1
    return counts


def write_confusion(scores: list[Score], folder: Path, name: str) -> None:
    """`NAME_confusion.csv` and `.png`."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    counts = confusion(scores)
    rows = [*TABLE, NOTHING]
    columns = [*TABLE, NOTHING, OTHER_PLACE]
    rows = [r for r in rows if any(k[0] == r for k in counts)]
    if not rows:
        return
    grid = np.array([[counts[r, c] for c in columns] for r in rows]).reshape(len(rows), len(columns))
    with (folder / f"{name}_confusion.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["planted", *columns])
        writer.writerows([[r, *line] for r, line in zip(rows, grid.tolist(), strict=True)])
    fig, ax = plt.subplots(figsize=(10, 0.33 * len(rows) + 3.2), layout="constrained")
    share = grid / np.maximum(grid.sum(axis=1, keepdims=True), 1)
    ax.imshow(share, cmap="Blues", vmin=0, vmax=1, aspect="auto")
    ax.set_xticks(range(len(columns)), [c.replace("_", " ") for c in columns], rotation=90)
    ax.set_yticks(range(len(rows)), [r.replace("_", " ") for r in rows])
    for i, j in zip(*np.nonzero(grid), strict=True):
        ax.text(j, i, str(grid[i, j]), ha="center", va="center", color="white" if share[i, j] > 0.6 else "black")
    ax.set_xlabel("first named, or in its list of what cannot be told apart")
    ax.set_ylabel("planted")
    fig.savefig(folder / f"{name}_confusion.png", dpi=120, metadata={"Software": None})
    plt.close(fig)


def read_seconds(folder: Path) -> dict[str, float]:
    """How long each diagnosis took [s], as the runner noted."""
    return {p.parent.name: float(json.loads(p.read_text())["seconds"]) for p in folder.glob("*/seconds.json")}
