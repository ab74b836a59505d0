"""The gap: planted offsets come out as they were put in, per joint and signal, beside their floors."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose
from realitygap.compare.budget import not_judged, over_budget, parse_budget
from realitygap.compare.gap import Difference, box, differences, mean_trace, moving_joints
from realitygap.compare.row import EXCLUDED, Cell, failed, row, slug
from realitygap.compare.table import means, read_gaps, table, to_csv
from realitygap.files.errors import InputError
from realitygap.files.whole import write_whole
from realitygap.trace.trace import Trace
from realitygap_engines.model.robot import Array, Joint, Link, Model
from scipy.spatial.transform import Rotation

LINKS = tuple(Link(f"l{i}", 1.0, np.zeros(3), np.eye(3)) for i in range(4))
JOINTS = tuple(Joint(n, n == "slide", i, np.eye(4), np.eye(3)[2]) for i, n in enumerate(("knee", "hip", "slide")))
MODEL = Model("m", LINKS, JOINTS, True)
TIME = np.linspace(0.0, 2.0, 201)
CELL = Cell("s", "r", "mujoco", "1", "flat", "", 1000.0, None, "{}", "kick", "train")


def quaternions(rotation: Rotation) -> Array:
    return np.asarray(rotation.as_quat(scalar_first=True))


def motion(order: tuple[str, ...] = ("knee", "hip", "slide")) -> Trace:
    """The knee swings by 1 rad, the slide by 1 mm, the hip is told to hold."""
    columns = {"knee": np.sin(3 * TIME), "hip": 0.2 + 0 * TIME, "slide": 1e-3 * np.sin(TIME)}
    position = np.column_stack([columns[n] for n in order])
    turns = Rotation.from_rotvec(np.outer(TIME, [0.1, 0.2, 0.3]))
    return Trace(
        time=TIME,
        joints=order,
        position=position,
        velocity=np.gradient(position, TIME, axis=0),
        effort=5 * position,
        command=position,
        base_position=np.outer(TIME, [0.1, 0.0, 0.0]),
        base_quaternion=quaternions(turns),
        base_angular=np.tile([0.1, 0.2, 0.3], (len(TIME), 1)),
    )


def by_key(found: Iterable[Difference]) -> dict[tuple[str, str], Difference]:
    return {(d.joint, d.signal): d for d in found}


def test_planted_offsets_come_out_in_peoples_units() -> None:
    """Also where the recording has its joints in another order and its own clock."""
    measured = motion(("slide", "knee", "hip")).rows(np.arange(3, 190, 7))
    ours = motion()
    assert ours.position is not None
    assert ours.velocity is not None
    assert ours.effort is not None
    simulated = replace(
        ours,
        position=ours.position + np.array([0.1, -0.2, 2e-3]),
        velocity=ours.velocity + np.array([0.5, 0.0, 1e-3]),
        effort=ours.effort - np.array([1.0, 2.0, 3.0]),
    )
    found = by_key(differences(MODEL, simulated, measured))
    planted = {
        ("knee", "position"): (np.rad2deg(0.1), "deg", "moving"),
        ("hip", "position"): (np.rad2deg(0.2), "deg", "unmoving"),
        ("slide", "position"): (2.0, "mm", "moving"),
        ("knee", "velocity"): (np.rad2deg(0.5), "deg/s", "moving"),
        ("hip", "velocity"): (0.0, "deg/s", "unmoving"),
        ("slide", "velocity"): (1.0, "mm/s", "moving"),
        ("knee", "effort"): (1.0, "N·m", "moving"),
        ("hip", "effort"): (2.0, "N·m", "unmoving"),
        ("slide", "effort"): (3.0, "N", "moving"),
        ("base", "base_position"): (0.0, "m", "base"),
        ("base", "base_orientation"): (0.0, "deg", "base"),
        ("base", "base_angular_velocity"): (0.0, "deg/s", "base"),
    }
    assert set(found) == set(planted)
    for key, (value, unit, group) in planted.items():
        d = found[key]
        assert (d.unit, d.group) == (unit, group), key
        assert_allclose(d.values, value, atol=1e-9, err_msg=str(key))
        assert len(d.values) == len(measured.time)


def test_what_was_not_measured_does_not_count() -> None:
    measured = motion()
    position = np.array(measured.position)
    position[:50, 0] = np.nan
    found = by_key(differences(MODEL, motion(), replace(measured, position=position, effort=None)))
    assert len(found["knee", "position"].values) == len(TIME) - 50
    assert ("knee", "effort") not in found


@pytest.mark.parametrize("size", [1e-9, 1e-4, 1.0, np.pi])
def test_base_position_and_orientation(size: float) -> None:
    """Orientations differ by the angle of the turn between them, to small angles and whatever the sign."""
    measured = motion()
    turned = Rotation.from_rotvec(size * np.array([0.6, 0.0, 0.8])) * Rotation.from_quat(
        np.asarray(measured.base_quaternion), scalar_first=True
    )
    sign = np.where(np.arange(len(TIME)) % 2, 1.0, -1.0)[:, None]
    far = np.asarray(measured.base_position) + size * np.array([0.0, 0.6, 0.8])
    simulated = replace(measured, base_quaternion=quaternions(turned), base_position=far)
    flipped = replace(measured, base_quaternion=sign * np.asarray(measured.base_quaternion))
    ours = replace(simulated, base_quaternion=np.asarray(simulated.base_quaternion))
    found = by_key(differences(MODEL, ours, measured))
    assert_allclose(found["base", "base_orientation"].values, np.rad2deg(size), rtol=1e-6)
    assert_allclose(found["base", "base_position"].values, size, rtol=1e-6)
    assert_allclose(by_key(differences(MODEL, measured, flipped))["base", "base_orientation"].values, 0, atol=1e-9)


def test_an_imu_is_compared_by_how_its_vertical_moves() -> None:
    """However it is mounted, and whatever heading it believes in."""
    measured = motion()
    body = Rotation.from_quat(np.asarray(measured.base_quaternion), scalar_first=True)
    mounting = Rotation.from_rotvec([0.3, -0.4, 1.2])
    drift = Rotation.from_rotvec(np.outer(0.5 + 0.1 * TIME, [0, 0, 1]))
    imu = replace(
        measured,
        base_position=None,
        base_quaternion=None,
        base_angular=None,
        imu_quaternion=quaternions(drift * body * mounting),
        imu_angular=mounting.inv().apply(np.asarray(measured.base_angular)),
    )
    found = by_key(differences(MODEL, measured, imu))
    assert_allclose(found["base", "base_orientation"].values, 0, atol=1e-6)
    assert_allclose(found["base", "base_angular_velocity"].values, 0, atol=1e-9)
    still = replace(imu, imu_quaternion=np.tile(np.asarray(imu.imu_quaternion)[:1], (len(TIME), 1)))
    leaning = Rotation.from_rotvec(np.outer(0.1 * TIME, [1, 0, 0])) * body[0]
    fallen = by_key(differences(MODEL, replace(measured, base_quaternion=quaternions(leaning)), still))
    assert_allclose(fallen["base", "base_orientation"].values, np.rad2deg(0.1 * TIME), atol=1e-6)


def test_an_imu_is_not_asked_where_the_pose_was_recorded() -> None:
    """Of each signal of the base there is one difference, and the pose tells more."""
    measured = motion()
    turned = Rotation.from_rotvec([0.3, 0, 0]) * Rotation.from_quat(
        np.asarray(measured.base_quaternion), scalar_first=True
    )
    both = replace(measured, imu_quaternion=quaternions(turned)[::-1], imu_angular=np.ones((len(TIME), 3)))
    found = [d for d in differences(MODEL, measured, both) if d.group == "base"]
    assert sorted(d.signal for d in found) == ["base_angular_velocity", "base_orientation", "base_position"]
    assert max(d.values.max() for d in found) < 1e-9


@pytest.mark.parametrize(("degrees", "moves"), [(0.49, False), (0.51, True)])
def test_a_joint_moves_where_its_command_ranges_over_half_a_degree(degrees: float, moves: bool) -> None:
    command = np.zeros((len(TIME), 3))
    command[100:, 0] = np.deg2rad(degrees)
    command[::2, 1] = np.nan
    measured = replace(motion(), command=command)
    assert moving_joints(MODEL, measured) == [moves, False, False]
    assert moving_joints(MODEL, replace(motion(), command=np.full_like(command, np.nan))) == [True, False, True]


def test_mean_of_repetitions() -> None:
    one = motion()
    other = replace(
        one, position=np.asarray(one.position) + 0.2, effort=None, base_quaternion=-np.asarray(one.base_quaternion)
    )
    mean = mean_trace([one, other])
    assert_allclose(np.asarray(mean.position), np.asarray(one.position) + 0.1)
    assert mean.effort is None
    assert_allclose(np.asarray(mean.base_quaternion), np.asarray(one.base_quaternion), atol=1e-12)


def difference(joint: str, values: list[float], signal: str = "position", group: str = "moving") -> Difference:
    return Difference(joint, signal, "deg", group, 1.0, np.array(values))


def test_a_row_holds_the_statistics_of_its_difference() -> None:
    made = row(CELL, difference("knee", [*range(1, 101)]), 0.3, 0.1)
    assert [made.mean_abs, made.median_abs, made.p95_abs, made.max_abs] == pytest.approx([50.5, 50.5, 95.05, 100])
    assert (made.noise_floor, made.numerical_floor, made.outcome) == (0.3, 0.1, "ok")


def test_a_box_has_the_quartiles_and_whiskers_of_tukey() -> None:
    """Whiskers reach to the furthest values within one and a half boxes; beyond, the largest is told alone."""
    assert box(np.array([*range(9), 12.0, 30.0])) == [0.0, 2.5, 5.0, 7.5, 12.0, 30.0]
    assert box(np.array([-30.0, -12.0, *range(-8, 1)])) == [-12.0, -7.5, -5.0, -2.5, 0.0, 0.0]


def full_table() -> pd.DataFrame:
    other = replace(CELL, engine="dart", solver_iterations=50, recording='ground ×2, "quoted"')
    rows = [
        row(CELL, difference("knee", [1.0, 3.0]), 0.25, float("nan")),
        row(CELL, difference("ankle", [1 / 3]), float("nan"), 0.5, EXCLUDED),
        row(CELL, difference("hip", [5.0], group="unmoving"), 0.1, 0.1),
        row(other, difference("knee", [7.0]), 0.25, 0.1),
        failed(
            replace(CELL, engine="drake"), difference("knee", []), 0.25, "diverged", "diverged at 1.2 s at knee: NaN"
        ),
    ]
    return table(rows)


def test_a_table_is_sorted_whatever_the_order_of_its_rows() -> None:
    frame = full_table()
    assert frame["engine"].tolist() == ["dart", "drake", "mujoco", "mujoco", "mujoco"]
    assert frame["joint"].tolist()[2:] == ["ankle", "hip", "knee"]


def test_a_table_survives_its_file(tmp_path: Path) -> None:
    path = tmp_path / "gaps.csv"
    write_whole(path, to_csv(full_table()))
    again = read_gaps(path)
    assert to_csv(again) == path.read_text()
    assert again["mean_abs"].tolist() == [7.0, np.inf, 0.333333, 5.0, 2.0]
    assert again["solver_iterations"].isna().tolist() == [False, True, True, True, True]
    assert again["note"][1] == "diverged at 1.2 s at knee: NaN"
    assert again["use"].tolist() == ["train"] * 5


def test_an_empty_table_survives_its_file(tmp_path: Path) -> None:
    path = tmp_path / "gaps.csv"
    write_whole(path, to_csv(table([])))
    assert read_gaps(path).empty


def test_excluded_joints_are_left_out_of_the_means() -> None:
    found = means(full_table())
    ours = found[found["engine"] == "mujoco"].set_index("group")
    assert ours.loc["moving", "mean_abs"] == 2.0
    assert ours.loc["moving", "joints"] == 1
    assert ours.loc["unmoving", "mean_abs"] == 5.0


def test_every_cell_has_a_file_name_of_its_own() -> None:
    cells = [CELL, replace(CELL, engine="dart"), replace(CELL, step_rate=500.0), replace(CELL, solver_iterations=5)]
    names = [slug(c) for c in cells]
    assert len(set(names)) == len(cells)
    assert names == [slug(replace(c)) for c in cells]
    assert not set(slug(replace(CELL, recording="a/b ×2: é"))) & set("/ ×:")


def test_a_file_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    path = tmp_path / "a" / "gaps.csv"
    write_whole(path, "old")
    with pytest.raises(UnicodeEncodeError):
        write_whole(path, "new \ud800")
    assert path.read_text() == "old"
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize(
    ("budget", "sentences"),
    [
        ({"position": 10.0}, ["drake, kick: position: diverged at 1.2 s at knee: NaN; budget 10 deg"]),
        (
            {"position": 3.0},
            [
                'dart, ground ×2, "quoted": position 7 deg, budget 3 deg; worst joint knee with 7 deg (floor 0.25)',
                "drake, kick: position: diverged at 1.2 s at knee: NaN; budget 3 deg",
            ],
        ),
        ({"position": 7.0}, ["drake, kick: position: diverged at 1.2 s at knee: NaN; budget 7 deg"]),
        ({"effort": 1.0}, []),
    ],
)
def test_budgets(budget: dict[str, float], sentences: list[str]) -> None:
    assert over_budget(full_table(), budget) == [f"over budget: {s}" for s in sentences]


def test_a_budget_is_for_the_mean_of_joints_and_the_worst_is_named() -> None:
    rows = table([row(CELL, difference("knee", [1.0]), 0.1, 0.1), row(CELL, difference("hip", [4.0]), 0.1, 0.1)])
    assert over_budget(rows, {"position": 2.6}) == []
    (sentence,) = over_budget(rows, {"position": 2.4})
    assert "position 2.5 deg, budget 2.4 deg; worst joint hip with 4 deg" in sentence


def test_a_budget_for_what_was_not_measured_is_not_kept() -> None:
    assert not_judged(full_table(), {"position": 1.0}) == []
    (sentence,) = not_judged(full_table(), {"effort": 1.0})
    assert sentence == "over budget: no effort of a moving joint was measured, or all are left out; budget 1"


def test_what_an_engine_cannot_express_is_not_judged() -> None:
    rows = [failed(CELL, difference("knee", []), 0.1, "unsupported", "no contact stiffness")]
    assert over_budget(table(rows), {"position": 1.0}) == []
    (sentence,) = not_judged(table(rows), {"position": 1.0})
    assert sentence == (
        "over budget: position was not judged, as no engine of the run can simulate the scenario; budget 1"
    )
    assert not_judged(pd.concat([full_table(), table(rows)]), {"position": 1.0}) == [], "another engine can"


def test_budgets_as_options() -> None:
    assert parse_budget(["1.5", "effort=0.25", "velocity=1e1"]) == {"position": 1.5, "effort": 0.25, "velocity": 10.0}
    with pytest.raises(InputError, match="found 'effort=nan'; expected SIGNAL=VALUE"):
        parse_budget(["effort=nan"])
    with pytest.raises(InputError, match=r"found 'position=0'; .* and a number above zero"):
        parse_budget(["position=0"])
