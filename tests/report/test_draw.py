"""Figures with long names: what stands above them is in them, in as many lines as it takes."""

import re
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path
from realitygap.missing.effort import MissingEffort
from realitygap.report.draw import BoxSet, Curve, draw_boxes, draw_curves
from realitygap.report.draw_missing import draw_missing

LONG = "left_front_robot_arm_shoulder_pan_joint_motor_with_MAGNETIC_ENCODER"
RUN = "recording of sines motion on 2024-05-03 at 12:33 (second robot, third day, WITH LOAD)"


def texts(path: Path) -> list[tuple[str, float, float]]:
    """Every text of a figure, how long it is, and how long the figure is along it [pt]."""
    root = ElementTree.fromstring(path.read_text())
    width, height = (float(root.get(side, "").removesuffix("pt")) for side in ("width", "height"))
    out = []
    for node in root.iter("{http://www.w3.org/2000/svg}text"):
        style = node.get("style", "")
        size = re.search(r"font(?:-size)?: (?:(\w+) )?([\d.]+)px", style)
        assert size is not None, style
        font = FontProperties(size=float(size[2]), weight="bold" if size[1] in ("700", "bold") else "normal")
        long = text_to_path.get_text_width_height_descent(node.text or "", font, False)[0]
        out.append((node.text or "", long, height if "rotate(-90" in node.get("transform", "") else width))
    return out


def missing(path: Path) -> Path:
    time = np.linspace(0.0, 5.0, 500)
    wave = np.sin(3.0 * time)[:, None]
    variables = {"angle": wave, "speed": 3.0 * np.cos(3.0 * time)[:, None], "load": wave}
    run = MissingEffort(RUN, "mujoco", None, (LONG,), (False,), time, wave, 0.1 + 0.0 * wave, variables)
    return draw_missing(path, [run], {"joint": LONG, "unit": "N·m", "terms": []})


def curves(path: Path) -> Path:
    time = np.linspace(0.0, 5.0, 50)
    joints = {f"{LONG}_{k}": np.sin(time) for k in range(3)}
    drawn = [Curve("MuJoCo", "#000000", 0, time, joints)]
    return draw_curves(path, drawn, joints, dict.fromkeys(joints, "deg"), "position", RUN)


def boxes(path: Path) -> Path:
    stats = {"position": {LONG: [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]}}
    out = draw_boxes(path, [BoxSet("MuJoCo", "#000000", stats)], "position", "deg", RUN)
    assert out is not None
    return out


@pytest.mark.parametrize(("draw", "beside"), [(missing, 1), (curves, 3), (boxes, 1)])
def test_what_stands_at_a_figure_is_within_it(draw: Callable[[Path], Path], beside: int, tmp_path: Path) -> None:
    """`beside` are the figure's panels in a row, whose titles share its width."""
    found = texts(draw(tmp_path / "figure.svg"))
    assert all(long <= room for _, long, room in found)
    names = [LONG, *(f"{LONG}_{k}" for k in range(beside))]
    assert all(long <= room / beside for text, long, room in found if any(text in name for name in names))
    together = "".join(text for text, _, _ in found).replace(" ", "")
    assert RUN.replace(" ", "") in together, "all of it is there"
    assert LONG in together
