"""The scenario file: what is written is what is meant, and its reference says what the code does."""

import re
from pathlib import Path

import pytest
import yaml
from realitygap.cli.reference import BEGIN, reference, with_reference
from realitygap.files.errors import InputError
from realitygap.files.yaml_file import load_yaml
from realitygap.robot.plant import build_plant
from realitygap.scenario.file import ScenarioFile, load_scenario
from realitygap.scenario.schema import Scenario
from realitygap.scenario.servos import PidServo

SCENARIOS = Path(__file__).parents[2] / "scenarios"
PAGE = (SCENARIOS / "README.md").read_text(encoding="utf-8")


def scenario(folder: Path, text: str) -> ScenarioFile:
    path = folder / "scenario.yaml"
    path.write_text(f"name: test\nrobot: {{urdf: robot.urdf}}\n{text}")
    return load_scenario(path)


def test_the_reference_is_what_the_code_says() -> None:
    assert with_reference(PAGE) == PAGE, "run `make reference`"


def test_every_key_has_a_meaning() -> None:
    rows = [line for line in reference().splitlines() if line.startswith("| `")]
    assert len(rows) > 70
    assert [row for row in rows if row.endswith("|  |")] == []


def test_every_link_of_the_reference_leads_somewhere() -> None:
    titles = {t.lower() for t in re.findall(r"^### (\w+)", PAGE, re.MULTILINE)}
    assert set(re.findall(r"\]\(#(\w+)\)", PAGE)) <= titles


def test_the_example_is_a_scenario(tmp_path: Path) -> None:
    (example,) = re.findall(r"```yaml\n(.*?)```", PAGE[: PAGE.index(BEGIN)], re.DOTALL)
    path = tmp_path / "scenario.yaml"
    path.write_text(example, encoding="utf-8")
    loaded = load_scenario(path)
    unused = set(Scenario.model_fields) - set(loaded.raw)
    assert unused <= {"revisions"}, "a full example"


@pytest.mark.parametrize("path", sorted(SCENARIOS.glob("*/scenario*.yaml")), ids=lambda p: p.parent.name)
def test_every_scenario_loads(path: Path) -> None:
    assert load_scenario(path).scenario.name


def test_numbers_text_and_anchors(tmp_path: Path) -> None:
    """YAML 1.1 takes 1e-3 for text; a merge key is a section with changes."""
    path = tmp_path / "a.yaml"
    path.write_text("a: 1e-3\nb: -2.5E+4\nc: 1_000\nd: &d {x: 1, y: 2}\ne: {<<: *d, y: 3}\nf: v1\ng: *d\n")
    expected = {"a": 1e-3, "b": -2.5e4, "c": 1000, "d": {"x": 1, "y": 2}, "e": {"x": 1, "y": 3}, "f": "v1"}
    assert load_yaml(path) == expected | {"g": {"x": 1, "y": 2}}


SERVOS = """
servos:
  - {name: legs, joints: "a*", kind: dc, gain: 5, supply: 12, torque_constant: 2, resistance: 3}
  - {name: arms, joints: "b*", kind: pid, kp: 7}
  - {joints: "*", kind: dc, gain: 6, supply: 12, torque_constant: 2, resistance: 3}
"""


@pytest.mark.parametrize(
    ("key", "value", "changed"),
    [
        ("servos.legs.gain", 1.5, {0: ("gain", 1.5)}),
        ("servos.*.gain", 1.5, {0: ("gain", 1.5), 2: ("gain", 1.5)}),
        ("servos.*.duty_limit", 0.5, {0: ("duty_limit", 0.5), 2: ("duty_limit", 0.5)}),
        ("servos.*.kp", 1.5, {1: ("kp", 1.5)}),
        ("servos.*.armature", 0.1, {0: ("armature", 0.1), 1: ("armature", 0.1), 2: ("armature", 0.1)}),
        ("servos.2.supply", 9.0, {2: ("supply", 9.0)}),
    ],
)
def test_an_override_changes_what_it_names_and_nothing_else(
    key: str, value: float, changed: dict[int, tuple[str, float]], tmp_path: Path
) -> None:
    file = scenario(tmp_path, SERVOS)
    before = file.scenario.model_dump()
    after = file.override({key: value}).scenario.model_dump()
    for i, (name, new) in changed.items():
        assert before["servos"][i][name] != new
        before["servos"][i][name] = new
    assert after == before
    assert file.override({}).scenario == file.scenario


def test_an_override_makes_the_section_that_it_needs(tmp_path: Path) -> None:
    file = scenario(tmp_path, "ground: flat\n")
    changed = file.override({"physics.step_rate": 500, "ground.friction": 0.3, "robot.urdf": "other.urdf"}).scenario
    assert (changed.physics.step_rate, changed.timestep) == (500, 0.002)
    assert changed.ground_name == "friction 0.3"
    assert changed.robot.urdf == "other.urdf"
    assert file.scenario.ground_name == "flat"


@pytest.mark.parametrize(
    ("key", "sentence"),
    [
        ("servos.head.gain", "there is no head; expected one of legs, arms, 2, [*]"),
        ("servos.legs", "names a whole entry, expected a key in it"),
        ("servos.*.gian", "none of legs, arms, 2 has gian"),
        ("servos.arms.gain", r"servos\[1\].gain: unknown key"),
        ("name.part", "name: found {part: 1.0}; expected text"),
        ("physics.rate", "physics.rate: unknown key; known here: solver_iterations, step_rate"),
    ],
)
def test_an_override_that_leads_nowhere(key: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=sentence):
        scenario(tmp_path, SERVOS).override({key: 1.0})


def test_recordings_are_found_by_pattern_and_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where the folder's own name looks like a pattern."""
    folder = tmp_path / "runs [old]"
    folder.mkdir()
    for name in ("a_2.csv", "a_1.csv", "b [1].csv"):
        (folder / name).touch()
    (tmp_path / "far.csv").touch()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("REALITYGAP_DATA", ".")
    runs = ["a_*.csv", "b [1].csv", "${REALITYGAP_DATA}/far.csv", {"path": "a_1.csv", "window": [1, 2]}]
    listed = [{"path": r} if isinstance(r, str) else r for r in runs]
    cases = scenario(folder, yaml.safe_dump({"recordings": {"runs": listed}})).cases()
    assert [c.name for c in cases] == ["a_1", "a_2", "b [1]", "far", "a_1#2"]
    assert all(c.path.is_file() for c in cases)
    assert cases[3].path == tmp_path / "far.csv"


def test_a_path_is_told_without_detours_that_lead_nowhere_else(tmp_path: Path) -> None:
    for folder in ("arm", "far/away"):
        (tmp_path / folder).mkdir(parents=True)
    for name in ("a.csv", "far/a.csv", "far/b.csv"):
        (tmp_path / name).touch()
    (tmp_path / "link").symlink_to(tmp_path / "far" / "away")
    paths = {
        "arm/../a.csv": "a.csv",
        "link/../b.csv": "link/../b.csv",
        "link/../a.csv": "link/../a.csv",
        "arm/../c.csv": "arm/../c.csv",
    }
    file = load_scenario({"name": "a", "robot": {"urdf": "a.urdf"}}, folder=tmp_path)
    assert {text: file.resolve(text, "robot.urdf") for text in paths} == {t: tmp_path / p for t, p in paths.items()}


def test_a_run_has_the_scenario_that_holds_for_it(tmp_path: Path) -> None:
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).touch()
    runs = "recordings: {runs: [{path: a.csv, with: {servos.arms.kp: 3}}, {path: b.csv}]}\n"
    kps = [c.scenario.servos[1] for c in scenario(tmp_path, SERVOS + runs).cases()]
    assert [s.kp for s in kps if isinstance(s, PidServo)] == [3, 7]


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("", "flat"),
        ("ground: grass", "grass"),
        ("ground: none", "none"),
        ("ground: {friction: 0.5, stiffness: 2000, damping: 50}", "friction 0.5, stiffness 2000, damping 50"),
    ],
)
def test_grounds_have_names(text: str, name: str, tmp_path: Path) -> None:
    assert scenario(tmp_path, text).scenario.ground_name == name


ARM = """<robot name="arm"><link name="base"/>{}</robot>"""
JOINT = (
    '<link name="l_{0}"><inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    '<joint name="{0}" type="revolute"><parent link="base"/><child link="l_{0}"/>'
    '<limit lower="-1" upper="1" effort="3" velocity="4"/><dynamics damping="0.5" friction="0.25"/></joint>'
)


def test_the_first_servo_that_matches_wins(tmp_path: Path) -> None:
    (tmp_path / "robot.urdf").write_text(ARM.format("".join(JOINT.format(n) for n in ("a", "b", "c"))))
    text = """
servos:
  - {joints: [a, "x*"], kind: pid, kp: 1, friction: {coulomb: 0.1}}
  - {joints: "?", kind: pid, kp: 2}
"""
    file = scenario(tmp_path, text).override({"robot.base": "fixed"})
    plant = build_plant(file)
    assert plant.drive["kp"].tolist() == [1, 2, 2]
    # friction that the servo states replaces the URDF's, also where it leaves a part out
    assert plant.drive["coulomb"].tolist() == [0.1, 0.25, 0.25]
    assert plant.drive["viscous"].tolist() == [0.0, 0.5, 0.5]
    assert plant.model.notes == ()
    alone = build_plant(file, file.override({"servos": file.raw["servos"][:1]}).scenario)
    assert alone.model.notes == ("no servo, move freely: b, c",)
