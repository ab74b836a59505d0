"""What the suite shows: one table of scores, one of goals, and which effect was named for which."""

import csv
import json
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import asdict, fields
from pathlib import Path

import numpy as np
from judge import Score
from planted import TABLE

NOTHING, OTHER_PLACE = "nothing", "other target"
LIMITS = {"one joint": 60.0, "two links": 120.0, "humanoid": 900.0}
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
    return "two links" if robot in ("planar", "skew") else "one joint"


def goals(scores: list[Score], seconds: dict[str, float]) -> list[tuple[str, str, str]]:
    """Rows of (what, goal, reached)."""
    by = {k: [s for s in scores if s.kind == k] for k in ("single", "half", "pair", "triple", "nothing", "outside")}
    effects = [s for s in scores if s.first_right is not None and s.kind != "half"]
    rows = [
        ("single effects: first name right", "≥ 98 %", _share(by["single"], lambda s: s.first_right)),
        ("single effects: exactly the right set", "≥ 95 %", _share(by["single"], lambda s: s.exact)),
        ("half the size, 100 Hz, no effort: exact", "≥ 80 %", _share(by["half"], lambda s: s.exact)),
        ("half the size, 100 Hz, no effort: a wrong name", "≤ 5 %", _share(by["half"], lambda s: s.wrong > 0)),
        ("pairs: both named, nothing added", "≥ 90 %", _share(by["pair"], lambda s: s.exact)),
        ("three effects: all named, nothing added", "≥ 80 %", _share(by["triple"], lambda s: s.exact)),
        ("nothing missing: nothing named", "100 %", _share(by["nothing"], lambda s: s.silent)),
        ("outside the list: no wrong name", "≥ 90 %", _share(by["outside"], lambda s: s.silent)),
        (
            "parameter error, median",
            "≤ 5 %",
            _median([s.parameter_error for s in effects if s.parameter_error is not None]),
        ),
        (
            "held-out gap removed, median",
            "≥ 90 %",
            _median([s.gap_removed for s in effects if s.gap_removed is not None]),
        ),
    ]
    for name, limit in LIMITS.items():
        taken = [seconds[s.case] for s in scores if size_of(s.robot) == name and s.case in seconds]
        reached = f"median {np.median(taken):.0f} s, longest {max(taken):.0f} s" if taken else "-"
        rows.append((f"time, {name}", f"≤ {limit:.0f} s", reached))
    return rows


def confusion(scores: list[Score]) -> Counter[tuple[str, str]]:
    """(planted, first named) over single effects; a right effect elsewhere is `other target`."""
    counts: Counter[tuple[str, str]] = Counter()
    for s in scores:
        if s.kind not in ("single", "half", "nothing"):
            continue
        planted = s.truth.split(" @ ")[0]
        named = s.named.split("; ")[0].split(" @ ")[0] or NOTHING
        if s.first_right:
            named = planted  # by name, as one that cannot be told from it, or as its exact twin
        elif named == planted != NOTHING:
            named = OTHER_PLACE
        counts[planted, named] += 1
    return counts


def write_confusion(scores: list[Score], folder: Path) -> None:
    """`blind_confusion.csv` and `.png`."""
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
    with (folder / "blind_confusion.csv").open("w", newline="") as file:
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
    fig.savefig(folder / "blind_confusion.png", dpi=120, metadata={"Software": None})
    plt.close(fig)


def read_seconds(folder: Path) -> dict[str, float]:
    """How long each diagnosis took [s], as the runner noted."""
    return {p.parent.name: float(json.loads(p.read_text())["seconds"]) for p in folder.glob("*/seconds.json")}
