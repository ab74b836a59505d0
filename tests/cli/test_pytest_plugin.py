"""The pytest plugin, as a robot team uses it: in a process of its own, on a copy of the demo scenario."""

import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import pytest

DEMO = Path(__file__).parents[2] / "scenarios" / "demo"
FIVE_LINES = """import pytest

@pytest.mark.realitygap("demo/scenario.yaml")
def test_arm(reality_gap):
    reality_gap.check({budget})
"""


@dataclass(frozen=True)
class Project:
    """A project with the demo's scenario; called, it runs pytest in its folder."""

    folder: Path

    @property
    def scenario(self) -> Path:
        return self.folder / "demo" / "scenario.yaml"

    def __call__(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-rA", *arguments]
        return subprocess.run(command, cwd=self.folder, capture_output=True, text=True, check=False)


@pytest.fixture
def project(tmp_path: Path) -> Project:
    shutil.copytree(DEMO, tmp_path / "demo")
    made = Project(tmp_path)
    text = made.scenario.read_text()
    runs = text.index("  runs:\n")
    made.scenario.write_text(text[:runs] + "  runs:\n    - {path: chirp_1.mcap}\n    - {path: triangle_1.mcap}\n")
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    return made


def test_a_scenario_on_the_command_line_is_a_test_per_engine_and_recording(project: Project) -> None:
    project.scenario.write_text(project.scenario.read_text() + "budget: {position: 5.0, effort: 0.01}\n")
    done = project("--engines", "mujoco,dart", "demo/scenario.yaml", "--junit-xml", "junit.xml")
    assert done.returncode == 1, done.stdout
    for name in ("mujoco-chirp_1", "mujoco-triangle_1", "dart-chirp_1", "dart-triangle_1"):
        assert f"FAILED demo/scenario.yaml::{name}" in done.stdout
    assert "Traceback" not in done.stdout
    cases = ElementTree.parse(project.folder / "junit.xml").getroot().findall(".//testcase")
    assert len(cases) == 4
    message = cases[0].findtext("failure")
    assert message is not None
    for word in ("effort", "N·m, budget 0.01 N·m", "worst joint", "floor"):
        assert word in message
    assert "position" not in message


def test_within_budget_it_passes(project: Project) -> None:
    project.scenario.write_text(project.scenario.read_text() + "budget: {position: 5.0}\n")
    done = project("--engines", "mujoco", "demo/scenario.yaml")
    assert done.returncode == 0, done.stdout
    assert "2 passed" in done.stdout


def test_a_budget_of_what_was_not_measured_fails(project: Project) -> None:
    text = project.scenario.read_text().replace("effort: motor", "effort: none")
    project.scenario.write_text(text + "budget: {position: 5.0, effort: 5.0}\n")
    done = project("--engines", "mujoco", "demo/scenario.yaml::mujoco-chirp_1")
    assert done.returncode == 1, done.stdout
    assert "no effort of a moving joint was measured" in done.stdout


@pytest.mark.parametrize(("budget", "status"), [("position=5.0", 0), ("position=0.001", 1)])
def test_five_lines_of_their_own(project: Project, budget: str, status: int) -> None:
    (project.folder / "test_arm.py").write_text(FIVE_LINES.format(budget=budget))
    done = project("--engines", "mujoco")
    assert done.returncode == status, done.stdout
    assert "test_arm[mujoco-chirp_1]" in done.stdout
    assert "test_arm[mujoco-triangle_1]" in done.stdout


def test_without_engines_nothing_is_collected(project: Project) -> None:
    done = project("demo")
    assert "no tests ran" in done.stdout
    done = project("demo", "--engines", "mujoco")
    assert "no tests ran" in done.stdout, "a folder is not a scenario that was named"


@pytest.mark.parametrize(
    ("engines", "sentence"),
    [("havok", "--engines: found havok; expected one of"), ("mujoco", "budget: is missing")],
)
def test_what_is_wrong_is_one_sentence(project: Project, engines: str, sentence: str) -> None:
    done = project("--engines", engines, "demo/scenario.yaml")
    assert done.returncode != 0
    assert sentence in done.stdout + done.stderr
    assert "pytest_plugin.py" not in done.stdout + done.stderr, "where it was raised"
