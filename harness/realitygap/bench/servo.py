"""`realitygap bench servo`: what a servo can do, from load sweeps, static friction and recordings (thesis, 4.3)."""

from pathlib import Path

import numpy as np
import pandas as pd

from realitygap.bench import servo_figures
from realitygap.bench.load_sweep import drive_constants, lines, new_against_used, read_sweep
from realitygap.bench.recordings import identify
from realitygap.bench.servo_file import MotorType, ServoBench, load_servo_bench
from realitygap.bench.static_friction import StaticFriction, check_stated, read_friction
from realitygap.bench.summary import Summary
from realitygap.bench.torque_speed import TorqueSpeedLine
from realitygap.files.errors import InputError

Lines = dict[str, dict[float, TorqueSpeedLine]]


def run(bench: Path, out: Path) -> Summary:
    """Evaluate a servo bench file and write its numbers, servo text and figures into a folder.

    Raises:
        InputError: one sentence on what cannot be used.
    """
    spec = load_servo_bench(bench)
    summary = Summary()
    friction = read_friction(bench, spec.static_friction) if spec.static_friction else {}
    if spec.torque_speed is not None:
        _torque_speed(bench, spec, friction, summary, out)
    if friction:
        _friction(spec, friction, summary)
    if spec.recordings is not None:
        identify(bench, spec.recordings, summary, out)
    summary.write(out / "summary.txt", "\n".join(summary.lines) + "\n")
    return summary


def _torque_speed(
    path: Path, spec: ServoBench, friction: dict[str, StaticFriction], summary: Summary, out: Path
) -> None:
    sweep = read_sweep(path, spec)
    fits: Lines = {}
    for kind, supply, line in lines(path, sweep, spec.regression):
        fits.setdefault(kind, {})[supply] = line
    types = {t.name: t for t in spec.types}
    for name in types:
        if name not in fits:
            raise InputError(f"{path}: types: {name} was not measured; found {', '.join(fits)}")
    response, regressor = spec.regression.split("_on_")
    summary.section(f"Torque and speed ({response} regressed on {regressor}, 95 % intervals)")
    summary.table(
        ["motor", "supply", "max torque", "stall torque [N·m]", "max speed", "no-load speed [rad/s]", "R²", "points"],
        [
            [
                *(kind, f"{supply:.1f} V", f"{x.max_torque:.2f}", x.stall_torque.text()),
                *(f"{x.max_speed:.2f}", x.no_load_speed.text(), f"{x.r_squared:.3f}", str(x.points)),
            ]
            for kind, by_supply in fits.items()
            for supply, x in by_supply.items()
        ],
    )
    _straightness(fits, summary)
    _datasheet(types, fits, summary)
    _condition(spec, sweep, summary)
    _servo_text(path, spec, sweep, fits, friction, summary, out)
    summary.files += servo_figures.torque_speed(sweep, fits, types, out)


def _straightness(fits: Lines, summary: Summary) -> None:
    """Where the straight line does not hold, and by how much."""
    every = [x for by_supply in fits.values() for x in by_supply.values()]
    torque = float(np.mean([x.max_torque - x.stall_torque.value for x in every]))
    speed = float(np.mean([x.max_speed - x.no_load_speed.value for x in every]))
    summary.lines.append(
        f"On average the maximum torque lies {torque:+.2f} N·m from the fitted stall torque and the maximum speed "
        f"{speed:+.2f} rad/s from the fitted no-load speed."
    )
    for kind, by_supply in fits.items():
        for supply, x in by_supply.items():
            found = []
            if x.max_torque > x.stall_torque.high:
                found.append(
                    f"the straight line does not hold, the maximum torque lies "
                    f"{x.max_torque - x.stall_torque.value:.2f} N·m above the fitted stall torque, beyond its interval"
                )
            if x.curvature_p < 0.05:
                found.append(f"the points bend (square term, p = {x.curvature_p:.2g})")
            if x.max_speed > x.no_load_speed.high and x.torque_at_max_speed < 0:
                found.append(
                    f"the maximum speed is no no-load speed, the load drove the servo ({x.torque_at_max_speed:.2f} N·m)"
                )
            if not x.stall_torque.low <= x.other_stall_torque <= x.stall_torque.high:
                found.append(
                    f"regressed the other way round it is {x.other_stall_torque:.2f} N·m and "
                    f"{x.other_no_load_speed:.2f} rad/s"
                )
            if found:
                summary.lines.append(f"WARNING: {kind} at {supply:.1f} V: {'; '.join(found)}.")


def _datasheet(types: dict[str, MotorType], fits: Lines, summary: Summary) -> None:
    rows, words = [], []
    for name, kind in types.items():
        if kind.datasheet is None:
            continue
        sheet = kind.datasheet
        line = fits[name].get(sheet.supply)
        if line is None:
            words.append(f"{name}: the data sheet's {sheet.supply:.1f} V was not measured; nothing to compare.")
            continue
        stall, speed = line.stall_torque.value, line.no_load_speed.value
        rows.append(
            [
                *(f"{name} at {sheet.supply:.1f} V", f"{stall:.2f}", f"{speed:.2f}"),
                *(f"{sheet.stall_torque:.1f}", f"{sheet.no_load_speed:.2f}"),
                *(f"{stall / sheet.stall_torque - 1:+.0%}", f"{speed / sheet.no_load_speed - 1:+.0%}"),
            ]
        )
        torque_word = "less" if stall < sheet.stall_torque else "more"
        speed_word = "slower" if speed < sheet.no_load_speed else "faster"
        words.append(
            f"{name}: {abs(stall / sheet.stall_torque - 1):.0%} {torque_word} stall torque than the data sheet claims, "
            f"{abs(speed / sheet.no_load_speed - 1):.0%} {speed_word} without load."
        )
    if rows or words:
        summary.section("Experiment against data sheet (stall torque [N·m], no-load speed [rad/s])")
        header = ["motor", "stall torque", "no-load speed", "sheet: stall torque", "no-load speed", "torque", "speed"]
        summary.table(header, rows)
        summary.lines += words


def _condition(spec: ServoBench, sweep: pd.DataFrame, summary: Summary) -> None:
    rows = []
    for kind, motors in sweep.groupby("type"):
        found = new_against_used(motors, spec.regression)
        if found is None:
            continue
        difference, p, excess = found
        each = ", ".join(f"{m} {v:+.2f}" for m, v in excess.items())
        if np.isnan(p):
            verdict = "one motor of each says nothing about its kind"
        elif p < 0.05:
            verdict = f"new and used motors differ (p = {p:.2g}), one line for both describes neither"
        else:
            verdict = f"no difference seen (p = {p:.2g})"
        rows.append(f"{kind}: new less used {difference.text()} N·m: {verdict}; each from the mean: {each}.")
    if rows:
        summary.section("New against used motors (stall torque, t-test over motors)")
        summary.lines += rows


def _friction(spec: ServoBench, friction: dict[str, StaticFriction], summary: Summary) -> None:
    summary.section("Static friction [N·m]")
    stated = {t.name: t.stated_friction for t in spec.types}
    for kind, found in friction.items():
        rows = [[motor, f"{value:.2f}"] for motor, value in found.motors.items()]
        summary.table([kind, "mean"], [*rows, ["all", f"{found.overall.value:.3f}"]])
        summary.lines.append(f"95 % interval of the mean {found.overall.text(3)}, spread {found.spread:.3f} N·m.")
        claim = stated.get(kind)
        wrong = check_stated(kind, found, claim) if claim is not None else None
        if wrong:
            summary.lines.append(f"WARNING: {wrong}")


def _servo_text(
    path: Path,
    spec: ServoBench,
    sweep: pd.DataFrame,
    fits: Lines,
    friction: dict[str, StaticFriction],
    summary: Summary,
    out: Path,
) -> None:
    """Numbers for a URDF, and a dc servo with the supply as parameter, as text for a scenario."""
    known = {t.name: t for t in spec.types}
    urdf, servos = [], ["servos:"]
    summary.section("For a URDF and for a scenario")
    for kind, by_supply in fits.items():
        motor = known.get(kind) or MotorType(name=kind)
        supply = spec.nominal_supply or sorted(by_supply)[len(by_supply) // 2]
        if supply not in by_supply:
            found = ", ".join(f"{s:g} V" for s in by_supply)
            raise InputError(f"{path}: nominal_supply: {kind} was not measured at {supply:g} V, but at {found}")
        line = by_supply[supply]
        dry = friction[kind].overall.value if kind in friction else 0.0
        rows = sweep[sweep["type"] == kind]
        speed, torque, volts = (rows[c].to_numpy(float) for c in ("speed", "torque", "supply"))
        constant, resistance = drive_constants(speed, torque, volts, dry)
        urdf.append(
            f"<!-- {kind} at {supply:g} V: the largest torque and speed that were measured -->\n"
            f'<limit effort="{line.max_torque:.4g}" velocity="{line.max_speed:.4g}"/>\n<dynamics friction="{dry:.3g}"/>'
        )
        servos += [
            f"  - name: {kind.replace(' ', '_')}",
            f"    joints: [{', '.join(repr(j) for j in motor.joints)}]",
            "    kind: dc",
            "    # gain: to be filled in, duty per rad" if motor.gain is None else f"    gain: {motor.gain:g}",
            f"    supply: {supply:g}",
            f"    torque_constant: {constant.value:.4g}  # [{constant.low:.4g}, {constant.high:.4g}] N·m/A",
            f"    resistance: {resistance.value:.4g}  # [{resistance.low:.4g}, {resistance.high:.4g}] Ω",
            f"    friction: {{coulomb: {dry:.3g}}}",
        ]
    text = "\n".join(servos) + "\n"
    summary.lines += ["\n".join(urdf), "", text.rstrip()]
    summary.lines.append(
        "The constants hold for every supply measured. A load sweep cannot tell viscous friction from back-EMF; static "
        "friction stands for Coulomb friction, of which it is the upper bound; rotor inertia needs fast motion."
    )
    summary.write(out / "limits.xml", "\n".join(urdf) + "\n")
    summary.write(out / "servos.yaml", text)
