"""Results of another scenario that are written over are told: two folders may have one name."""

import shutil
from pathlib import Path

import pytest
import yaml
from realitygap.cli.main import main

DEMO = Path(__file__).parents[2] / "scenarios" / "demo"


def scenario(folder: Path, name: str) -> Path:
    """The demo (synthetic) with one of its recordings, under another name."""
    folder.mkdir()
    content = yaml.safe_load((DEMO / "scenario.yaml").read_text())
    run = content["recordings"]["runs"][0]
    for file in ("arm.urdf", "arm_heavy.urdf", run["path"]):
        shutil.copy(DEMO / file, folder / file)
    content["recordings"]["runs"] = [run]
    (folder / "scenario.yaml").write_text(yaml.safe_dump(content | {"name": name}))
    return folder / "scenario.yaml"


def test_a_run_says_whose_results_it_replaces(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, told = tmp_path / "out", []
    for number, name in enumerate(("kick", "kick", "jump")):
        path = scenario(tmp_path / str(number), name)
        with pytest.raises(SystemExit, match="0"):
            main(["run", str(path), "--engine", "mujoco", "--out", str(out)])
        told.append([line for line in capsys.readouterr().out.splitlines() if "are replaced" in line])
    assert told == [[], [], [f"the results of kick, which were in {out}, are replaced; --out takes another folder"]]
