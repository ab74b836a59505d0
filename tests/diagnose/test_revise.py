"""The mended scenario and URDFs run as they are, and are the model that the diagnosis judged."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from realitygap.diagnose.data.problem import build_problem
from realitygap.diagnose.result.replaced import replaced
from realitygap.scenario.file import load_scenario
from realitygap_engines.model.urdf import read_urdf
from revised import assert_same, mended

DEMO = Path(__file__).parents[2] / "scenarios" / "demo"


@pytest.fixture
def demo(tmp_path: Path) -> Callable[..., Path]:
    """A function that copies the demo with two runs of its own and further keys, and returns the scenario."""

    def make(keys: dict[str, Any] | None = None, runs: list[dict[str, Any]] | None = None) -> Path:
        folder = tmp_path / "team" / "demo"
        shutil.copytree(DEMO, folder)
        content = yaml.safe_load((folder / "scenario.yaml").read_text(encoding="utf-8"))
        content.update(keys or {})
        content["recordings"]["runs"] = runs or [{"path": "triangle_1.mcap", "use": "train"}, {"path": "sines_2.mcap"}]
        (folder / "scenario.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
        return folder / "scenario.yaml"

    return make


LOADED = [
    {"path": "steps_1.mcap", "use": "train", "with": {"robot.urdf": "arm_heavy.urdf"}},
    {"path": "triangle_1.mcap", "use": "train", "with": {"servos.drive.gain": 2.5}},
    {"path": "sines_2.mcap", "use": "held_out", "with": {"robot.urdf": "arm_loaded.urdf"}},
]


@pytest.mark.parametrize(
    ("effect", "target", "values"),
    [
        ("coulomb_friction", "elbow", {"torque": 0.5}),
        ("command_delay", "*", {"time": 0.0123456789}),
        ("controller_gain", "*", {"gain": 4.0}),
        ("controller_gain", ("shoulder",), {"gain": 4.0}),
        ("joint_compliance", "elbow", {"stiffness": 60.0}),
        ("base_tilt", "base", {"roll": 0.05, "pitch": -0.02}),
        ("link_mass", "forearm", {"mass": 1.0 / 3.0}),
        ("center_of_mass", "forearm", {"x": 0.01, "y": 0.02, "z": -0.15}),
        ("link_inertia", "forearm", {"scale": 3.0}),
        ("payload", "forearm", {"mass": 0.2, "x": 0.01, "y": 0.0, "z": -0.1}),
    ],
)
def test_a_mended_scenario_moves_as_the_changed_model(
    demo: Callable[..., Path], tmp_path: Path, effect: str, target: str, values: dict[str, float]
) -> None:
    problem, changes, revised = mended(demo(runs=LOADED), [(effect, target, values)], tmp_path / "out")
    assert_same(problem, changes, revised)


def test_it_runs_from_another_folder_when_all_is_moved_together(demo: Callable[..., Path], tmp_path: Path) -> None:
    scenario = demo(runs=LOADED)
    problem, changes, _ = mended(scenario, [("link_mass", "forearm", {"mass": 0.4})], scenario.parent / "out")
    moved = tmp_path / "elsewhere"
    shutil.move(scenario.parent, moved)
    text = (moved / "out" / "revised" / "scenario.yaml").read_text(encoding="utf-8")
    assert str(tmp_path) not in text
    again = build_problem(load_scenario(moved / "out" / "revised" / "scenario.yaml"), "mujoco")
    assert_same(problem, changes, again.file)


def test_what_a_finding_replaces_does_not_stand_twice(demo: Callable[..., Path], tmp_path: Path) -> None:
    effects = [
        {"effect": "coulomb_friction", "target": "*", "torque": 0.1},
        {"effect": "command_delay", "target": "*", "time": 0.004},
        {"effect": "link_inertia", "target": "forearm", "scale": 2.0},
    ]
    found = [
        ("stribeck_friction", "elbow", {"static": 0.5, "coulomb": 0.3, "velocity": 0.4, "exponent": 2.0}),
        ("command_delay", "*", {"time": 0.012}),
        ("link_mass", "forearm", {"mass": 0.4}),
    ]
    problem, changes, revised = mended(demo({"effects": effects}), found, tmp_path / "out")
    assert_same(problem, changes, revised)
    stand = [(e.effect, e.target) for e in revised.scenario.effects]
    assert stand == [("coulomb_friction", ["shoulder"]), ("stribeck_friction", "elbow"), ("command_delay", "*")]
    (told,) = replaced(problem, changes)  # a new value of the same effect is told as such
    assert told.startswith("stribeck_friction at elbow is in the place of the scenario's coulomb_friction")
    assert "torque 0.1" in told


@pytest.mark.parametrize(
    "overrides",
    [
        {"effects": [{"effect": "viscous_friction", "target": "elbow", "coefficient": 0.2}]},
        {"effects.0.torque": 0.4},
        {"effects": []},
    ],
)
def test_a_run_with_effects_of_its_own_keeps_them(
    demo: Callable[..., Path], tmp_path: Path, overrides: dict[str, Any]
) -> None:
    runs = [
        {"path": "triangle_1.mcap", "use": "train"},
        {"path": "sines_2.mcap", "use": "held_out", "with": overrides},
    ]
    keys = {"effects": [{"effect": "coulomb_friction", "target": "shoulder", "torque": 0.1}]}
    problem, changes, revised = mended(demo(keys, runs), [("command_delay", "elbow", {"time": 0.02})], tmp_path / "out")
    assert_same(problem, changes, revised)


def test_every_repetition_has_the_values_of_its_run(demo: Callable[..., Path], tmp_path: Path) -> None:
    slow = {"servos.drive.gain": 2.5}
    runs = [
        {"path": "triangle_1.mcap", "use": "held_out"},
        {"path": "sines_1_rep1.mcap", "use": "train", "with": slow},
        {"path": "sines_1_rep2.mcap", "use": "train", "with": slow},
    ]
    problem, changes, revised = mended(demo(runs=runs), [("controller_gain", "*", {"gain": 6.0})], tmp_path / "out")
    assert_same(problem, changes, revised)
    gains = [c.scenario.effects[0].parameters["gain"] for c in revised.cases()]
    assert gains == pytest.approx([6.0, 6.0 * 2.5 / 5.048, 6.0 * 2.5 / 5.048])


def test_paths_keep_their_meaning(demo: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = demo({"revisions": {"heavy": "arm_heavy.urdf"}})
    monkeypatch.setenv("REALITYGAP_DATA", str(scenario.parent))
    content = yaml.safe_load(scenario.read_text(encoding="utf-8"))
    content["recordings"]["runs"] = [
        {"path": "${REALITYGAP_DATA}/triangle_1.mcap"},
        {"path": str(scenario.parent / "chirp_1.mcap")},
        {"path": "sines_1_rep?.mcap"},
    ]
    scenario.write_text(yaml.safe_dump(content), encoding="utf-8")
    problem, changes, revised = mended(scenario, [("command_delay", "elbow", {"time": 0.02})], tmp_path / "out")
    written = revised.raw["recordings"]["runs"]
    assert written[0]["path"] == "${REALITYGAP_DATA}/triangle_1.mcap"
    assert written[1]["path"] == str(scenario.parent / "chirp_1.mcap")
    assert written[2]["path"] == "../../team/demo/sines_1_rep?.mcap"
    assert revised.resolve(revised.scenario.revisions["heavy"], "revisions.heavy").is_file()
    assert_same(problem, changes, revised)


URDF = """<?xml version="1.0"?>
<robot name="box">
  <!-- weighed on a kitchen scale -->
  <link name="table"/>
  <link name="arm">
    <inertial><origin xyz="0 0 -0.1" rpy="0.3 0 0"/><mass value="1"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.015"/></inertial>
    <collision><geometry><mesh filename="parts/arm.stl"/></geometry></collision>
    <visual><geometry><mesh filename="package://far_away/look.stl"/></geometry></visual>
  </link>
  <link name="hand">
    <inertial><origin xyz="0 0.05 0"/><mass value="0.3"/>
      <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial>
    <collision><geometry><mesh filename="package://box_description/hand.stl"/></geometry></collision>
  </link>
  <joint name="elbow" type="revolute"><parent link="table"/><child link="arm"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="20" velocity="20"/></joint>
  <joint name="wrist" type="fixed"><origin xyz="0 0 -0.2"/><parent link="arm"/><child link="hand"/></joint>
</robot>
"""


def test_a_patched_urdf_has_the_link_with_all_that_is_fixed_to_it(demo: Callable[..., Path], tmp_path: Path) -> None:
    import trimesh

    scenario = demo(runs=[{"path": "log.csv", "use": "train"}])
    folder = scenario.parent
    (folder / "box.urdf").write_text(URDF, encoding="utf-8")
    for place in ("parts/arm.stl", "box_description/hand.stl"):
        (folder / place).parent.mkdir()
        trimesh.creation.box((0.1, 0.1, 0.2)).export(folder / place)
    t = np.arange(0, 1, 0.005)
    rows = "".join(f"{a:.4f},{0.3 * np.sin(6 * a):.5f},{0.3 * np.sin(6 * a):.5f}\n" for a in t)
    (folder / "log.csv").write_text(f"time,command,position\n{rows}", encoding="utf-8")
    content = yaml.safe_load(scenario.read_text(encoding="utf-8"))
    content["robot"]["urdf"], content["motion"] = "box.urdf", {"recorded": "command"}
    content["recordings"] = {"runs": [{"path": "log.csv"}]}
    scenario.write_text(yaml.safe_dump(content), encoding="utf-8")
    problem, changes, revised = mended(scenario, [("link_mass", "arm", {"mass": 2.0})], tmp_path / "out")
    text = (tmp_path / "out" / "revised" / "robot.urdf").read_text(encoding="utf-8")
    assert "kitchen scale" in text
    model = read_urdf(
        revised.path.parent / "robot.urdf",
        floating=False,
        packages={"box_description": folder / "box_description"},
        contact_links=["arm"],
    )
    old = problem.plant.model.links[1]
    assert model.links[1].mass == pytest.approx(2.0)
    np.testing.assert_allclose(model.links[1].com, old.com, atol=1e-12)
    np.testing.assert_allclose(model.links[1].inertia, old.inertia, atol=1e-12)
    assert model.links[1].spheres, "its mesh is found from there"
    assert_same(problem, changes, revised)
