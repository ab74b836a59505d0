"""The supply bench gives back the thesis' table 4.3 and planted resistances."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from realitygap.bench import supply
from realitygap.bench.voltage_drop import chain_resistances, common_resistance, sag_resistance
from realitygap.files.errors import InputError
from realitygap.scenario.schema import EffectSpec

SCENARIOS = Path(__file__).parents[2] / "scenarios"
LEG = ["HipYaw", "HipRoll", "HipPitch", "Knee", "AnklePitch", "AnkleRoll"]
ARM = ["ShoulderPitch", "ShoulderRoll", "Elbow"]
CHAINS = {
    "right leg": [f"R{m}" for m in LEG],
    "left leg": [f"L{m}" for m in LEG],
    "right arm": [f"R{m}" for m in ARM],
    "left arm": [f"L{m}" for m in ARM],
    "head": ["HeadPan", "HeadTilt"],
}
# table 4.3: mean and maximum difference between reported and measured voltage [V]
TABLE_4_3 = {"low": (0.14, 0.31), "medium": (0.09, 0.24), "high": (0.24, 0.60)}
# section 4.2: single motors that it names
NAMED = {("low", "LElbow"): 0.20, ("low", "RElbow"): 0.20, ("medium", "LElbow"): 0.24, ("medium", "RElbow"): -0.08}
DROP_PER_JOINT = {"low": 0.01, "medium": 0.04, "high": 0.12}


def planted_voltages() -> pd.DataFrame:
    """Voltages whose differences are those of table 4.3; high load only at the ends of the chains, as measured."""
    rng = np.random.default_rng(43)
    rows = []
    for condition, (mean_difference, largest) in TABLE_4_3.items():
        motors = [(m, k) for chain in CHAINS.values() for k, m in enumerate(chain)]
        if condition == "high":
            motors = [(chain[-1], len(chain) - 1) for chain in CHAINS.values()]
        fixed = {m: NAMED[condition, m] for m, _ in motors if (condition, m) in NAMED}
        if largest not in np.abs(list(fixed.values())):
            fixed["LAnkleRoll"] = largest
        free = [m for m, _ in motors if m not in fixed]
        size = rng.uniform(0.5, 1.5, len(free))
        size *= (mean_difference * len(motors) - np.abs(list(fixed.values())).sum()) / size.sum()
        error = fixed | dict(zip(free, size * rng.choice([-1, 1], len(free)), strict=True))
        for motor, depth in motors:
            measured = 15.2 - DROP_PER_JOINT[condition] * depth - {"low": 0.0, "medium": 0.1, "high": 0.5}[condition]
            rows.append((motor, condition, measured + error[motor], measured))
    return pd.DataFrame(rows, columns=["motor", "condition", "reported", "measured"]).round(6)


def planted_chain(cable: float, source: float, noise: float = 0.0) -> pd.DataFrame:
    """One chain of four motors behind a source, every cable with the same resistance [Ω], under five loads."""
    rng = np.random.default_rng(1)
    rows = []
    for condition, amperes in enumerate((0.1, 0.3, 0.6, 1.0, 1.5)):
        current = amperes * np.array([1.0, 0.5, 0.8, 0.2])
        volts = 15.0 - source * current.sum()
        for k in range(4):
            volts -= cable * current[k:].sum() if k else 0.0
            rows.append((f"m{k}", f"load {condition}", volts + rng.normal(0, noise), current[k]))
    return pd.DataFrame(rows, columns=["motor", "condition", "measured", "current"])


def test_the_committed_voltages_are_the_planted_ones() -> None:
    committed = pd.read_csv(SCENARIOS / "bench_supply_wolfgang" / "voltages.csv")
    pd.testing.assert_frame_equal(committed, planted_voltages(), check_exact=False, atol=1e-6)


def test_table_4_3_comes_back(tmp_path: Path) -> None:
    text = "\n".join(supply.run(SCENARIOS / "bench_supply_wolfgang" / "bench.yaml", tmp_path).lines)
    rows = [line.split() for line in text.splitlines()]
    for condition, (mean, largest) in TABLE_4_3.items():
        (row,) = [r for r in rows if r[:1] == [condition] and len(r) == 5 and r[4] in ("20", "5")]
        assert row[1:3] == [f"{mean:.2f}", f"{largest:.2f}"]
    assert ["LElbow", "+0.20", "+0.24"] in [r[:3] for r in rows]
    assert ["RElbow", "+0.20", "-0.08"] in [r[:3] for r in rows]
    assert "No currents were measured" in text


@pytest.mark.parametrize("cable", [0.02, 0.2])
def test_the_resistance_of_every_cable_comes_back(cable: float) -> None:
    found = chain_resistances(planted_chain(cable, 0.1), ["m0", "m1", "m2", "m3"])
    assert [x.value for x in found.values()] == pytest.approx([cable] * 3, rel=1e-9)
    assert common_resistance(planted_chain(cable, 0.1), [["m0", "m1", "m2", "m3"]]).value == pytest.approx(cable)


def test_the_interval_holds_the_resistance_under_noise() -> None:
    found = common_resistance(planted_chain(0.05, 0.1, noise=0.01), [["m0", "m1", "m2", "m3"]])
    assert found.low < 0.05 < found.high
    assert found.half_width < 0.02


def test_one_resistance_for_all_is_the_sources_where_cables_have_none() -> None:
    found = sag_resistance(planted_chain(0.0, 0.12))
    assert found is not None
    assert found[0].value == pytest.approx(15.0)
    assert found[1].value == pytest.approx(0.12)


def test_the_effect_and_what_the_drop_does(tmp_path: Path) -> None:
    bench = SCENARIOS / "bench_supply_planted" / "bench.yaml"
    text = "\n".join(supply.run(bench, tmp_path).lines)
    effect = EffectSpec.model_validate(
        yaml.safe_load((tmp_path / "effects.yaml").read_text(encoding="utf-8"))["effects"][0]
    )
    assert effect.effect == "voltage_sag"
    assert effect.target == "*"
    assert 0.12 < effect.parameters["resistance"] < 0.12 + 3 * 0.05
    table = pd.read_csv(bench.parent / "voltages.csv")
    row = next(line for line in text.splitlines() if line.startswith("load 4  "))
    assert float(row.split()[4].rstrip("%")) == pytest.approx((table["measured"].min() / 15.0 - 1) * 100, abs=0.11)


def test_the_committed_chain_is_the_planted_one() -> None:
    committed = pd.read_csv(SCENARIOS / "bench_supply_planted" / "voltages.csv")
    pd.testing.assert_frame_equal(committed, planted_chain(0.05, 0.12).round(6), check_exact=False, atol=1e-6)


@pytest.mark.parametrize(
    ("table", "bench", "expected"),
    [
        ("motor,condition,measured\na,low,\n", "units: {voltage: V}", "row 2 has no measured"),
        ("motor,condition,measured\na,,12\n", "units: {voltage: V}", "row 2 has no condition"),
        ("motor,condition,measured\na,low,12\na,low,11\n", "units: {voltage: V}", "two motors under one name: a"),
        ("motor,condition,measured,current\na,low,12,1\n", "units: {voltage: V}", "units.current: is missing"),
        ("motor,condition,measured\na,low,12\n", "{}", "units: is missing"),
        (
            "motor,condition,measured\na,low,12\n",
            "units: {voltage: V}\nchains: [{name: x, motors: [a, b]}]",
            "b is not in t.csv",
        ),
        (
            "motor,condition,measured\na,low,12\n",
            "units: {voltage: V}\nchains: [{name: x, motors: [a, a]}]",
            "two motors under one name: a",
        ),
    ],
)
def test_bad_input_is_one_sentence(table: str, bench: str, expected: str, tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text(table, encoding="utf-8")
    (tmp_path / "bench.yaml").write_text("table: t.csv\n" + ("" if bench == "{}" else bench + "\n"), encoding="utf-8")
    with pytest.raises(InputError, match=expected) as raised:
        supply.run(tmp_path / "bench.yaml", tmp_path / "out")
    assert "\n" not in str(raised.value)
