"""A trace as a table holds what the trace holds, under names that people know."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from realitygap.trace.trace import Trace

TIME = np.array([0.5, 0.75, 1.0])
JOINTS = ("hip", "knee")
SIX = np.arange(6.0).reshape(3, 2)
SIGNALS = ("position", "velocity", "effort", "command")
EVERY = Trace(
    TIME,
    JOINTS,
    position=SIX,
    velocity=SIX + 10,
    effort=SIX + 20,
    command=SIX + 30,
    base_position=np.arange(9.0).reshape(3, 3),
    base_quaternion=np.tile([1.0, 0.0, 0.0, 0.0], (3, 1)),
    supply=np.array([15.0, 14.9, 14.8]),
)


def test_every_sample_stands_where_its_names_say() -> None:
    frame = EVERY.to_frame()
    assert frame.index.name == "time"
    assert frame.columns.names == ["signal", "joint"]
    assert frame.index.tolist() == TIME.tolist()
    for signal in SIGNALS:
        for i, joint in enumerate(JOINTS):
            assert frame[signal, joint].tolist() == getattr(EVERY, signal)[:, i].tolist()
    assert frame["base_position", "z"].tolist() == [2.0, 5.0, 8.0]
    assert frame["base_quaternion", "w"].tolist() == [1.0, 1.0, 1.0]
    assert frame["supply", ""].tolist() == [15.0, 14.9, 14.8]
    assert len(frame.columns) == 4 * 2 + 3 + 4 + 1


def test_what_was_not_recorded_has_no_column() -> None:
    frame = Trace(TIME, JOINTS, position=np.zeros((3, 2))).to_frame()
    assert frame.columns.equals(pd.MultiIndex.from_product([["position"], JOINTS]))
    assert Trace(TIME, ()).to_frame().shape == (3, 0)


def test_a_joint_may_be_called_like_an_axis() -> None:
    trace = Trace(TIME, ("x", "supply"), position=np.eye(3, 2), base_position=np.zeros((3, 3)))
    assert trace.to_frame()["position", "x"].tolist() == [1.0, 0.0, 0.0]


@pytest.mark.parametrize("trace", [EVERY, Trace(np.empty(0), ()), replace(EVERY, joints=tuple(map(str, range(40))))])
def test_a_trace_tells_itself_in_a_line(trace: Trace) -> None:
    assert len(repr(trace)) < 160
    assert "\n" not in repr(trace)
    assert f"{len(trace.time)} samples" in repr(trace)
