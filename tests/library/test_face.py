"""`import realitygap`: it costs nothing, changes nothing in the process, and its names are what they are said to be."""

import ast
import importlib.resources
import subprocess
import sys
from pathlib import Path

import pytest
import realitygap as rg

PACKAGE = Path(rg.__file__).parent


def printed(program: str) -> str:
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_import_is_quick() -> None:
    """Processor time, which another program on the machine does not change; and no library behind it."""
    program = (
        "import sys, time\nt = time.process_time()\nimport realitygap\nprint(time.process_time() - t, *sys.modules)"
    )
    seconds, *modules = printed(program).split()
    assert float(seconds) < 0.2
    assert {"numpy", "pandas", "scipy", "numba", "pydantic", "yaml", "realitygap_engines"}.isdisjoint(modules)


STATE = """
import importlib, logging, pkgutil, warnings
from contextlib import suppress
import matplotlib, numba, numpy, pandas, realitygap, realitygap_engines

OTHERS = "dartpy distributed mujoco pinocchio pybullet pydrake pytest rosbags.highlevel ruamel.yaml trimesh yourdfpy"
for name in OTHERS.split():  # what their imports change is theirs
    with suppress(ModuleNotFoundError):
        importlib.import_module(name)

def state():
    known = logging.root.manager.loggerDict
    logs = {n: known[n] for n in known if isinstance(known[n], logging.Logger)} | {"root": logging.root}
    told = {n: (log.level, log.disabled, list(log.handlers), list(log.filters)) for n, log in logs.items()}
    return {
        "logging": {n: settings for n, settings in told.items() if settings != (0, False, [], [])},
        "warnings": list(warnings.filters),
        "matplotlib": dict(matplotlib.rcParams),
        "numpy": numpy.geterr() | numpy.get_printoptions(),
        "pandas": pandas.get_option("display.max_rows"),
        "numba": {k: v for k, v in vars(numba.config).items() if k.isupper()},
        "mujoco": realitygap_engines.ENGINES["mujoco"].installed and mujoco_handler(),
    }

def mujoco_handler():
    import mujoco
    return mujoco.get_mju_user_warning()

before = state()
for package in (realitygap, realitygap_engines):
    for found in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if not found.name.endswith("__main__"):
            try:
                importlib.import_module(found.name)
            except ModuleNotFoundError as error:
                assert error.name in OTHERS.split(), error  # an engine that is not installed
            except realitygap_engines.Unsupported:
                pass  # likewise, of a library of the system
after = state()
print(*[name for name in before if before[name] != after[name]])
"""


def test_importing_every_module_changes_nothing_in_the_process() -> None:
    assert printed(STATE).split() == []


def test_checkers_and_python_find_the_same_names() -> None:
    tree = ast.parse((PACKAGE / "__init__.py").read_text(encoding="utf-8"))
    (block,) = [node for node in tree.body if isinstance(node, ast.If)]
    told = {a.asname: n.module for n in block.body if isinstance(n, ast.ImportFrom) for a in n.names}
    assert told == rg._PLACES
    assert set(dir(rg)) == {*rg.__all__, "__version__"}
    assert [name for name in rg.__all__ if getattr(rg, name) is None] == []


def test_a_verb_stays_one_when_its_room_is_used() -> None:
    program = """
import realitygap as rg
from realitygap.simulate.experiment import experiments
from realitygap.compare.table import table
import realitygap.diagnose.result.workflow
from realitygap import simulate
assert callable(rg.simulate) and callable(rg.compare) and callable(rg.diagnose) and simulate is rg.simulate
"""
    printed(program)


def test_a_name_that_is_not_there() -> None:
    with pytest.raises(AttributeError, match=r"has no simulat; it has .*simulate"):
        rg.simulat  # noqa: B018


@pytest.mark.parametrize("package", ["realitygap", "realitygap_engines"])
def test_the_types_are_for_users_too(package: str) -> None:
    assert (importlib.resources.files(package) / "py.typed").is_file()


def test_the_package_has_no_loose_files() -> None:
    files = {p.name for p in PACKAGE.iterdir() if p.is_file()}
    assert files == {"__init__.py", "__main__.py", "py.typed"}


def test_the_package_runs_as_the_command() -> None:
    done = subprocess.run([sys.executable, "-m", "realitygap", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"realitygap {rg.__version__}\n"
