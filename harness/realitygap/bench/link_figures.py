"""The robot with centres of mass and inertia boxes, as figure 4.1 of the thesis, from the front and from the side."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from scipy.spatial import ConvexHull, QhullError

from realitygap.bench.estimate import Array
from realitygap.bench.plausible import Doubt, inertia_box
from realitygap.bench.urdf_links import UrdfFile, UrdfLink

VIEWS = {"front": (1, 2, "y"), "side": (0, 2, "x")}
EDGES = [(a, b) for a in range(8) for b in range(a) if bin(a ^ b).count("1") == 1]
SIGNS = np.array([[(k >> i & 1) * 2 - 1 for i in range(3)] for k in range(8)], dtype=float)


def draw(urdf: UrdfFile, pictures: list[tuple[str, dict[str, UrdfLink], list[Doubt]]], file: Path) -> Path:
    """One row per picture (title, links, what is wrong with them), one column per view; doubtful links are named."""
    every = np.vstack([_placed(link, link.points) for link in urdf.links.values()] + [_placed_com(urdf)])
    size = np.ptp(every, axis=0) + 0.1
    widths = [size[h] + 0.25 for h, _, _ in VIEWS.values()]
    height = 6.5
    figure = Figure(figsize=(height / size[2] * sum(widths) + 1, height * len(pictures)), layout="constrained")
    grid = figure.subplots(len(pictures), len(VIEWS), squeeze=False, width_ratios=widths)
    for row, (title, links, doubts) in zip(grid, pictures, strict=True):
        for axes, (view, (across, up, label)) in zip(row, VIEWS.items(), strict=True):
            _view(axes, links, {d.link: d.impossible for d in doubts}, across, up)
            middle = (every[:, across].max() + every[:, across].min()) / 2
            half = (size[across] + 0.25) / 2
            axes.set_xlim((middle + half, middle - half) if view == "front" else (middle - half, middle + half))
            axes.set_ylim(every[:, up].min() - 0.05, every[:, up].max() + 0.05)
            axes.set_aspect("equal")
            axes.set_title(f"{title}, {view} view")
            axes.set_xlabel(f"{label} [m]")
            axes.set_ylabel("z [m]")
    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, dpi=90)
    return file


def _view(axes: Axes, links: dict[str, UrdfLink], doubtful: dict[str, bool], across: int, up: int) -> None:
    for link in links.values():
        outline = _outline(_placed(link, link.points)[:, [across, up]])
        if outline is not None:
            axes.add_patch(Polygon(outline, facecolor="0.88", edgecolor="0.6", lw=0.6, zorder=1))
    for name, link in links.items():
        if not link.mass > 0:
            continue
        color = "tab:red" if name in doubtful else "tab:purple"
        box, turn = inertia_box(link.mass, link.inertia)
        corners = _placed(link, link.com + SIGNS * box / 2 @ turn.T)[:, [across, up]]
        for a, b in EDGES:
            axes.plot(*corners[[a, b]].T, color=color, lw=0.9, zorder=2)
        outline = _outline(corners)
        if outline is not None:
            axes.add_patch(Polygon(outline, facecolor=color, alpha=0.12, lw=0, zorder=2))
        center = _placed(link, link.com[None])[0, [across, up]]
        axes.plot(*center, "o", ms=5, mfc="white", mec="black", mew=1.4, zorder=3)
        # of a pair seen from the side both lie on one another: one label is enough
        if name in doubtful and not (across == 0 and name.startswith(("l_", "left_"))):
            left = across == 1 and center[0] > 0  # away from the middle: the front view has y to the left
            axes.annotate(
                name,
                (center[0], center[1]),
                xytext=(-9 if left else 9, 6),
                textcoords="offset points",
                ha="right" if left else "left",
                fontsize=8,
                color="tab:red",
                zorder=4,
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.5},
            )


def _placed(link: UrdfLink, points: Array) -> Array:
    return np.asarray(points @ link.pose[:3, :3].T + link.pose[:3, 3])


def _placed_com(urdf: UrdfFile) -> Array:
    return np.vstack([_placed(link, link.com[None]) for link in urdf.links.values()])


def _outline(points: Array) -> Array | None:
    try:
        return points[ConvexHull(points).vertices]
    except (QhullError, ValueError):
        return None
