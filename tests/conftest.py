"""What all tests share: the folder of recordings that lies outside the repository."""

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder that `REALITYGAP_DATA` names; a test that asks for it is skipped where there is none."""
    folder = os.environ.get("REALITYGAP_DATA")
    if not folder or not Path(folder).is_dir():
        pytest.skip("needs recordings from outside the repository: set REALITYGAP_DATA to their folder")
    return Path(folder).resolve()


def _message(store: Any, kind: str, values: dict[str, Any]) -> Any:
    """A ROS message from nested dicts; what is not given is 0, empty or ''."""
    from rosbags.interfaces import Nodetype

    fields = {}
    for name, (node, detail) in store.fielddefs[kind][1]:
        value = values.get(name)
        if node == Nodetype.NAME:
            fields[name] = _message(store, detail, value or {})
        elif node == Nodetype.BASE:
            fields[name] = value if value is not None else "" if detail[0] == "string" else 0
        else:
            (inner, base), length = detail
            if inner == Nodetype.NAME:
                fields[name] = [_message(store, base, v) for v in value or []]
            elif base[0] == "string":
                fields[name] = list(value or [])
            else:
                empty = np.zeros(length if node == Nodetype.ARRAY else 0)
                fields[name] = np.asarray(empty if value is None else value, dtype=base[0])
    return store.types[kind](**fields)


@pytest.fixture(scope="session")
def write_bag() -> Callable[..., Path]:
    """A function that writes messages to a rosbag 1 (`bag`) or rosbag 2 (`mcap`, `db3`) and returns its path.

    A message is topic, time of reception [s], type, and its fields as nested dicts; a `stamp` among them is the
    header's [s]. `definitions` are message definitions by type.
    """
    from rosbags import rosbag1, rosbag2
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    def write(
        path: Path,
        form: str,
        messages: Iterable[tuple[str, float, str, dict[str, Any]]],
        definitions: dict[str, str] | None = None,
    ) -> Path:
        store = get_typestore(Stores.ROS1_NOETIC if form == "bag" else Stores.ROS2_HUMBLE)
        for kind, text in (definitions or {}).items():
            store.register(get_types_from_msg(text, kind))
        writer: Any
        if form == "bag":
            writer = rosbag1.Writer(path)
        else:
            plugin = rosbag2.StoragePlugin.MCAP if form == "mcap" else rosbag2.StoragePlugin.SQLITE3
            writer = rosbag2.Writer(path, version=9, storage_plugin=plugin)
        with writer:
            connections = {}
            for topic, receive, kind, values in messages:
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, kind, typestore=store)
                fields = dict(values)
                if "stamp" in fields:
                    ns = round(fields.pop("stamp") * 1e9)
                    fields["header"] = {"stamp": {"sec": ns // 10**9, "nanosec": ns % 10**9}}
                message = _message(store, kind, fields)
                raw = store.serialize_ros1(message, kind) if form == "bag" else store.serialize_cdr(message, kind)
                writer.write(connections[topic], round(receive * 1e9), raw)
        return path

    return write
