"""Figures of the servo bench, as 4.6 and 4.7 in the thesis: speed across, torque upwards."""

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from realitygap.bench.servo_file import DataSheet, MotorType
from realitygap.bench.torque_speed import TorqueSpeedLine, fit_line


def torque_speed(
    sweep: pd.DataFrame, fits: dict[str, dict[float, TorqueSpeedLine]], types: dict[str, MotorType], out: Path
) -> list[Path]:
    """One figure per motor type, a panel per supply voltage; and new against used motors where both were measured."""
    out.mkdir(parents=True, exist_ok=True)
    files = []
    for kind, by_supply in fits.items():
        sheet = types[kind].datasheet if kind in types else None
        rows = sweep[sweep["type"] == kind]
        figure = Figure(figsize=(4.2 * len(by_supply), 3.8), layout="constrained")
        panels = figure.subplots(1, len(by_supply), squeeze=False, sharex=True, sharey=True)[0]
        for axes, (supply, line) in zip(panels, by_supply.items(), strict=True):
            chosen = rows[rows["supply"] == supply]
            _panel(axes, chosen, line, sheet if sheet is not None and sheet.supply == supply else None)
            axes.set_title(f"{kind}, {supply:g} V")
        files.append(_save(figure, panels[0], out / f"torque_speed_{kind.replace(' ', '_')}.png"))

        supply = sheet.supply if sheet is not None and sheet.supply in by_supply else list(by_supply)[-1]
        chosen = rows[rows["supply"] == supply]
        groups = {c: g for c, g in chosen.groupby("condition") if g["load"].nunique() > 2}
        if len(groups) == 2:
            figure = Figure(figsize=(8.4, 3.8), layout="constrained")
            panels = figure.subplots(1, 2, squeeze=False, sharex=True, sharey=True)[0]
            for axes, condition in zip(panels, ("used", "new"), strict=True):
                group = groups[condition]
                line = fit_line(group["speed"].to_numpy(float), group["torque"].to_numpy(float))
                _panel(axes, group, line, sheet if sheet is not None and sheet.supply == supply else None)
                axes.set_title(f"{kind}, {condition} motors, {supply:g} V")
            files.append(_save(figure, panels[0], out / f"new_and_used_{kind.replace(' ', '_')}.png"))
    return files


def _panel(axes: Axes, rows: pd.DataFrame, line: TorqueSpeedLine, sheet: DataSheet | None) -> None:
    for (motor, group), marker in zip(rows.groupby("motor"), "osD^vP*X" * 8, strict=False):
        axes.plot(group["speed"], group["torque"], marker, ms=4, color="tab:blue", label=str(motor), alpha=0.8)
    stall, speed = line.stall_torque.value, line.no_load_speed.value
    ends = np.array([0.0, max(speed, line.max_speed)])
    axes.plot(ends, stall * (1 - ends / speed), color="tab:green", label=f"line: {stall:.2f} N·m, {speed:.2f} rad/s")
    if sheet is not None:
        axes.plot([0, sheet.no_load_speed], [sheet.stall_torque, 0], color="black", label="data sheet")
    axes.axhline(0, color="0.7", lw=0.8, zorder=0)
    axes.set_xlabel("speed [rad/s]")
    axes.legend(fontsize=7)


def _save(figure: Figure, first: Axes, file: Path) -> Path:
    first.set_ylabel("torque [N·m]")
    figure.savefig(file, dpi=110)
    return file
