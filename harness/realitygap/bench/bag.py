"""Single signals from a bag, by topic and field."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from realitygap.bench.estimate import Array
from realitygap.bench.servo_file import Signal
from realitygap.files.errors import InputError
from realitygap.files.found import counted
from realitygap.recording.readers.rosbag import Bag, opened, short


def read_signals(path: Path, signals: Sequence[Signal]) -> list[tuple[Array, Array]]:
    """Time [s, from the first message of all] and value of every signal, as recorded. Both Shape (t,).

    Raises:
        InputError: for a bag that cannot be read, a topic that is not there or a field without a number.
    """
    if not path.exists():
        raise InputError(f"{path}: does not exist; expected a bag")
    with opened(path) as bag:
        return [_read(bag, signal) for signal in signals]


def _read(bag: Bag, signal: Signal) -> tuple[Array, Array]:
    if signal.topic not in bag.types:
        raise InputError(f"{bag.path}: has no topic {signal.topic}; found {', '.join(sorted(bag.types))}")
    kind = short(bag.types[signal.topic])
    times, values = [], []
    for _, received, message in bag.messages({signal.topic}):
        value: object = message
        for part in signal.field.split("."):
            if not hasattr(value, part):
                raise InputError(f"{bag.path}: {kind} of {signal.topic} has no field {signal.field}")
            value = getattr(value, part)
        try:
            flat = np.atleast_1d(np.asarray(value, dtype=float))
        except (TypeError, ValueError):
            flat = np.zeros(0)
        if not len(flat) or not np.isfinite(flat[0]):
            raise InputError(
                f"{bag.path}: field {signal.field} of {signal.topic} holds no number; expected one per message"
            )
        times.append(received)
        values.append(float(flat[0]))
    if len(times) < 2:
        raise InputError(f"{bag.path}: topic {signal.topic} has {counted(len(times), 'message')}; expected a recording")
    # stamps that repeat would make the time not increase
    stamps, first = np.unique((np.array(times, dtype=np.int64) - bag.begin) * 1e-9, return_index=True)
    return stamps, np.array(values)[first]
