"""The link bench finds what is impossible, by known bodies, and what the thesis found on its robot."""

import os
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import trimesh
from realitygap.bench import links
from realitygap.bench.plausible import body, doubts, inertia_box
from realitygap.bench.urdf_links import UrdfLink, read_urdf_links
from realitygap.files.errors import InputError

SCENARIO = Path(__file__).parents[2] / "scenarios" / "bench_links_wolfgang"
SIDES = np.array([0.3, 0.1, 0.06])
CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * SIDES / 2


def box_inertia(mass: float, sides: np.ndarray) -> np.ndarray:
    return (
        mass
        / 12
        * np.diag([sides[1] ** 2 + sides[2] ** 2, sides[0] ** 2 + sides[2] ** 2, sides[0] ** 2 + sides[1] ** 2])
    )


def link(inertia: np.ndarray, mass: float = 0.5, com: tuple[float, float, float] = (0, 0, 0)) -> UrdfLink:
    return UrdfLink("part", mass, np.array(com, dtype=float), inertia, CORNERS, np.eye(4))


def rotated(inertia: np.ndarray, degrees: float) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return np.asarray(turn @ inertia @ turn.T)


def test_a_uniform_box_is_plausible_in_every_attitude() -> None:
    assert doubts(link(box_inertia(0.5, SIDES))) == []
    lengths, axes = inertia_box(0.5, box_inertia(0.5, SIDES))
    assert lengths == pytest.approx(np.sort(SIDES))
    assert abs(axes[0, 2]) == pytest.approx(1.0)


def test_solid_and_shell_of_a_box_are_the_closed_forms() -> None:
    form = body(CORNERS)
    assert form is not None
    assert form.volume == pytest.approx(np.prod(SIDES))
    assert form.solid == pytest.approx(box_inertia(1.0, SIDES))
    a, b, c = SIDES
    area = 2 * (a * b + b * c + c * a)
    # ∫x² over a box's surface: the two faces at ±a/2, and the four others as thin plates
    along = [
        (2 * y * z * x**2 / 4 + 2 * (x * y + x * z) * x**2 / 12) / area for x, y, z in ((a, b, c), (b, a, c), (c, a, b))
    ]
    assert form.shell == pytest.approx(np.diag(np.sum(along) - np.array(along)), rel=1e-9)


def test_the_shell_of_a_sphere_has_two_thirds() -> None:
    form = body(np.asarray(trimesh.creation.icosphere(subdivisions=4, radius=0.1).vertices))
    assert form is not None
    assert form.shell == pytest.approx(np.eye(3) * 2 / 3 * 0.1**2, rel=5e-3, abs=1e-9)


def test_two_lumps_at_the_ends_are_the_limit() -> None:
    """The largest second moment within the box is that of half the mass at either end: σ² = (side/2)²."""
    second = 0.5 * (SIDES / 2) ** 2
    most = np.diag(second.sum() - second)
    assert not any(d.impossible for d in doubts(link(most * 0.999)))
    assert any(d.impossible and "even with all of it at the ends" in d.what for d in doubts(link(most * 1.01)))


@pytest.mark.parametrize(
    ("inertial", "impossible", "words"),
    [
        (link(box_inertia(0.5, SIDES * 3)), True, "times what that mass can have"),
        (link(box_inertia(0.5, SIDES * 1.5)), False, "too large"),
        (link(box_inertia(0.5, SIDES * 0.4)), False, "too small for the mass"),
        (link(rotated(box_inertia(0.5, SIDES * [0.8, 1, 1]), 45)), False, "turned: its long axis is 45°"),
        (link(box_inertia(0.5, SIDES), com=(0.2, 0, 0)), True, "50 mm outside the collision geometry"),
        (link(np.diag([1e-4, 1e-4, 3e-4])), True, "no body has the principal moments"),
        (link(np.zeros((3, 3))), True, "no inertia at all"),
        (link(box_inertia(0.5, SIDES), mass=-1.0), True, "the mass is -1 kg"),
        (link(box_inertia(20.0, SIDES), mass=20.0), False, "denser than solid aluminium"),
    ],
)
def test_every_kind_of_doubt(inertial: UrdfLink, impossible: bool, words: str) -> None:
    assert any(words in d.what and d.impossible == impossible for d in doubts(inertial))


URDF = """<?xml version="1.0"?>
<!-- kept -->
<robot name="arm">
  <link name="base"/>
  <link name="r_arm">
    <!-- kept, too -->
    <inertial><origin xyz="0.2 0.01 0" rpy="0 0 0"/><mass value="0.5"/>
      <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial>
    <collision><geometry><box size="0.3 0.1 0.06"/></geometry></collision>
  </link>
  <link name="l_arm">
    <inertial><origin xyz="0.0 0.01 0" rpy="0 0 0"/><mass value="0.6"/>
      <inertia ixx="6.8e-4" ixy="0" ixz="0" iyy="46.8e-4" iyz="0" izz="50e-4"/></inertial>
    <collision><geometry><box size="0.3 0.1 0.06"/></geometry></collision>
  </link>
  <joint name="right" type="revolute"><parent link="base"/><child link="r_arm"/><origin xyz="0 -1 2"/>
    <limit effort="1" velocity="1" lower="0" upper="1"/></joint>
  <joint name="left" type="revolute"><parent link="base"/><child link="l_arm"/><origin xyz="0 1 2"/>
    <limit effort="1" velocity="1" lower="0" upper="1"/></joint>
</robot>
"""
BENCH = """urdf: arm.urdf
masses: {table: masses.csv, unit: g}
centers: {table: centers.csv, unit: mm}
parts: [{name: arm, links: [r_arm, l_arm], rotation: {rpy: [0, 0, 90], unit: deg}}]
"""


def written(
    folder: Path, *, urdf: str = URDF, bench: str = BENCH, mass: str = "arm,250", com: str = "arm,3,-20,1"
) -> Path:
    (folder / "arm.urdf").write_text(urdf, encoding="utf-8")
    (folder / "bench.yaml").write_text(bench, encoding="utf-8")
    (folder / "masses.csv").write_text(f"link,mass\n{mass}\n", encoding="utf-8")
    (folder / "centers.csv").write_text(f"link,x,y,z\n{com}\n", encoding="utf-8")
    return folder / "bench.yaml"


def test_the_corrected_urdf_has_what_was_measured_and_keeps_the_rest(tmp_path: Path) -> None:
    text = "\n".join(links.run(written(tmp_path), tmp_path / "out").lines)
    file = tmp_path / "out" / "arm_corrected.urdf"
    found = read_urdf_links(file, {}).links
    assert found["r_arm"].mass == found["l_arm"].mass == 0.25
    assert found["r_arm"].com == pytest.approx([0.020, 0.003, 0.001])  # turned by 90°
    assert found["l_arm"].com == pytest.approx([0.020, -0.003, 0.001])  # and mirrored
    assert found["r_arm"].inertia == pytest.approx(box_inertia(0.25, SIDES), rel=1e-5)  # it was a ball's
    assert np.diag(found["l_arm"].inertia) == pytest.approx(np.array([6.8e-4, 46.8e-4, 50e-4]) * 0.25 / 0.6, rel=1e-5)
    new, old = file.read_text(encoding="utf-8").splitlines(), URDF.splitlines()
    assert [line for line in old if '<origin xyz="0.' not in line and "<inertia " not in line] == [
        line for line in new if 'rpy="0 0 0"' not in line and "<inertia " not in line
    ]
    assert "50 mm outside" in text
    assert "r_arm and l_arm are no mirror images: masses differ by 16.7%" in text
    remains = text.split("What remains implausible after the correction")[1]
    assert "IMPOSSIBLE" not in remains
    assert (tmp_path / "out" / "links.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"mass": "arm,"}, "row 2 has no mass"),
        ({"mass": "arm,-3"}, "arm weighs -0.003 kg"),
        ({"mass": "leg,3"}, "part leg: arm.urdf has no link leg"),
        ({"mass": "arm,3\narm,4"}, "two links under one name: arm"),
        ({"bench": BENCH.replace(", unit: g", "")}, "masses.unit: is missing"),
        ({"bench": BENCH.replace("arm.urdf", "leg.urdf")}, "leg.urdf: cannot be read"),
        ({"bench": BENCH.replace("urdf:", "urfd:")}, "urfd: unknown key; missing: urdf; known here"),
        ({"urdf": URDF.replace("</robot>", "")}, "is not well-formed XML"),
        ({"urdf": URDF.replace("robot", "sdf")}, "is not a URDF"),
        ({"urdf": URDF.replace('value="0.5"', 'value="x"')}, "link r_arm: mass is 'x', expected a finite number"),
        ({"urdf": '<!DOCTYPE x [<!ENTITY a "b">]>' + URDF[URDF.index("<robot") :]}, "XML entities are not accepted"),
    ],
)
def test_bad_input_is_one_sentence(change: dict[str, str], expected: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=expected) as raised:
        links.run(written(tmp_path, **change), tmp_path / "out")
    assert "\n" not in str(raised.value)


def test_table_4_1_is_the_average_of_table_a_1() -> None:
    centers = pd.read_csv(SCENARIO / "centers.csv")
    averages = [round(float((centers[a] - centers[f"cad_{a}"]).abs().mean()), 3) for a in "xyz"]
    assert averages == [0.005, 0.002, 0.007]


needs_data = pytest.mark.skipif("REALITYGAP_DATA" not in os.environ, reason="REALITYGAP_DATA (the URDFs) is not set")


@needs_data
def test_the_old_wolfgang_shows_what_the_thesis_found(tmp_path: Path) -> None:
    text = "\n".join(links.run(SCENARIO / "old.yaml", tmp_path).lines)
    # by eye (figure 4.1): head too large, lower leg and lower arm turned
    assert "IMPOSSIBLE: head: the inertia is 1.6 times what that mass can have" in text
    for side in "rl":
        assert f"IMPOSSIBLE: {side}_lower_leg: the centre of mass lies 56 mm outside" in text
        assert f"IMPOSSIBLE: {side}_lower_arm: the centre of mass lies 38 mm outside" in text
        assert f"implausible: {side}_lower_leg: the inertia is turned" in text
        assert f"implausible: {side}_lower_arm: the inertia is turned: its long axis is 87°" in text
    # by scales (table A.2): shoulder and foot wrong by more than 100 %, three parts within 3 %
    wrong = [line.split()[0] for line in text.splitlines() if "WRONG BY MORE THAN 100 %" in line]
    assert wrong == ["r_foot", "l_foot", "r_shoulder", "l_shoulder"]
    accurate = {line.split()[0].removeprefix("r_") for line in text.splitlines() if line.endswith("accurate")}
    assert accurate == {"hip_2", "l_hip_2", "ankle", "l_ankle", "neck"}
    rows = [line.split()[:4] for line in text.splitlines()]
    assert ["torso", "1.8051", "2.8890", "+60.0%"] in rows
    assert ["head", "0.4075", "0.1100", "-73.0%"] in rows
    assert "whole robot: 6.500 kg stated, 7.142 kg with the measured links" in text
    assert "x 0.005 m, y 0.002 m, z 0.007 m" in text
    # what the thesis did not see: the left hip's centre of mass is the ankle's
    assert "IMPOSSIBLE: l_hip_2: the centre of mass lies 16 mm outside" in text


@needs_data
def test_what_remains_after_the_revision(tmp_path: Path) -> None:
    text = "\n".join(links.run(SCENARIO / "link_revised.yaml", tmp_path).lines)
    before = text.split("Implausible links")[1].split("Corrected URDF")[0]
    found = {line.split()[1].rstrip(":") for line in before.splitlines() if line.startswith(("IMPOSS", "implaus"))}
    assert found == {f"{s}_{part}" for s in "rl" for part in ("sole", "toe", "lower_leg", "shoulder")}
    assert "r_ankle and l_ankle are no mirror images" in before


@needs_data
def test_the_corrected_wolfgang_is_still_the_same_robot(tmp_path: Path) -> None:
    links.run(SCENARIO / "old.yaml", tmp_path)
    data = Path(os.environ["REALITYGAP_DATA"])
    old = ET.parse(data / "wolfgang_2019" / "urdf" / "wolfgang_old.urdf").getroot()
    new = ET.parse(tmp_path / "wolfgang_old_corrected.urdf").getroot()
    for root in (old, new):
        for element in root.findall("link"):
            for inertial in element.findall("inertial"):
                element.remove(inertial)
    assert ET.canonicalize(ET.tostring(old)) == ET.canonicalize(ET.tostring(new))
