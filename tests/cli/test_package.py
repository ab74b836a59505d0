"""The package as others meet it: what the wheel takes, what the lock says, what an import costs."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
PIP = [sys.executable, "-m", "pip", "--quiet", "--no-input", "--disable-pip-version-check"]


def run(*command: str | Path, cwd: Path, path: str = "") -> str:
    environment = {**os.environ, "PYTHONPATH": path, "PIP_NO_INDEX": "1"}
    done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("wheel")
    run(*PIP, "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", out, ROOT, cwd=out)
    (built,) = out.glob("realitygap-*.whl")
    return built


def test_the_wheel_takes_two_names(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    tops = {name.split("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"realitygap_engines", "realitygap"}
    assert not [name for name in names if "tests" in name.split("/")]


def test_the_wheel_holds_every_file_of_the_packages(wheel: Path) -> None:
    wanted = {
        file.relative_to(ROOT / folder).as_posix()
        for folder in ("engines", "harness")
        for file in (ROOT / folder).rglob("*")
        if file.is_file() and "__pycache__" not in file.parts
    }
    assert wanted <= set(zipfile.ZipFile(wheel).namelist())


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The programs of an environment with nothing in it but the wheel; what it needs is borrowed from here."""
    folder = tmp_path_factory.mktemp("environment")
    run(sys.executable, "-m", "venv", "--without-pip", folder, cwd=folder)
    programs = folder / "bin"
    run(*PIP[:3], "--python", programs / "python", *PIP[3:], "install", "--no-deps", wheel, cwd=folder)
    (site,) = folder.glob("lib/python*/site-packages")
    (site / "borrowed.pth").write_text("\n".join(p for p in sys.path if p.endswith("-packages")))
    return programs


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project whose folders are called like those of this repository."""
    folder = tmp_path_factory.mktemp("team")
    for package in ("engines", "harness"):
        (folder / package).mkdir()
        (folder / package / "__init__.py").write_text("OURS = True\n")
    (folder / "conftest.py").write_text("import engines, harness\nassert engines.OURS and harness.OURS\n")
    (folder / "tests").mkdir()
    (folder / "tests" / "test_own.py").write_text("import harness\n\ndef test_own(): assert harness.OURS\n")
    for name in ("arm.urdf", "chirp_1.mcap", "triangle_1.mcap"):
        shutil.copy(ROOT / "scenarios" / "demo" / name, folder)
    told = yaml.safe_load((ROOT / "scenarios" / "demo" / "scenario.yaml").read_text())
    told["recordings"]["runs"] = [{"path": "chirp_1.mcap"}, {"path": "triangle_1.mcap"}]
    (folder / "scenario.yaml").write_text(yaml.safe_dump(told | {"budget": {"position": 5.0}}))
    matrix = {"name": "two", "scenarios": "scenario.yaml", "engines": "mujoco", "floors": False}
    (folder / "matrix.yaml").write_text(yaml.safe_dump(matrix))
    return folder


def test_it_is_the_installed_package(installed: Path, team: Path) -> None:
    """And not the one in this repository, which every other test is about."""
    program = (
        "import harness, realitygap, realitygap_engines as e\nfor m in (harness, realitygap, e): print(m.__file__)"
    )
    own, *others = map(Path, run(installed / "python", "-c", program, cwd=team).split())
    assert own == team / "harness" / "__init__.py"
    assert all(file.is_relative_to(installed.parent) for file in others)


COMMANDS = {
    "pytest": ["python", "-m", "pytest", "-p", "no:cacheprovider", "--engines", "mujoco", "scenario.yaml", "tests"],
    "run": ["realitygap", "run", "scenario.yaml", "--engine", "mujoco", "--out", "out"],
    "matrix": ["realitygap", "matrix", "matrix.yaml", "-j", "2", "--out", "cells"],
    "module": ["python", "-m", "realitygap", "schema"],
}
SAID = {"pytest": "3 passed", "run": "report: out/report.html", "matrix": "2 cells: 2 ok", "module": '"$schema"'}


@pytest.mark.parametrize("name", COMMANDS)
def test_it_works_beside_folders_of_the_same_names(name: str, installed: Path, team: Path) -> None:
    program, *arguments = COMMANDS[name]
    assert SAID[name] in run(installed / program, *arguments, cwd=team)


def lock() -> list[str]:
    """The lock's requirements, one logical line each."""
    text = (ROOT / "requirements.lock").read_text().replace("\\\n", " ")
    return [line for line in text.splitlines() if not line.startswith("#")]


def test_the_lock_names_no_place() -> None:
    text = (ROOT / "requirements.lock").read_text()
    assert "://" not in text
    assert not re.search(r"(^|[\s=@])(/|~|[A-Z]:\\)\S", text, re.MULTILINE), "an absolute path"
    assert not re.search(r"index-url|find-links|trusted-host", text)


def test_the_lock_is_exact_and_hashed() -> None:
    assert lock()
    for line in lock():
        assert re.match(r"[a-z0-9-]+==\S+ .*--hash=sha256:[0-9a-f]{64}", line), line


def test_the_lock_covers_every_dependency() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    asked = [*project["dependencies"], *(r for extra in project["optional-dependencies"].values() for r in extra)]
    names = {re.split(r"[^\w-]", requirement)[0].lower() for requirement in asked} - {"realitygap"}
    assert names <= {line.split("==")[0] for line in lock()}, "run `make lock`"


def test_starting_the_command_imports_no_engine() -> None:
    program = "import sys, realitygap.cli.main; print(*sorted(sys.modules))"
    modules = set(run(sys.executable, "-c", program, cwd=ROOT).split())
    assert modules.isdisjoint({"dartpy", "exudyn", "mujoco", "opensim", "pinocchio", "pybullet", "pydrake"})


def test_the_make_targets_of_the_documents_exist() -> None:
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    for document in ("README.md", "CONTRIBUTING.md"):
        named = set(re.findall(r"(?:^|`)make ([a-z]+)", (ROOT / document).read_text(), re.MULTILINE))
        assert named, document
        assert named <= targets, document
