"""Drive gains that are left to be fitted: a planted gain is found, and what fixes none is refused."""

from pathlib import Path

import numpy as np
import pytest
from realitygap.files.errors import InputError
from realitygap.scenario.file import load_scenario
from realitygap.simulate.experiment import experiments

GAIN = 11.3
URDF = """<robot name="arm"><link name="base"/>
<link name="arm"><inertial><origin xyz="0.02 0 -0.15"/><mass value="{mass}"/>
<inertia ixx="2e-3" iyy="2e-3" izz="2e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="{axis}"/></joint></robot>"""
SCENARIO = """
name: gains
robot: {urdf: arm.urdf, base: fixed}
motion: {followed: true}
recordings:
  effort: {topic: current, factor: fit}
  runs: [{path: free.csv}, LOADED]
"""
LOAD = "{path: loaded.csv, with: {effects: [{effect: payload, target: arm, mass: 0.8, x: 0.0, y: 0.0, z: -0.3}]}}"


def record(folder: Path, name: str, moment: tuple[float, float], inertia: float, seed: int, axis: str) -> None:
    """A motion with the current that its effort takes: weight of this first moment (x, z), inertia, friction."""
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.008, 0.012, 2500))
    w = np.array([1.1, 2.3, 3.7])
    phase = np.outer(time, w) + seed
    q, v = np.sin(phase) @ [0.6, 0.4, 0.2], np.cos(phase) @ (w * [0.6, 0.4, 0.2])
    a = -np.sin(phase) @ (w**2 * [0.6, 0.4, 0.2])
    weight = 9.81 * (-moment[0] * np.cos(q) - moment[1] * np.sin(q)) if axis == "0 1 0" else 0.0
    effort = weight + inertia * a + 0.2 * np.sign(v) + 0.1 * v
    current = effort / GAIN + 0.005 * rng.normal(size=len(time))
    rows = "\n".join(
        f"{t},{x},{i}" for t, x, i in zip(time, q + 2e-5 * rng.normal(size=len(time)), current, strict=True)
    )
    (folder / f"{name}.csv").write_text("time,position,current\n" + rows)


def scenario(folder: Path, *, loaded: bool, believed: float = 0.5, axis: str = "0 1 0") -> Path:
    """The real arm has 0.5 kg at (0.02, −0.15) m; the model believes in another mass."""
    record(folder, "free", (0.5 * 0.02, -0.5 * 0.15), 0.05, 1, axis)
    record(folder, "loaded", (0.5 * 0.02, -0.5 * 0.15 - 0.8 * 0.3), 0.05 + 0.8 * 0.3**2, 2, axis)
    (folder / "arm.urdf").write_text(URDF.format(mass=believed, axis=axis))
    (folder / "scenario.yaml").write_text(SCENARIO.replace(", LOADED", f", {LOAD}" if loaded else ""))
    return folder / "scenario.yaml"


def gain(path: Path) -> float:
    found = experiments(load_scenario(path))
    assert all("drive gains fitted: hinge" in e.notes[-1] for e in found)
    assert len({float(e.plant.drive["current_factor"][0]) for e in found}) == 1
    return float(found[0].plant.drive["current_factor"][0])


def test_the_own_weight_is_the_scale_where_all_runs_carry_the_same(tmp_path: Path) -> None:
    assert gain(scenario(tmp_path, loaded=False)) == pytest.approx(GAIN, rel=0.01)
    assert gain(scenario(tmp_path, loaded=False, believed=0.6)) == pytest.approx(1.2 * GAIN, rel=0.02)


def test_a_known_load_is_the_scale_whatever_the_robot_weighs(tmp_path: Path) -> None:
    for believed in (0.5, 0.6):
        assert gain(scenario(tmp_path, loaded=True, believed=believed)) == pytest.approx(GAIN, rel=0.01)


def test_the_recorded_effort_is_told_with_it(tmp_path: Path) -> None:
    path = scenario(tmp_path, loaded=True)
    found = experiments(load_scenario(path))
    path.write_text(path.read_text().replace("factor: fit", "factor: 1.0"))
    for fitted, plain in zip(found, experiments(load_scenario(path)), strict=True):
        assert fitted.recording is not None
        assert plain.recording is not None
        assert fitted.recording.trace.effort is not None
        assert plain.recording.trace.effort is not None
        factor = fitted.plant.drive["current_factor"][0]
        np.testing.assert_allclose(fitted.recording.trace.effort, factor * plain.recording.trace.effort)


def test_some_of_the_runs_are_told_the_same_as_all(tmp_path: Path) -> None:
    file = load_scenario(scenario(tmp_path, loaded=True))
    (one,), both = experiments(file, only=["loaded"]), experiments(file)
    assert one.name == "loaded"
    np.testing.assert_array_equal(one.plant.drive, both[1].plant.drive)


def test_a_joint_without_weight_fixes_no_gain(tmp_path: Path) -> None:
    """Its inertia alone tells nothing beside a rotor that is not known."""
    with pytest.raises(InputError, match=r"do not fix the drive gain of hinge .* expected a number"):
        gain(scenario(tmp_path, loaded=True, axis="0 0 1"))


def test_a_driven_motion_fixes_none(tmp_path: Path) -> None:
    path = scenario(tmp_path, loaded=False)
    path.write_text(path.read_text().replace("{followed: true}", "{recorded: position}"))
    with pytest.raises(InputError, match="found fit, which needs"):
        experiments(load_scenario(path))
