"""A trace's parts are what they are in the whole."""

import numpy as np
from realitygap.trace.trace import Trace
from signals import Signals
from synthetic import trace


def test_some_signals_at_other_times_are_those_of_all() -> None:
    whole = trace(("a", "b"), 0.1, seed=1, command=True)
    times = np.linspace(whole.time[0], whole.time[-1], 37)
    few = whole.only(["position"])
    assert [s for s in Trace.SIGNALS if getattr(few, s) is not None] == ["position"]
    np.testing.assert_array_equal(Signals(few.at(times)).position, Signals(whole.at(times)).position)
