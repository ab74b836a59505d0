"""`rg.compare`: the table of `realitygap run`, with the traces behind it."""

from pathlib import Path

import pytest
import realitygap as rg
from realitygap.cli.main import main
from realitygap.compare.table import to_csv

DEMO = Path(__file__).parents[2] / "scenarios" / "demo" / "scenario.yaml"


@pytest.fixture(scope="module")
def compared() -> rg.Compared:
    return rg.compare(DEMO, engines=["mujoco", "dart"])


def test_its_gaps_are_those_of_the_command(compared: rg.Compared, tmp_path: Path) -> None:
    """In all digits that the command writes."""
    with pytest.raises(SystemExit):
        main(["run", str(DEMO), "--engine", "mujoco", "--engine", "dart", "--out", str(tmp_path)])
    assert to_csv(compared.gaps) == (tmp_path / "gaps.csv").read_text(encoding="utf-8")


def test_the_traces_are_those_of_the_rows(compared: rg.Compared) -> None:
    motions = set(compared.gaps["recording"])
    assert set(compared.measured) == motions
    assert set(compared.simulated) == {(engine, motion) for engine in ("mujoco", "dart") for motion in motions}
    for (_, motion), simulated in compared.simulated.items():
        assert simulated.joints == compared.measured[motion].joints


def test_means_are_over_joints(compared: rg.Compared) -> None:
    one = "engine == 'dart' and recording == 'chirp_1' and signal == 'position'"
    (row,) = compared.means.query(one).to_dict("records")
    assert row["joints"] == 2
    assert row["mean_abs"] == pytest.approx(compared.gaps.query(one)["mean_abs"].mean())


def test_it_tells_itself_in_a_line(compared: rg.Compared) -> None:
    assert repr(compared) == f"<Compared demo in mujoco, dart: {len(compared.gaps)} rows>"


def test_what_fails_is_an_outcome(tmp_path: Path) -> None:
    """A gain that no step of 20 ms can hold, of a motor that has no limit."""
    urdf = tmp_path / "arm.urdf"
    urdf.write_text((DEMO.parent / "arm.urdf").read_text().replace('effort="', 'effort="1e12" was="'))
    wild = rg.load_scenario(DEMO).override(
        {
            "robot.urdf": urdf,
            "recordings.runs": [{"path": "chirp_1.mcap"}],
            "servos": [{"joints": "*", "kind": "cascade", "gain": 1e6, "kv": 1e3, "kp": 1e3}],
            "physics.step_rate": 50,
        }
    )
    done = rg.compare(wild, "mujoco", floors=False)
    assert set(done.gaps["outcome"]) == {"diverged"}
    assert repr(done) == "<Compared demo in mujoco: 6 rows, its only cell failed>"
    assert done.simulated == {}
    with pytest.raises(rg.Diverged, match=r"diverged at .* s at (shoulder|elbow)"):
        rg.simulate(wild, "mujoco")


def test_an_engine_that_is_not_known() -> None:
    with pytest.raises(rg.InputError, match="engines: found havok"):
        rg.compare(DEMO, engines=["havok"])
