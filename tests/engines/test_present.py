"""Every engine of the table loads: the laws are tested in the engines at hand, and an absent one would fail none."""

import os
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, metadata, requires, version
from pathlib import Path

import pytest
import realitygap_engines as engines
from packaging.requirements import Requirement


def asked() -> set[str]:
    """The distributions that this platform should have: dependencies and extras, which CI installs too."""
    lines = [Requirement(line) for line in requires("realitygap") or []]
    extras = ["", *(metadata("realitygap").get_all("Provides-Extra") or [])]
    return {r.name for r in lines if r.marker is None or any(r.marker.evaluate({"extra": e}) for e in extras)}


def absent(promised: bool, what: str) -> None:
    """Fail in CI for what was promised; elsewhere skip."""
    (pytest.fail if "CI" in os.environ and promised else pytest.skip)(what)


@pytest.mark.parametrize("name", engines.ENGINES)
def test_an_engine_of_the_table_loads(name: str) -> None:
    entry = engines.ENGINES[name]
    if not entry.installed:
        promised = entry.library is not None or entry.install.split()[-1] in asked()
        absent(promised, f"engine {name} is not installed: {entry.install}")
    assert engines.load(name).name == name


@pytest.mark.parametrize("name", sorted(asked()))
def test_what_tests_need_is_there(name: str) -> None:
    """A law that is skipped without a library (Pinocchio's oracle, xacro, Dask) would be an absence."""
    try:
        assert version(name)
    except PackageNotFoundError:
        absent(True, f"{name} is not installed")


ABSENT = "import realitygap_engines as e\ne.ENGINES['dart'] = e.Entry('', 'nowhere', 'pip install dartpy')\n"
BROKEN = "raise ImportError('libdart.so: cannot open shared object file')\n"


@pytest.mark.parametrize(
    ("file", "text", "ci", "outcome"),
    [
        ("spoiler.py", ABSENT, True, "1 failed"),
        ("spoiler.py", ABSENT, False, "1 skipped"),
        ("dartpy.py", BROKEN, True, "1 failed"),
        ("dartpy.py", BROKEN, False, "1 failed"),
    ],
)
def test_in_ci_an_engine_that_is_not_there_is_a_failure(
    file: str, text: str, ci: bool, outcome: str, tmp_path: Path
) -> None:
    (tmp_path / "spoiler.py").touch()
    (tmp_path / file).write_text(text, encoding="utf-8")
    environment = {k: v for k, v in os.environ.items() if k != "CI"} | ({"CI": "true"} if ci else {})
    environment["PYTHONPATH"] = os.pathsep.join([str(tmp_path), *sys.path])
    law = f"{__file__}::{test_an_engine_of_the_table_loads.__name__}[dart]"
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "spoiler", law]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert outcome in done.stdout, done.stdout + done.stderr
