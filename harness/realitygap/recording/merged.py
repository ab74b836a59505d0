"""Joint states that come joint by joint, as of several publishers on one topic, brought to one clock."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from realitygap.recording.absent import BRIDGED
from realitygap.recording.streams import Samples
from realitygap.trace.trace import Array


def on_one_clock(samples: Samples) -> tuple[Samples, str]:
    """A stream with all joints in each of its samples, and what was done; "" where they are so already.

    The clock is that of the joint at whose stamps most readings were taken, of all joints together. Another joint that
    was not measured at such a stamp is interpolated between its own neighbours, and NaN where these are further apart
    than `BRIDGED` of its usual periods, or missing.

    Args:
        samples: the stream, whose `present` says which joints a sample was taken of; None: all.
    """
    present = samples.present
    if present is None:
        return samples, ""
    if present.all():
        return replace(samples, present=None), ""
    readings = present.T.astype(int) @ present.sum(axis=1)
    clock = int(np.argmax(readings))
    own = present[:, clock]
    signals = {
        name: np.column_stack(
            [_between(samples.time, value[:, j], present[:, j], own) for j in range(len(samples.joints))]
        )
        for name, value in samples.signals.items()
    }
    receive = None if samples.receive is None else samples.receive[own]
    others = ", ".join(joint for i, joint in enumerate(samples.joints) if not present[own, i].all())
    told = f"{samples.source} is taken at the stamps of {samples.joints[clock]}"
    told += f"; in between, {others} is interpolated" if others else ""
    return replace(samples, time=samples.time[own], signals=signals, present=None, receive=receive), told


def _between(time: Array, value: Array, there: NDArray[np.bool_], at: NDArray[np.bool_]) -> Array:
    """One joint (m,) at some of the times of all; what was measured there is as it was. Shape (k,)."""
    out = value[at]
    lacking = np.flatnonzero(~there[at])
    own = time[there]
    if len(own) < 2 or not len(lacking):
        return np.asarray(out)
    sought = time[at][lacking]
    after = np.searchsorted(own, sought)
    inside = (after > 0) & (after < len(own))
    lacking, sought, after = lacking[inside], sought[inside], after[inside]
    steps = np.diff(own)
    near = steps[after - 1] <= BRIDGED * np.median(steps)
    out[lacking[near]] = np.interp(sought[near], own, value[there])
    return np.asarray(out)
