"""Traces as Parquet: what is read is what was written, to the last bit, and other tools open the file."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_array_equal
from realitygap.scenario.file import load_scenario
from realitygap.simulate.experiment import experiments, simulate
from realitygap.trace.parquet import JOINT_SIGNALS, read_about, read_parquet, write_parquet
from realitygap.trace.trace import Trace

DEMO = Path(__file__).parents[2] / "scenarios" / "demo" / "scenario.yaml"


def some(rows: int, joints: tuple[str, ...], *without: str) -> Trace:
    """A trace with random values in all signals but some."""
    random = np.random.default_rng(rows)
    width = {"base_quaternion": 4, "imu_quaternion": 4}
    signals = {
        s: random.standard_normal((rows, len(joints) if s in JOINT_SIGNALS else w))
        for s in Trace.SIGNALS
        if s not in without and (w := width.get(s, 3))
    }
    if "supply" in signals:
        signals["supply"] = signals["supply"][:, 0]
    return Trace(np.sort(random.random(rows)), joints, notes=("seen",), **signals)


def same(one: Trace, other: Trace) -> None:
    assert one.joints == other.joints
    assert one.notes == other.notes
    for name in ("time", *Trace.SIGNALS):
        a, b = getattr(one, name), getattr(other, name)
        assert (a is None) == (b is None), name
        if a is not None:
            assert_array_equal(a, b, err_msg=name)


def test_what_is_read_is_what_was_written(tmp_path: Path) -> None:
    traces = {
        "simulated": some(2000, ("hip/left", "slide")),
        "measured": some(300, ("slide", "hip/left"), "supply", "base_linear", "command"),
        "a body": some(10, (), "effort"),
    }
    holes = traces["measured"].effort
    assert holes is not None
    holes[7:9, 1] = np.nan
    path = tmp_path / "traces" / "one.parquet"
    write_parquet(path, traces, {"cell": {"engine": "mujoco"}}, slides=("slide",))
    found = read_parquet(path)
    assert list(found) == list(traces)
    for name, trace in traces.items():
        same(found[name], trace)
    assert list(read_parquet(path, only=("measured", "not there"))) == ["measured"]
    part = read_parquet(path, only=("simulated",), signals=("position", "supply"))["simulated"]
    same(
        part,
        Trace(
            part.time,
            part.joints,
            notes=("seen",),
            position=found["simulated"].position,
            supply=found["simulated"].supply,
        ),
    )
    assert read_about(path)["cell"] == {"engine": "mujoco"}
    assert [p.name for p in path.parent.iterdir()] == ["one.parquet"]


def test_other_tools_see_names_units_and_what_is_missing(tmp_path: Path) -> None:
    pq = pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "one.parquet"
    write_parquet(path, {"simulated": some(5, ("hip", "slide")), "measured": some(3, ("hip", "slide"), "effort")},
                  slides=("slide",))  # fmt: skip
    frame = pd.read_parquet(path)
    assert frame["trace"].tolist() == ["simulated"] * 5 + ["measured"] * 3
    assert frame.loc[frame["trace"] == "measured", "effort/hip"].isna().all()
    schema = pq.read_schema(path)
    units = {n: (schema.field(n).metadata or {}).get(b"unit", b"").decode() for n in schema.names}
    assert units["position/hip"] == "rad"
    assert units["position/slide"] == "m"
    assert units["effort/slide"] == "N"
    assert units["base_angular/x"] == "rad/s"
    assert units["command/hip"] == ""


def test_a_simulated_motion_is_kept_at_its_full_rate_and_smaller_than_in_memory(tmp_path: Path) -> None:
    """With the command; and the same trace twice is the same file."""
    (case,) = experiments(load_scenario(DEMO), only=["chirp_1"])
    trace = simulate(case, "mujoco").trace
    paths = [tmp_path / name for name in ("a.parquet", "b.parquet")]
    for path in paths:
        write_parquet(path, {"simulated": trace})
    assert paths[0].read_bytes() == paths[1].read_bytes()
    same(read_parquet(paths[0])["simulated"], trace)
    values = [v for s in ("time", *Trace.SIGNALS) if (v := getattr(trace, s)) is not None]
    assert math.isclose(1 / np.median(np.diff(trace.time)), case.scenario.physics.step_rate, rel_tol=1e-9)
    assert paths[0].stat().st_size < sum(v.nbytes for v in values)
