"""The servo bench from recordings of a motor that moves known arms: what the drive fits say, in words and a figure."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from realitygap.bench.drive_fit import CurrentFit, fit_current, fit_duty, fit_rotor, solve_drive, stall_current
from realitygap.bench.estimate import Array, Estimate
from realitygap.bench.load_sweep import FEWEST_LOADS
from realitygap.bench.motion import BenchMotion, Pendulum, read_arms, read_motions
from realitygap.bench.servo_file import ArmBag, ArmRecordings
from realitygap.bench.summary import Summary
from realitygap.files.errors import InputError
from realitygap.scenario.file import resolve_path

SINE_WINDOWS = (0.15, 0.08, 0.25)
CHIRP_WINDOWS = (0.06, 0.03, 0.10)
"""Smoothing windows [s]: the first is used, the others show how much the choice matters."""
SLOWEST = (0.1, 0.4)
"""The same for the share of the largest speed below which samples are left out."""


def identify(path: Path, spec: ArmRecordings, summary: Summary, out: Path) -> None:
    """Everything that the recordings allow, added to the summary.

    Raises:
        InputError: for recordings that cannot be read, or sines under fewer than three loads.
    """
    arms = read_arms(path, spec.arms)
    current: CurrentFit | None = None
    if spec.chirps and not spec.sines:
        raise InputError(f"{path}: recordings.chirps: need sines as well, for the torque per ampere")
    if spec.sines:
        loads = len({bag.arm for bag in spec.sines})
        if loads < FEWEST_LOADS:
            raise InputError(f"{path}: recordings.sines: found {loads} arms, expected at least {FEWEST_LOADS} loads")
        sines = [_motions(path, spec, arms, b, f"sines[{i}]", SINE_WINDOWS) for i, b in enumerate(spec.sines)]
        chirps = [_motions(path, spec, arms, b, f"chirps[{i}]", CHIRP_WINDOWS) for i, b in enumerate(spec.chirps)]
        # a smoothing window holds dozens of samples: every fifth says the same as all of them
        thin = [[_without_start(m).rows(slice(None, None, 5)) for m in one] for one in sines]
        choices = np.array(
            [
                solve_drive([one[k] for one in thin], [one[k] for one in chirps], share)
                for k in range(len(SINE_WINDOWS))
                for share in SLOWEST
            ]
        )
        current = fit_current([one[0] for one in thin], float(choices[0, 2]))
        _say_current(current, choices, bool(chirps), summary)
        summary.files.append(_hysteresis([one[0] for one in sines], current, out))
        if chirps:
            _say_rotor([one[0] for one in chirps], current.torque_constant, choices[:, 2], summary)
    if spec.horizontal:
        flat = []
        for i, text in enumerate(spec.horizontal):
            file = resolve_path(path, text, f"recordings.horizontal[{i}]")
            flat += read_motions(file, spec, None, (0.1,), duty=True)
        _say_duty(flat, current, summary)


def _motions(
    path: Path, spec: ArmRecordings, arms: dict[str, Pendulum], bag: ArmBag, key: str, windows: tuple[float, ...]
) -> list[BenchMotion]:
    if bag.arm not in arms:
        raise InputError(f"{path}: recordings.{key}.arm: {bag.arm} is not an arm; found {', '.join(arms) or 'none'}")
    file = resolve_path(path, bag.path, f"recordings.{key}.path")
    return read_motions(file, spec, arms[bag.arm], windows)


def _without_start(motion: BenchMotion) -> BenchMotion:
    """Without the first second, in which the arm starts from rest, and the last tenth, where smoothing is one-sided."""
    return motion.rows((motion.time > motion.time[0] + 1.0) & (motion.time < motion.time[-1] - 0.1))


def _span(values: Array, digits: int) -> str:
    return f"{values.min():.{digits}f} to {values.max():.{digits}f} by the choice of smoothing and of the slowest speed"


def _say_current(fit: CurrentFit, choices: Array, rotor: bool, summary: Summary) -> None:
    constant = fit.torque_constant
    summary.section("Slow motion under several loads (95 % intervals from leaving out one load)")
    summary.lines += [
        f"torque per ampere          {constant.text(3)} N·m/A (reported current); {_span(choices[:, 0], 2)}",
        f"load-dependent friction    {fit.load_dependent.text(3)} of the transmitted torque; {_span(choices[:, 1], 2)}",
        f"hysteresis at no load      {fit.coulomb.text(3)} N·m to each side",
        f"tilt of the bench          {fit.tilt.scaled(180 / np.pi).text(1)}°; current offset {fit.offset.text(3)} A",
        f"residual                   {fit.residual:.3f} A; with Coulomb friction alone {fit.residual_without:.3f} A",
    ]
    summary.table(
        ["each on its own", "N·m/A", "half hysteresis [N·m]"],
        [[name, f"{c:.3f}", f"{h:+.3f}"] for name, (c, h) in fit.by_load.items()],
    )
    if not rotor:
        summary.lines.append(
            "WARNING: without chirps the rotor inertia is unknown; the torque per ampere is too large."
        )
    if fit.load_dependent.low > 0:
        summary.lines.append("The hysteresis grows with the load: load-dependent friction is there.")
    if fit.coulomb.high < 0:
        summary.lines.append(
            "WARNING: the hysteresis at no load is negative, which no friction makes: the reported current falls short "
            f"by {-fit.coulomb.value / constant.value:.2f} A or more in the direction of motion. Coulomb friction "
            "cannot be read from this current; its growth with the load can."
        )
    summary.lines += [
        "",
        f'effects: [{{effect: load_dependent_friction, target: "*", coefficient: {fit.load_dependent.value:.3g}}}]',
    ]


def _say_rotor(chirps: list[BenchMotion], constant: Estimate, choices: Array, summary: Summary) -> None:
    summary.section("Fast motion: rotor inertia at the output shaft, fitted together with the slow motion")
    found = [(m.name, *fit_rotor(m, constant.value)) for m in chirps]
    summary.table(
        ["recording", "armature [kg·m²]", "unexplained torque"],
        [[name, armature.text(4), f"{rest:.0%}"] for name, armature, rest in found],
    )
    mean = float(np.mean([a.value for _, a, _ in found]))
    low, high = min(a.low for _, a, _ in found), max(a.high for _, a, _ in found)
    summary.lines.append(
        f"armature: {Estimate(mean, low, high).text(4)} kg·m² (all of the recordings' intervals); {_span(choices, 3)}"
    )
    for name, _, rest in found:
        if rest > 0.25:
            summary.lines.append(
                f"WARNING: {name}: {rest:.0%} of the motor torque (rms) is not explained by a rigid arm with friction."
            )


def _say_duty(motions: list[BenchMotion], current: CurrentFit | None, summary: Summary) -> None:
    summary.section("Given duty, no gravity (the supply was not recorded: speeds are per duty, not per volt)")
    top = max(float(np.abs(m.velocity).max()) for m in motions)
    fast = [m for m in motions if np.abs(m.velocity).max() > top / 4]
    fits = {m.name: fit_duty([m]) for m in fast}
    fits["together"] = both = fit_duty(fast)
    summary.table(
        ["recording", "no-load speed [rad/s per duty]", "friction [duty]", "restoring [duty per rad]"],
        [[n, f.no_load_speed.text(), f.coulomb.text(4), f.restoring.text(4)] for n, f in fits.items()],
    )
    speeds = [f.no_load_speed for n, f in fits.items() if n != "together"]
    if max(s.low for s in speeds) > min(s.high for s in speeds):
        summary.lines.append(
            f"WARNING: the recordings differ by more than their intervals, {min(s.value for s in speeds):.2f} to "
            f"{max(s.value for s in speeds):.2f}: more than noise is at work, perhaps the unrecorded supply. "
            "The interval of all together is too narrow."
        )
    if both.restoring.low > 0:
        summary.lines.append("Something pulls the lever back to 0: a cable, or a bench that is not level.")
    for m in motions:
        if not any(m is other for other in fast):
            summary.lines.append(f"{m.name} is too slow to tell friction from back-EMF and is left out here.")
    full = both.no_load_speed.value * (1 - both.coulomb.value)
    summary.lines.append(f"no-load speed at full duty, friction included: {full:.2f} rad/s")
    stall = stall_current(motions)
    if stall is not None:
        summary.lines.append(f"held by a stop: {stall.text()} A per duty")
        if current is not None:
            constant = current.torque_constant.value
            summary.lines.append(
                f"so stall torque is {stall.value * constant:.2f} N·m per duty, and the friction seen in the duty "
                f"{both.coulomb.value * stall.value * constant:.2f} N·m (with the bridge's voltage drop: at most that)"
            )


def _hysteresis(motions: list[BenchMotion], fit: CurrentFit, out: Path) -> Path:
    """Current over angle under every load, rising and falling, with the load's share."""
    out.mkdir(parents=True, exist_ok=True)
    figure = Figure(figsize=(3.2 * len(motions), 3.4), layout="constrained")
    panels = figure.subplots(1, len(motions), squeeze=False, sharey=True)[0]
    for axes, motion in zip(panels, motions, strict=True):
        m = _without_start(motion)
        assert m.pendulum is not None
        for rising, color, label in ((True, "tab:red", "rising"), (False, "tab:blue", "falling")):
            way = (m.velocity > 0) == rising
            axes.plot(np.degrees(m.position[way]), m.current[way], ".", ms=1, color=color, label=label)
        angle = np.linspace(m.position.min(), m.position.max(), 50)
        load = m.pendulum.gravity_torque * np.sin(angle + fit.tilt.value) / fit.torque_constant.value
        axes.plot(np.degrees(angle), load + fit.offset.value, "k", lw=1, label="load alone")
        axes.set_title(m.name)
        axes.set_xlabel("angle [°]")
    panels[0].set_ylabel("reported current [A]")
    panels[0].legend(fontsize=7, markerscale=6)
    file = out / "hysteresis.png"
    figure.savefig(file, dpi=110)
    return file
