"""A signal ends a command with its own status and sentence, wherever it falls."""

import subprocess
import sys

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


def test_a_signal_that_became_an_error_of_an_import_is_told_as_the_signal() -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 143
    assert done.stderr == "realitygap: ended by SIGTERM; nothing was written\n"
