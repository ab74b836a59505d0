"""Tables and bags of a servo bench: units are converted, and what cannot be used is one sentence."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from realitygap.bench import servo
from realitygap.files.errors import InputError
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from thesis_servo import planted_sweep

BAD: dict[str, tuple[Callable[[pd.DataFrame], pd.DataFrame], str]] = {
    "no load": (lambda t: t.assign(load=t["load"].astype(object).where(t.index != 3, None)), "row 5 has no load"),
    "no voltage": (lambda t: t.assign(supply=t["supply"].where(t.index != 0)), "row 2 has no supply"),
    "two loads": (lambda t: t[t["load"] < 0.4], "MX 106 at 12.8 V was measured with 2 loads"),
    "one name, two types": (lambda t: t.replace({"mx64_1": "mx106_1"}), "two motors under one name: mx106_1"),
    "one name, two ages": (lambda t: t.replace({"mx106_3": "mx106_1"}), "two motors under one name: mx106_1"),
    "no column": (lambda t: t.drop(columns="speed"), "column speed is missing"),
    "a word": (lambda t: t.assign(torque=t["torque"].astype(object).where(t.index != 1, "much")), "row 3 has torque"),
    "no rows": (lambda t: t.iloc[:0], "has no rows"),
    "one name twice": (lambda t: t.assign(o=0.0).rename(columns={"o": "torque"}), "more than one column torque"),
}


@pytest.mark.parametrize("what", BAD)
def test_rows_that_cannot_be_used_are_one_sentence(what: str, tmp_path: Path) -> None:
    spoil, expected = BAD[what]
    spoil(planted_sweep()).to_csv(tmp_path / "torque_speed.csv", index=False)
    (tmp_path / "bench.yaml").write_text(
        "units: {torque: N·m, speed: rad/s, supply: V, load: kg}\ntorque_speed: torque_speed.csv\n", encoding="utf-8"
    )
    with pytest.raises(InputError, match=expected) as raised:
        servo.run(tmp_path / "bench.yaml", tmp_path / "out")
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("torque_speed: t.csv", "units: is missing"),
        ("units: {torque: N·m, speed: rad/s, supply: V}\ntorque_speed: t.csv", "units.load: is missing"),
        (
            "units: {torque: N·m, speed: furlong, supply: V, load: kg}\ntorque_speed: t.csv",
            "units.speed: found 'furlong'",
        ),
        ("torque_sped: t.csv", "torque_sped: unknown key; known here: .*torque_speed"),
        ("nominal_supply: 14.8", "nominal_supply: found 14.8; its unit is missing"),
        ("types: [{name: a}, {name: a}]\nstatic_friction: {table: t.csv, unit: N·m}", "types: a stands twice"),
        ("regression: torque_on_speed", "names no measurement"),
        ("units: {torque: N·m, speed: rad/s, supply: V, load: kg}\ntorque_speed: t.csv", "t.csv: cannot be read"),
    ],
)
def test_a_wrong_bench_file_is_one_sentence(text: str, expected: str, tmp_path: Path) -> None:
    (tmp_path / "bench.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=expected) as raised:
        servo.run(tmp_path / "bench.yaml", tmp_path / "out")
    assert "\n" not in str(raised.value)


def test_units_are_converted(tmp_path: Path) -> None:
    sweep = planted_sweep()
    sweep["torque"] *= 100
    sweep["speed"] *= 60 / (2 * np.pi)
    sweep.to_parquet(tmp_path / "torque_speed.parquet")
    (tmp_path / "bench.yaml").write_text(
        "units: {torque: N·cm, speed: rev/min, supply: V, load: kg}\ntorque_speed: torque_speed.parquet\n",
        encoding="utf-8",
    )
    text = "\n".join(servo.run(tmp_path / "bench.yaml", tmp_path / "out").lines)
    assert "6.80 [6.48, 7.12]" in text


STORE = get_typestore(Stores.ROS2_HUMBLE)


def write_bag(path: Path, speed: float, torque: float) -> None:
    """A lift: the speed rises to its maximum and falls again; the torque is right only at that moment."""
    state = STORE.types["sensor_msgs/msg/JointState"]
    header = STORE.types["std_msgs/msg/Header"]
    time = STORE.types["builtin_interfaces/msg/Time"]
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topic = writer.add_connection("/motor", state.__msgtype__, typestore=STORE)
        for k in range(101):
            shape = 1 - ((k - 60) / 60) ** 2
            message = state(
                header(time(0, k), ""), ["m"], np.zeros(1), np.array([speed * shape]), np.array([torque + abs(k - 60)])
            )
            writer.write(topic, 1_000_000 * k, STORE.serialize_cdr(message, state.__msgtype__))


SWEEP = """torque_speed:
  speed: {topic: /motor, field: velocity, unit: rad/s}
  torque: {topic: /motor, field: effort, unit: N·m}
  bags:
"""


def test_a_sweep_from_bags_is_the_largest_speed_and_its_torque(tmp_path: Path) -> None:
    text = SWEEP
    for k, load in enumerate((0.0, 1.0, 2.0, 3.0)):
        torque = 1.5 * load
        write_bag(tmp_path / f"load{k}", 6.0 * (1 - torque / 7.0), torque)
        text += f"    - {{path: load{k}, motor: m, type: MX, supply: 12 V, load: {load} kg}}\n"
    (tmp_path / "bench.yaml").write_text(text, encoding="utf-8")
    report = "\n".join(servo.run(tmp_path / "bench.yaml", tmp_path / "out").lines)
    assert "7.00 [7.00, 7.00]" in report
    assert "6.00 [6.00, 6.00]" in report


@pytest.mark.parametrize(
    ("field", "topic", "expected"),
    [
        ("velocity", "/other", "has no topic /other; found /motor"),
        ("speed", "/motor", "has no field speed"),
        ("name", "/motor", "field name of /motor holds no number"),
    ],
)
def test_a_signal_that_is_not_there_is_one_sentence(field: str, topic: str, expected: str, tmp_path: Path) -> None:
    write_bag(tmp_path / "load", 6.0, 0.0)
    text = SWEEP.replace("topic: /motor, field: velocity", f"topic: {topic}, field: {field}")
    text += "    - {path: load, motor: m, type: MX, supply: 12 V, load: 1 kg}\n"
    (tmp_path / "bench.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=expected):
        servo.run(tmp_path / "bench.yaml", tmp_path / "out")


def test_a_file_that_is_no_bag_is_one_sentence(tmp_path: Path) -> None:
    for name in ("no.bag", "no.mcap"):
        (tmp_path / name).write_bytes(b"this is no bag")
        text = SWEEP + f"    - {{path: {name}, motor: m, type: MX, supply: 12 V, load: 1 kg}}\n"
        (tmp_path / "bench.yaml").write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match="the bag cannot be read"):
            servo.run(tmp_path / "bench.yaml", tmp_path / "out")
