"""The package as others meet it: what the wheel takes, what the lock says, what an import costs."""

import os
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

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


def test_a_team_keeps_its_own_tests_and_scenarios(wheel: Path, tmp_path: Path) -> None:
    site, team = tmp_path / "site", tmp_path / "team"
    run(*PIP, "install", "--no-deps", "--target", site, wheel, cwd=tmp_path)
    own = ("engines", "harness", "tests", "scenarios")
    for package in own:
        (team / package).mkdir(parents=True)
        (team / package / "__init__.py").touch()
    program = f"import {', '.join(own)}\nfor m in ({', '.join(own)}): print(m.__file__)"
    # the installed project comes first, so that a name it took would win
    found = run(sys.executable, "-c", program, cwd=tmp_path, path=os.pathsep.join(map(str, (site, team)))).split()
    assert [Path(file).parent for file in found] == [team / package for package in own]


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
    names = {re.match(r"[\w-]+", requirement)[0].lower() for requirement in asked} - {"realitygap"}
    assert names <= {line.split("==")[0] for line in lock()}, "run `make lock`"


def test_starting_the_command_imports_no_engine() -> None:
    program = "import sys, realitygap.cli.main; print(*sorted(sys.modules))"
    modules = set(run(sys.executable, "-c", program, cwd=ROOT).split())
    assert modules.isdisjoint({"dartpy", "mujoco", "pinocchio", "pybullet", "pydrake"})


def test_the_make_targets_of_the_documents_exist() -> None:
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    for document in ("README.md", "CONTRIBUTING.md"):
        named = set(re.findall(r"(?:^|`)make ([a-z]+)", (ROOT / document).read_text(), re.MULTILINE))
        assert named, document
        assert named <= targets, document
