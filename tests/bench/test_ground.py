"""The ground bench gives back the friction of synthetic tosses, in another engine than the one that made them."""

import re
from pathlib import Path

import pandas as pd
import pytest
from realitygap.bench import ground
from realitygap.files.errors import InputError
from synthetic_tosses import write_tosses

TRUE = 0.17
BENCH = """
scenario: scenario.yaml
engines: [mujoco, pybullet]
stiffness: [1000, 5e4]
damping: [20, 500]
samples: 16
"""


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = write_tosses(tmp_path_factory.mktemp("tosses"), TRUE).with_name("bench.yaml")
    path.write_text(BENCH)
    return path


def test_planted_friction_comes_back(bench: Path, tmp_path: Path) -> None:
    ground.run(bench, tmp_path)
    table = pd.read_csv(tmp_path / "ground.csv", index_col="engine")
    assert list(table.index) == ["mujoco", "pybullet"]
    assert table["friction"].to_numpy() == pytest.approx(TRUE, rel=0.1)
    assert (table["held out"] < 0.01).all()
    assert (table["both ways"] < 0.01).all()


def test_tosses_without_a_part_to_judge_are_refused(bench: Path, tmp_path: Path) -> None:
    scenario = bench.with_name("scenario.yaml").read_text()
    (tmp_path / "cube.urdf").write_text(bench.with_name("cube.urdf").read_text())
    (tmp_path / "scenario.yaml").write_text(
        scenario.replace("toss_[0-3]", f"{bench.parent}/toss_[0-3]").split('    - {path: "toss_[4-5]')[0]
    )
    (tmp_path / "bench.yaml").write_text(BENCH)
    with pytest.raises(InputError, match="none with use: held_out; expected some to fit and some to judge"):
        ground.run(tmp_path / "bench.yaml", tmp_path)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("friction: [0.1]", "friction[1]: is missing; expected bounds of the pair's coefficient"),
        ("friction: [0.5, 0.1]", "friction: found [0.5, 0.1]; bounds [0.5, 0.1] end before they start"),
    ],
)
def test_bounds_that_are_none_are_refused(line: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "bench.yaml"
    path.write_text(f"{BENCH}{line}\n")
    with pytest.raises(InputError, match=re.escape(said)):
        ground.run(path, tmp_path / "out")
    assert not (tmp_path / "out").exists()
