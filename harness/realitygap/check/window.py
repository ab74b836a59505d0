"""Windows that reach beyond their recordings, as those do whose times are of another clock."""

from realitygap.check.mistake import Mistake
from realitygap.check.observed import Observed

BEYOND = 0.1
"""The share of a window that may lie beyond its recording: ends are rounded, and streams do not begin at once."""


def window_mistakes(o: Observed) -> list[Mistake]:
    """A window of which much lies beyond what was measured, so that less is judged than it says. One that lies there
    as a whole is refused by what compares.
    """
    if o.run.window is None:
        return []
    begin, end = o.run.window
    first, last = float(o.recording.trace.time[0]), float(o.recording.trace.time[-1])
    missed = max(first - begin, 0.0) + max(end - last, 0.0)
    if not BEYOND < missed / (end - begin) < 1.0:
        return []
    sentence = (
        f"[{begin:g}, {end:g}] reaches beyond {o.name}, which lasts from {first:.2f} to {last:.2f} s; expected a "
        "window within it, in s from its first message"
    )
    return [Mistake("window", "likely", (), sentence, f"{o.key}.window", (o.name,))]
