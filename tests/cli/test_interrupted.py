"""A signal ends a command with its own status and sentence, wherever it falls."""

import os
import pickle
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

SCRIPT = """
import os, signal, time, typer
import realitygap.cli.main as command_line

app = typer.Typer()

@app.command()
def compiled_module() -> None:
    try:
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(5)
    except BaseException:
        raise ImportError("initialization failed") from None

command_line.app = app
command_line.main([])
"""


def test_a_signal_that_became_another_error_is_told_as_the_signal() -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 143
    assert done.stderr == "realitygap: ended by SIGTERM; nothing was written\n"


SWALLOWED = """
import os, signal, sys, time
import realitygap.cli.main as command_line
import typer

app = typer.Typer()

@app.command()
def slow() -> None:
    sys.path.insert(0, sys.argv[1])
    import tries_others
    time.sleep(5)
    print("went on")

command_line.app = app
command_line.main([])
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_in_an_import_is_heard_after_it(number: int, tmp_path: Path) -> None:
    """Modules whose import takes any error for a module that is not installed would take a signal for one, too."""
    (tmp_path / "tries_others.py").write_text(
        f"import os\ntry:\n    os.kill(os.getpid(), {int(number)})\nexcept BaseException:\n    pass\n"
    )
    command = [sys.executable, "-c", SWALLOWED, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout) == (128 + number, "")
    assert done.stderr.endswith("; nothing was written\n")


LATE = """
import sys, time
from realitygap.files.interrupted import listening

class Slow:
    def __del__(self) -> None:
        time.sleep(1)

with listening():
    sys.modules["slow"] = Slow()
print("done", flush=True)
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_while_the_interpreter_ends_is_too_late(number: int) -> None:
    with subprocess.Popen([sys.executable, "-c", LATE], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(0.3)
        process.send_signal(number)
    assert process.returncode == 0


@pytest.mark.parametrize("length", [0, 1, 500])
def test_a_worker_whose_question_is_cut_short_ends_in_silence(length: int) -> None:
    """As it is where the process that asks is killed."""
    question = pickle.dumps(list(range(1000)))[:length]
    worker = [sys.executable, "-m", "realitygap.diagnose.data.worker"]
    done = subprocess.run(worker, input=question, capture_output=True, timeout=60, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
@pytest.mark.parametrize("command", ["-m realitygap", "the installed one"])
def test_a_signal_while_the_command_is_imported_ends_it_quietly(number: int, command: str, tmp_path: Path) -> None:
    """The first package that the command needs is one here that is interrupted while it is imported."""
    (tmp_path / "typer.py").write_text(f"import os, time\nos.kill(os.getpid(), {int(number)})\ntime.sleep(5)\n")
    module, name = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["scripts"]["realitygap"].split(":")
    script = ["-c", f"from {module} import {name}; {name}()"]  # as pip writes it
    words = [sys.executable, *(command.split() if command.startswith("-m") else script), "engines"]
    path = os.pathsep.join([str(tmp_path), *map(str, sys.path)])
    done = subprocess.run(words, env={**os.environ, "PYTHONPATH": path}, capture_output=True, timeout=60, check=False)
    assert (done.returncode, done.stdout) == (128 + number, b"")
    assert done.stderr in (b"realitygap: interrupted\n", b"realitygap: ended by SIGTERM\n")
