"""Single signals from a bag, by topic and field."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.typesys import Stores, get_typestore

from realitygap.bench.estimate import Array
from realitygap.bench.servo_file import Signal
from realitygap.files.errors import InputError


def read_signals(path: Path, signals: Sequence[Signal]) -> list[tuple[Array, Array]]:
    """Time [s, from the first message of all] and value of every signal, as recorded. Both Shape (t,).

    Raises:
        InputError: for a bag that cannot be read, a topic that is not there or a field without a number.
    """
    if not path.exists():
        raise InputError(f"{path}: does not exist; expected a bag")
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
            return [_read(path, reader, signal) for signal in signals]
    except AnyReaderError as error:
        raise InputError(f"{path}: is not a bag that can be read ({error})") from None


def _read(path: Path, reader: AnyReader, signal: Signal) -> tuple[Array, Array]:
    connections = [c for c in reader.connections if c.topic == signal.topic]
    if not connections:
        found = ", ".join(sorted({c.topic for c in reader.connections}))
        raise InputError(f"{path}: has no topic {signal.topic}; found {found}")
    times, values = [], []
    for connection, stamp, raw in reader.messages(connections=connections):
        value: object = reader.deserialize(raw, connection.msgtype)
        for part in signal.field.split("."):
            if not hasattr(value, part):
                raise InputError(f"{path}: {connection.msgtype} of {signal.topic} has no field {signal.field}")
            value = getattr(value, part)
        try:
            flat = np.atleast_1d(np.asarray(value, dtype=float))
        except (TypeError, ValueError):
            flat = np.zeros(0)
        if not len(flat) or not np.isfinite(flat[0]):
            raise InputError(
                f"{path}: field {signal.field} of {signal.topic} holds no number; expected one per message"
            )
        times.append(stamp)
        values.append(float(flat[0]))
    if len(times) < 2:
        raise InputError(f"{path}: topic {signal.topic} has {len(times)} messages; expected a recording")
    # stamps that repeat would make the time not increase
    stamps, first = np.unique((np.array(times, dtype=np.int64) - reader.start_time) * 1e-9, return_index=True)
    return stamps, np.array(values)[first]
