"""`realitygap bench supply`: what voltage the motors really get, and what a drop does to them (thesis, 4.2)."""

from pathlib import Path

import numpy as np
import pandas as pd

from realitygap.bench.estimate import Estimate
from realitygap.bench.summary import Summary
from realitygap.bench.supply_file import SupplyBench, load_supply_bench
from realitygap.bench.table import read_table
from realitygap.bench.voltage_drop import chain_resistances, common_resistance, sag_resistance
from realitygap.files.errors import InputError
from realitygap.scenario.file import resolve_path


def run(bench: Path, out: Path) -> Summary:
    """Evaluate a supply bench file and write its summary and the effect's text into a folder.

    Raises:
        InputError: one sentence on what cannot be used.
    """
    spec = load_supply_bench(bench)
    table = _read(bench, spec)
    summary = Summary()
    if "reported" in table:
        _reported(table, summary)
    sag = _drop(spec, table, summary)
    _consequence(spec, table, sag, summary)
    if sag is not None:
        supply, resistance = sag
        effect = f'effects: [{{effect: voltage_sag, target: "*", resistance: {resistance.value:.4g}}}]'
        summary.section("For a scenario")
        summary.lines += [effect, f"with a supply of {supply.value:.4g} V in the servos"]
        summary.write(out / "effects.yaml", effect + "\n")
    summary.write(out / "summary.txt", "\n".join(summary.lines) + "\n")
    return summary


def _read(path: Path, spec: SupplyBench) -> pd.DataFrame:
    file = resolve_path(path, spec.table, "table")
    volt = spec.units.voltage
    columns = {"measured": volt, "reported": volt, "supply": volt, "current": spec.units.current or 1.0}
    table = read_table(file, ("motor", "condition"), columns, optional=("reported", "supply", "current"))
    if "current" in table and spec.units.current is None:
        raise InputError(f"{path}: units.current: is missing, but {file.name} has a column current; expected its unit")
    double = table[table.duplicated(["motor", "condition"])]
    if len(double):
        motor, condition = double[["motor", "condition"]].iloc[0]
        raise InputError(
            f"{file}: two motors under one name: {motor} stands twice under condition {condition}; give every motor "
            "its own name"
        )
    known = set(table["motor"])
    for i, chain in enumerate(spec.chains):
        missing = [m for m in chain.motors if m not in known]
        if missing:
            raise InputError(
                f"{path}: chains[{i}].motors: {missing[0]} is not in {file.name}; expected measured motors"
            )
    return table


def _reported(table: pd.DataFrame, summary: Summary) -> None:
    error = table["reported"] - table["measured"]
    summary.section("Reported less measured voltage")
    conditions = table["condition"].unique()
    rows = []
    for condition in conditions:
        e = error[table["condition"] == condition]
        rows.append([condition, f"{e.abs().mean():.2f}", f"{e.abs().max():.2f}", f"{e.mean():+.2f}", str(len(e))])
    header = ["condition", "mean difference [V]", "maximum difference [V]", "signed mean [V]", "motors"]
    summary.table(header, rows)
    summary.lines.append("")
    by_motor = table.assign(error=error).pivot(index="motor", columns="condition", values="error")
    summary.table(
        ["motor", *conditions, "mean"],
        [
            [str(motor), *(f"{row[c]:+.2f}" if np.isfinite(row[c]) else "-" for c in conditions), f"{row.mean():+.2f}"]
            for motor, row in by_motor.iterrows()
        ],
    )
    values = by_motor.to_numpy(float)
    means = np.nanmean(values, axis=1)
    own, rest = float(np.std(means, ddof=1)), float(np.nanstd(values - means[:, None]))
    kind = "mostly each motor's own, and can be calibrated away" if own > rest else "not constant per motor"
    summary.lines.append(
        f"The error is {kind}: its means differ by {own:.2f} V between motors, by {rest:.2f} V within them."
    )


def _drop(spec: SupplyBench, table: pd.DataFrame, summary: Summary) -> tuple[Estimate, Estimate] | None:
    if spec.chains:
        summary.section("Measured drop along the chains, first motor less last [V]")
        conditions = list(table["condition"].unique())
        volts = table.pivot(index="condition", columns="motor", values="measured")
        rows = []
        for chain in spec.chains:
            drops = (volts[chain.motors[0]] - volts[chain.motors[-1]]).to_dict()
            rows.append([chain.name, *(f"{drops[c]:.2f}" if np.isfinite(drops[c]) else "-" for c in conditions)])
        summary.table(["chain", *conditions], rows)
    if "current" not in table:
        summary.lines.append("No currents were measured: the drop cannot be turned into resistances.")
        return None
    if spec.chains:
        summary.section("Resistance of the cable before each motor [Ω], 95 % intervals")
        for chain in spec.chains:
            for motor, found in chain_resistances(table, chain.motors).items():
                summary.lines.append(f"{chain.name}: {motor}  {found.text(4)}")
        common = common_resistance(table, [c.motors for c in spec.chains])
        summary.lines.append(f"one for all joints  {common.text(4)}")
    sag = sag_resistance(table)
    if sag is None:
        summary.lines.append("Fewer than two load conditions have all motors: no resistance of the whole supply.")
        return None
    summary.section("The whole supply, as the effect voltage_sag sees it")
    summary.lines.append(f"supply without load {sag[0].text()} V, resistance {sag[1].text(4)} Ω of the summed current")
    return sag


def _consequence(
    spec: SupplyBench, table: pd.DataFrame, sag: tuple[Estimate, Estimate] | None, summary: Summary
) -> None:
    """What the drop does: stall torque and no-load speed of a DC motor are both proportional to its voltage."""
    if sag is not None:
        reference = sag[0].value
    elif "supply" in table:
        reference = float(table["supply"].max())
    else:
        reference = float(table["measured"].max())
    summary.section(f"What the drop does to torque and speed (against {reference:.2f} V)")
    rows = []
    for condition, group in table.groupby("condition", sort=False):
        lowest = group.iloc[int(np.argmin(group["measured"]))]
        drop = reference - float(lowest["measured"])
        row = [str(condition), str(lowest["motor"]), f"{drop:.2f}", f"{-drop / reference:+.1%}"]
        if spec.drive is not None:
            constant, resistance = spec.drive.torque_constant, spec.drive.resistance
            row += [f"{-drop * constant / resistance:+.2f}", f"{-drop / constant:+.2f}"]
        rows.append(row)
    header = ["condition", "lowest motor", "drop [V]", "stall torque and no-load speed"]
    summary.table(header + (["stall torque [N·m]", "no-load speed [rad/s]"] if spec.drive else []), rows)
