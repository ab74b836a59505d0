"""Where no simulation comes to its end, that is told on standard error and on the page; status 1 is for budgets."""

from pathlib import Path

import pytest
import yaml
from realitygap.cli.main import main
from realitygap.report.sentences import NO_RESULT
from spoiled import changed, text

TOO_STIFF = [{"joints": "*", "kind": "cascade", "gain": 1e6, "kv": 1e3, "kp": 1e3}]
"""No step of 20 ms can hold it."""
MOVE = '{"keyframes": [{"goals": {"elbow": 20}, "duration": 0.5, "pause": 0.2}]}'


@pytest.fixture
def diverging(case: Path) -> Path:
    """Its scenario diverges in every engine, and its matrix is of that."""
    text('effort="', 'effort="1e12" was="')(case)
    changed(servos=TOO_STIFF, physics={"step_rate": 50})(case)
    matrix = {"name": "m", "scenarios": ["scenario.yaml"], "engines": ["mujoco"], "axes": {"step_rate": [50]}}
    (case / "matrix.yaml").write_text(yaml.safe_dump(matrix))
    return case


def ended(folder: Path, *command: str) -> int | str | None:
    """The status of a command, with the page in `out`."""
    with pytest.raises(SystemExit) as end:
        main([*command, "--out", str(folder / "out")])
    return end.value.code


@pytest.mark.parametrize("command", ["run scenario.yaml --engine mujoco", "matrix matrix.yaml"])
def test_it_is_told(
    command: str, diverging: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(diverging)
    assert ended(diverging, *command.split()) == 0
    out, err = capfd.readouterr()
    assert NO_RESULT in err.splitlines()
    assert "diverged" in out
    assert NO_RESULT in (diverging / "out" / "report.html").read_text()


def test_nor_of_a_motion_that_was_not_recorded(
    diverging: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (diverging / "move.json").write_text(MOVE)
    changed(motion={"keyframes": "move.json"}, recordings=None)(diverging)
    monkeypatch.chdir(diverging)
    assert ended(diverging, "run", "scenario.yaml", "--engine", "mujoco") == 0
    out, err = capfd.readouterr()
    assert NO_RESULT in err.splitlines()
    assert "traces only" not in out
    assert NO_RESULT in (diverging / "out" / "report.html").read_text()
