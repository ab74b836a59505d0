"""The pytest plugin, as a robot team uses it: in a process of its own, on a copy of the demo scenario."""

import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

DEMO = Path(__file__).parents[2] / "scenarios" / "demo"
FIVE_LINES = """import pytest

@pytest.mark.realitygap("demo/scenario.yaml")
def test_arm(reality_gap):
    reality_gap.check({budget})
"""


@pytest.fixture
def project(tmp_path):
    """A project with the scenario, and a function that runs pytest in it."""
    shutil.copytree(DEMO, tmp_path / "demo")
    scenario = tmp_path / "demo" / "scenario.yaml"
    text = scenario.read_text()
    runs = text.index("  runs:\n")
    scenario.write_text(text[:runs] + "  runs:\n    - {path: chirp_1.mcap}\n    - {path: triangle_1.mcap}\n")
    (tmp_path / "pytest.ini").write_text("[pytest]\n")

    def run(*arguments):
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-rA", *arguments]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)

    run.folder = tmp_path
    run.scenario = scenario
    return run


def test_a_scenario_on_the_command_line_is_a_test_per_engine_and_recording(project):
    project.scenario.write_text(project.scenario.read_text() + "budget: {position: 5.0, effort: 0.01}\n")
    done = project("--engines", "mujoco,dart", "demo/scenario.yaml", "--junit-xml", "junit.xml")
    assert done.returncode == 1, done.stdout
    for name in ("mujoco-chirp_1", "mujoco-triangle_1", "dart-chirp_1", "dart-triangle_1"):
        assert f"FAILED demo/scenario.yaml::{name}" in done.stdout
    assert "Traceback" not in done.stdout
    cases = ElementTree.parse(project.folder / "junit.xml").getroot().findall(".//testcase")
    assert len(cases) == 4
    message = cases[0].find("failure").text
    for word in ("effort", "N·m, budget 0.01 N·m", "worst joint", "floor"):
        assert word in message
    assert "position" not in message


def test_within_budget_it_passes(project):
    project.scenario.write_text(project.scenario.read_text() + "budget: {position: 5.0}\n")
    done = project("--engines", "mujoco", "demo/scenario.yaml")
    assert done.returncode == 0, done.stdout
    assert "2 passed" in done.stdout


def test_a_budget_of_what_was_not_measured_fails(project):
    text = project.scenario.read_text().replace("effort: motor", "effort: none")
    project.scenario.write_text(text + "budget: {position: 5.0, effort: 5.0}\n")
    done = project("--engines", "mujoco", "demo/scenario.yaml::mujoco-chirp_1")
    assert done.returncode == 1, done.stdout
    assert "no effort of a moving joint was measured" in done.stdout


@pytest.mark.parametrize(("budget", "status"), [("position=5.0", 0), ("position=0.001", 1)])
def test_five_lines_of_their_own(project, budget, status):
    (project.folder / "test_arm.py").write_text(FIVE_LINES.format(budget=budget))
    done = project("--engines", "mujoco")
    assert done.returncode == status, done.stdout
    assert "test_arm[mujoco-chirp_1]" in done.stdout
    assert "test_arm[mujoco-triangle_1]" in done.stdout


def test_without_engines_nothing_is_collected(project):
    done = project("demo")
    assert "no tests ran" in done.stdout
    done = project("demo", "--engines", "mujoco")
    assert "no tests ran" in done.stdout, "a folder is not a scenario that was named"


@pytest.mark.parametrize(
    ("engines", "sentence"),
    [("havok", "--engine: found havok; expected one of"), ("mujoco", "budget: is missing")],
)
def test_what_is_wrong_is_one_sentence(project, engines, sentence):
    done = project("--engines", engines, "demo/scenario.yaml")
    assert done.returncode != 0
    assert sentence in done.stdout + done.stderr
    assert "pytest_plugin.py" not in done.stdout + done.stderr, "where it was raised"
