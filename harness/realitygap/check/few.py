"""Recordings, or windows of them, that hold too little to say anything of a motion."""

import numpy as np

from realitygap.check.mistake import Mistake
from realitygap.check.observed import Observed
from realitygap.files.found import counted

LEAST = 10
"""Samples that tell a motion from a moment; a diagnosis fits no fewer."""


def few_samples(o: Observed) -> list[Mistake]:
    """Fewer samples that are judged: their gap is that of a moment, and no check sees anything in them. Fewer than two
    are refused by what compares them.
    """
    time, (begin, end) = o.recording.trace.time, o.run.judged
    judged = time[(time >= begin) & (time <= end)]
    if not 2 <= len(judged) < LEAST:
        return []
    key, advice, of = f"{o.key}.path", "record longer, or get the whole file", ""
    recordings = o.scenario.recordings
    if o.run.window is not None and len(time) >= LEAST:
        key, advice, of = f"{o.key}.window", "widen the window", " of its window"
    elif recordings is not None and recordings.part is not None:
        key = "recordings.part" if o.run.part is None else f"{o.key}.part"
        advice, of = "take a longer part", " of its part"
    sentence = (
        f"{o.name} holds {counted(len(judged), 'sample')} in {float(np.ptp(judged)):.3g} s{of}: gaps of so few are of "
        f"a moment and say nothing of a motion; expected at least {LEAST}: {advice}"
    )
    return [Mistake("few_samples", "likely", (), sentence, key, (o.name,))]
