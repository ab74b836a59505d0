"""The demo, small enough to be spoiled and run."""

import shutil
from pathlib import Path

import pytest
import yaml
from spoiled import DEMO


@pytest.fixture
def case(tmp_path: Path) -> Path:
    """A scenario that runs: one joint arm, one recording."""
    for name in ("arm.urdf", "chirp_1.mcap", "triangle_1.mcap"):
        shutil.copy(DEMO / name, tmp_path)
    data = yaml.safe_load((DEMO / "scenario.yaml").read_text())
    data["recordings"]["runs"] = [{"path": "chirp_1.mcap"}]
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(data))
    return tmp_path
