"""A robot whose joints slide and turn: every mean, head and scale is of one kind of joint, with that kind's unit."""

from pathlib import Path

import chromium
import pandas as pd
import pytest
import synthetic
from realitygap.compare.row import Row
from realitygap.compare.table import table
from realitygap.report import write_page
from realitygap.report.folder import read_folder
from realitygap.report.sentences import sentences

UNITS = {
    "revolute": {"position": "deg", "velocity": "deg/s", "effort": "N·m"},
    "prismatic": {"position": "mm", "velocity": "mm/s", "effort": "N"},
}
JOINTS = {
    "elbow": ("revolute", "moving", 2.0),
    "wrist": ("revolute", "moving", 4.0),
    "lift": ("prismatic", "moving", 9.0),
}
STILL = {"finger": ("prismatic", "unmoving", 0.5)}
KINDS_ALIKE = {"elbow": JOINTS["elbow"], "wrist": JOINTS["wrist"]}


def gaps(joints: dict[str, tuple[str, str, float]], revision: str = "new") -> list[Row]:
    return [
        Row(
            **vars(synthetic.cell(robot_revision=revision)),
            joint=joint,
            group=group,
            signal=signal,
            unit=unit,
            mean_abs=gap,
            median_abs=gap,
            p95_abs=gap,
            max_abs=gap,
            noise_floor=0.1,
            numerical_floor=0.1,
            outcome="ok",
            note="",
        )
        for joint, (kind, group, gap) in joints.items()
        for signal, unit in UNITS[kind].items()
    ]


def opened(browser: chromium.Browser, folder: Path, frame: pd.DataFrame) -> None:
    synthetic.write_planted(folder, frame)
    browser.complaints.clear()
    browser.open(write_page(folder))
    browser.wait("document.querySelectorAll('.heat td[data-r]').length > 0")


def means(browser: chromium.Browser, where: str = "#means") -> list[list[str]]:
    script = (
        f"[...document.querySelectorAll('{where} tbody tr')].map(r => [...r.cells].map(c => c.firstChild.textContent))"
    )
    rows: list[list[str]] = browser.run(script)
    return rows


def heads(browser: chromium.Browser, where: str) -> list[str]:
    return [head.strip() for head in browser.texts(f"{where} thead th")]


def test_a_row_of_means_has_the_units_of_its_own_joints(shared: chromium.Browser, tmp_path: Path) -> None:
    """The joints that do not move are of the other kind: their units are not those of the rows above."""
    opened(shared, tmp_path, table(gaps(KINDS_ALIKE | STILL)))
    assert heads(shared, "#means") == ["engine", "joints", "position", "velocity", "effort"]
    assert means(shared) == [
        ["MuJoCo", "moving revolute", "3.00°", "3.00 °/s", "3.00 N·m"],
        ["MuJoCo", "unmoving prismatic", "0.500 mm", "0.500 mm/s", "0.500 N"],
    ]
    assert heads(shared, "#celltable")[2:5] == ["position [°]", "velocity [°/s]", "effort [N·m]"]
    assert shared.complaints == []


def test_no_joint_is_left_out_of_a_mean_because_of_its_unit(shared: chromium.Browser, tmp_path: Path) -> None:
    opened(shared, tmp_path, table(gaps(JOINTS)))
    assert [row[1:3] for row in means(shared)] == [["moving revolute", "3.00°"], ["moving prismatic", "9.00 mm"]]
    assert heads(shared, "#celltable")[2:4] == ["position [°]", "position [mm]"]
    assert means(shared, "#celltable")[0][2:4] == ["3.00", "9.00"]
    assert shared.texts("#detail h3") == ["mean of moving revolute joints in MuJoCo"]
    assert shared.complaints == []


def test_every_unit_of_the_map_has_its_own_scale(shared: chromium.Browser, tmp_path: Path) -> None:
    opened(shared, tmp_path, table(gaps(JOINTS)))
    assert shared.texts("#heatmap .hint b") == ["position [°, mm]"]
    assert shared.texts("#heatmap .legend span:has(> .ramp)") == ["0  4.00°", "0  9.00 mm"]
    rows = shared.texts(".heat tbody tr:not(.section) th")
    assert rows == [
        "mean of moving revolute joints [°]",
        "mean of moving prismatic joints [mm]",
        "elbow [°]",
        "lift [mm]",
        "wrist [°]",
    ]
    full = "[...document.querySelectorAll('.heat td[data-r]')].map(n => n.style.getPropertyValue('--upper'))"
    assert shared.run(full) == ["50.0%", "100.0%", "0.0%", "100.0%", "100.0%"]
    shared.run("document.querySelectorAll('input[name=switch-signal]')[1].click()")
    assert shared.texts("#heatmap .hint b") == ["velocity [°/s, mm/s]"]
    assert shared.complaints == []


def test_an_improvement_is_told_per_kind_of_joint(shared: chromium.Browser, tmp_path: Path) -> None:
    worse = {joint: (kind, group, 2 * gap) for joint, (kind, group, gap) in JOINTS.items()}
    old, new = gaps(worse, revision="old"), gaps(JOINTS)
    opened(shared, tmp_path, table([*old, *new]))
    assert [row[1] for row in means(shared, "#improvement")] == ["▲ +3.00°", "▲ +9.00 mm"]
    assert shared.complaints == []


@pytest.mark.parametrize(("kind", "unit"), [("revolute", "°"), ("prismatic", "mm")])
def test_joints_of_one_kind_need_no_word_for_it(shared: chromium.Browser, tmp_path: Path, kind: str, unit: str) -> None:
    opened(shared, tmp_path, table(gaps({"a": (kind, "moving", 2.0), "b": (kind, "unmoving", 4.0)})))
    assert means(shared)[0][:3] == ["MuJoCo", "moving", "2.00"]
    assert heads(shared, "#means")[2] == f"position [{unit}]"
    assert shared.texts(".heat tr.mean th") == ["mean of moving joints", "mean of unmoving joints"]


def test_sentences_say_which_joints_a_gap_is_of(tmp_path: Path) -> None:
    synthetic.write_planted(tmp_path, table(gaps(JOINTS)))
    said = [s.text for s in sentences(read_folder(tmp_path))]
    assert any(
        s.startswith("MuJoCo is this far from the recording in position of moving prismatic joints: 9") for s in said
    )
    assert any(s.startswith("wrist has the largest gap in position of revolute joints: 4.00°") for s in said)
