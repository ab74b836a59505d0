"""The page of the sweep, from its table alone: `python scenarios/wolfgang_standing/page.py`."""

from collections import Counter
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd

mpl.use("svg")
import matplotlib.pyplot as plt
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

OUT = Path(__file__).parents[2] / "results" / "reference"
OUTCOMES = {"stands": "#0072b2", "shakes": "#f0e442", "falls": "#d55e00", "explodes": "#5a2a00"}
NAMES = {"mujoco": "MuJoCo", "dart": "DART", "drake": "Drake", "pybullet": "PyBullet", "ode": "ODE"}
SHORT = {
    "explicit damping": "d",
    "explicit stiffness": "p",
    "missing rotor inertia": "r",
    "effort limit": "e",
    "not found": "?",
}


def solver(row: pd.Series) -> str:
    """The engine, with its iterations where they were set."""
    name = NAMES.get(row.engine, row.engine)
    return name if pd.isna(row.solver_iterations) else f"{name}, {row.solver_iterations:g} it."


def draw(table: pd.DataFrame, path: Path) -> None:
    """One heat map per engine (across) and machine (down): position gain against derivative gain."""
    solvers = list(dict.fromkeys(table.solver))
    machines = list(dict.fromkeys(zip(table.rotor, table.damping, strict=True)))
    mpl.rcParams.update({"svg.hashsalt": "pid", "font.size": 8})
    size = (2.0 + 1.6 * len(solvers), 1.3 + 1.35 * len(machines))
    figure, axes = plt.subplots(
        len(machines), len(solvers), figsize=size, layout="constrained", sharex=True, sharey=True, squeeze=False
    )
    for (rotor, damping), line in zip(machines, axes, strict=True):
        for name, axis in zip(solvers, line, strict=True):
            rows = table[(table.solver == name) & (table.rotor == rotor) & (table.damping == damping)]
            gains = list(dict.fromkeys(table.kp))
            cells = rows.pivot(index="kp", columns="kd", values="outcome").loc[gains]
            codes = cells.apply(lambda column: column.map(list(OUTCOMES).index))
            axis.imshow(codes, cmap=ListedColormap(list(OUTCOMES.values())), vmin=-0.5, vmax=3.5, aspect="auto")
            why = rows.pivot(index="kp", columns="kd", values="why").loc[gains].fillna("")
            for (i, j), reasons in np.ndenumerate(why.to_numpy()):
                marks = "".join(SHORT.get(r, "i") for r in reasons.split("; ") if r)
                dark = cells.iloc[i, j] in ("falls", "explodes", "stands")
                axis.text(j, i, marks, ha="center", va="center", color="white" if dark else "black")
            axis.set_xticks(range(codes.shape[1]), [f"{kd:g}" for kd in codes.columns])
            axis.set_yticks(range(codes.shape[0]), codes.index)
            if axis in axes[0]:
                axis.set_title(name)
        line[0].set_ylabel(f"{'rotor' if rotor else 'no rotor'},\ndamping: {damping}")
    figure.supxlabel("derivative gain [N·m·s/rad], explicit")
    figure.legend(handles=[Patch(color=c, label=o) for o, c in OUTCOMES.items()], loc="outside upper center", ncols=4)
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def share(rows: pd.DataFrame) -> str:
    return f"{(rows.outcome == 'stands').sum()} of {len(rows)}"


def sentences(table: pd.DataFrame) -> list[str]:
    """What the numbers say."""
    real = table[table.kp.str.startswith("P ")]
    as_simulated = table[table.kd.isin([0.1, 0.4, 1.0])]
    settled = table[table.solver_iterations.isna()]
    ranges = ", ".join(
        f"{kp} is {rows.kp_mx64.iloc[0]:.0f} N·m/rad (MX-64) to {rows.kp_mx106.iloc[0]:.0f} N·m/rad (MX-106)"
        for kp, rows in real.groupby("kp", sort=False)
    )
    failed_real = as_simulated[as_simulated.kp.str.startswith("P ") & (as_simulated.outcome != "stands")]
    where = ", ".join(dict.fromkeys(failed_real.solver))
    out = [
        f"**Units.** At 15 V {ranges}: about the simulation's 50 N·m/rad. With these gains "
        f"and the simulation's derivative gains (0.1 to 1 N·m·s/rad) the robot stands in "
        f"{share(as_simulated[as_simulated.kp.str.startswith('P ')])} cells"
        f"{f' (not in: {where})' if where else ''}; with the number 850 taken for N·m/rad in "
        f"{share(as_simulated[as_simulated.kp.str.startswith('850')])}.",
    ]
    for rotor in (False, True):
        rows = table[table.rotor == rotor]
        over = rows[rows.damping_number > 2]
        under = rows[rows.stability_number <= 2]
        out.append(
            f"**{'With' if rotor else 'Without'} rotor inertia** it stands in {share(rows)}: in {share(under)} where "
            f"the step is stable for a free robot, in {share(over)} where explicit damping exceeds λmax(h·Kd·M⁻¹) = 2."
        )
    free = settled[settled.damping == "none"].drop_duplicates(["rotor", "kd"])
    limits = {rotor: (2 * rows.kd / rows.damping_number).iloc[0] for rotor, rows in free.groupby("rotor")}
    out.append(
        f"**The limit.** λmax is 2 at a derivative gain of {limits[False]:.2g} N·m·s/rad without rotor inertia and "
        f"of {limits[True]:.2g} with it, at 1 ms and with nothing else that damps: {limits[True] / limits[False]:.0f} "
        f"times as much. The number of a servo's D, up to 2800, taken for N·m·s/rad would exceed it "
        f"{2800 / limits[False]:.0f} and {2800 / limits[True]:.0f} times. A foot that is pressed on the ground "
        "cannot turn freely, so that a robot may stand beyond the limit until something lifts a foot."
    )
    damped = {d: share(table[(table.damping == d) & ~table.rotor]) for d in dict.fromkeys(table.damping)}
    out.append(
        "**Back-EMF.** Without rotor inertia it stands in "
        + ", ".join(
            f"{n} cells with {'no' if d == 'none' else 'the'} {'' if d == 'none' else d + ' '}damping"
            for d, n in damped.items()
        )
        + ". (The URDF's own damping, 1 N·m·s/rad, lies between the back-EMF of MX-64, 0.67, and MX-106, 1.62.)"
    )
    failed = table[table.outcome != "stands"]
    reasons = Counter(r for why in failed.why.dropna() for r in why.split("; "))
    out.append(
        f"**Why it fails** ({len(failed)} cells; a cell can have several reasons): "
        + ", ".join(f"{reason} {n}" for reason, n in reasons.most_common())
        + ". Explicit damping and stiffness are read off the eigenvalues; rotor inertia, effort limit and iterations "
        "were each given or taken away in a simulation of their own, after which the robot stood."
    )
    per = ", ".join(f"{name} {share(rows)}" for name, rows in table.groupby("solver", sort=False))
    out.append(f"**Engines.** It stands in: {per}.")
    return out


def write_page(out: Path) -> None:
    """Write pid_sweep.md and pid_sweep.svg from pid_sweep.csv."""
    table = pd.read_csv(out / "pid_sweep.csv", keep_default_na=False, na_values=[""])
    table["solver"] = table.apply(solver, axis=1)
    draw(table, out / "pid_sweep.svg")
    failed = table[table.outcome != "stands"]
    worst = failed.groupby(["rotor", "damping", "kp", "kd"], sort=False)
    lines = [
        "# Can the Wolfgang of 2019 stand with the gains of its real servos?",
        "",
        "Made by `python scenarios/wolfgang_standing/sweep.py` from `pid_sweep.csv`; every number is computed. The "
        "thesis found that its robot would not stand in simulation with the PID values of the real one, and not why. "
        "Here the joint-revised URDF is put down from 2 cm in its stance and has to be upright and calm 1 to 1.5 s "
        "later, at 1 kHz, under the law of ros_control: effort = kp·error − kd·velocity, explicit, clipped to the "
        "URDF's effort. *P* is the servo's Position P Gain: P/128 · (4096/2π)/885 duty per rad · 15 V · kt/R.",
        "",
        *(f"- {s}" for s in sentences(table)),
        "",
        "![Outcome by gains, machine and engine](pid_sweep.svg)",
        "",
        "In the cells: d explicit damping, p explicit stiffness, r missing rotor inertia, e effort limit, i too few "
        "iterations, ? none of these.",
        "",
        "Where it fails in any engine:",
        "",
        "| rotor | damping | kp | kd | λmax(h·Kd·M⁻¹) | λmax with stiffness | fails in | why |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for (rotor, damping, kp, kd), rows in worst:
        why = ", ".join(dict.fromkeys(r for w in rows.why.dropna() for r in w.split("; ")))
        first = rows.iloc[0]
        where = ", ".join(f"{r.solver} ({r.outcome})" for r in rows.itertuples())
        lines.append(
            f"| {'yes' if rotor else 'no'} | {damping} | {kp} | {kd:g} | {first.damping_number:.2f} | "
            f"{first.stability_number:.2f} | {where} | {why} |"
        )
    (out / "pid_sweep.md").write_text("\n".join([*lines, ""]), encoding="utf-8")


if __name__ == "__main__":
    write_page(OUT)
