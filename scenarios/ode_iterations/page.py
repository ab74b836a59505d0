"""The page of the study, from its table alone: `python scenarios/ode_iterations/page.py`."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd

mpl.use("svg")
import matplotlib.pyplot as plt

OUT = Path(__file__).parents[2] / "results" / "reference"
NEAR = 1.1
"""A gap up to this many times that of the exact solution counts as the same."""
CLOSE = 0.25
"""Distance from the finest simulation [°] that counts as converged."""
GAZEBO = (50, 1000)
"""Iterations and rate [Hz] that Gazebo classic comes with."""
COLUMNS = {"cheering": "distance_deg", "kicks": "moving_gap_deg"}
TITLES = {
    "cheering": "Wolfgang, cheering: rms distance\nfrom the finest simulation [°]",
    "kicks": "Sigmaban, kicks: mean gap to the\nreal robot, moving joints [°]",
}


def grid(table: pd.DataFrame, motion: str) -> pd.DataFrame:
    """Iterations (infinite: solved to the end) down, step rate across."""
    rows = table[table.motion == motion].fillna({"solver_iterations": np.inf})
    return rows.pivot(index="solver_iterations", columns="step_rate", values=COLUMNS[motion])


def draw(table: pd.DataFrame, path: Path) -> None:
    """Both motions as heat maps with their numbers."""
    mpl.rcParams.update({"svg.hashsalt": "ode", "font.size": 9})
    figure, axes = plt.subplots(1, 2, figsize=(8.5, 3.9), layout="constrained")
    for axis, motion in zip(axes, COLUMNS, strict=True):
        values = grid(table, motion)
        shown = np.log10(np.clip(values.to_numpy(), 0.01, 100))
        axis.imshow(shown, cmap="cividis_r", aspect="auto")
        middle = np.nanmean([shown.min(), shown.max()])
        for (i, j), value in np.ndenumerate(values.to_numpy()):
            text = f"{value:.2g}" if np.isfinite(value) else "×"
            axis.text(j, i, text, ha="center", va="center", color="white" if shown[i, j] > middle else "black")
        axis.set_xticks(range(values.shape[1]), [f"{rate:g}" for rate in values.columns])
        axis.set_yticks(range(values.shape[0]), [words(n) for n in values.index])
        axis.set(xlabel="step rate [Hz]", ylabel="iterations of quickStep", title=TITLES[motion])
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def words(iterations: float) -> str:
    return f"{iterations:g}" if np.isfinite(iterations) else "exact"


def enough(values: pd.DataFrame, limit: "pd.Series[float]") -> list[str]:
    """Per step rate, the fewest iterations from which on the limit is kept."""
    out = []
    for rate in values.columns:
        kept = (values[rate] <= limit[rate])[::-1].cummin()[::-1]
        first = kept.index[kept].min() if kept.any() else None
        found = "never" if first is None else "only the exact solution" if np.isinf(first) else f"{first:g}"
        out.append(f"{rate:g} Hz: {found}")
    return out


def cheapest(values: pd.DataFrame) -> list[str]:
    """For budgets of sweeps per second, the best split into rate and iterations."""
    cells = values.drop(index=np.inf).stack().rename("value").reset_index()
    cells["sweeps"] = cells.solver_iterations * cells.step_rate
    out = []
    for budget in (1e4, 5e4, 1e5, 2e5):
        best = cells[cells.sweeps <= budget].nsmallest(1, "value").iloc[0]
        out.append(f"| {budget:,.0f} | {best.step_rate:g} Hz × {best.solver_iterations:g} | {best.value:.2f}° |")
    return out


def sentences(table: pd.DataFrame) -> list[str]:
    """What the numbers say."""
    cheering, kicks = grid(table, "cheering"), grid(table, "kicks")
    n, rate = GAZEBO
    exact = kicks.loc[np.inf]
    floor = cheering.loc[np.inf]
    worst = kicks.loc[n, rate] / exact[rate]
    spread = exact.max() - exact.min()
    sweeps_matter = kicks.drop(index=np.inf)[rate]
    return [
        f"**Iterations.** With Gazebo's {n} iterations at {rate} Hz the kicks are {kicks.loc[n, rate]:.2f}° from the "
        f"real robot, {worst:.1f} times as far as the same model solved exactly ({exact[rate]:.2f}°). From "
        f"{sweeps_matter.index[0]:g} to {sweeps_matter.index[-1]:g} iterations the gap goes from "
        f"{sweeps_matter.iloc[0]:.2f}° to {sweeps_matter.iloc[-1]:.2f}°.",
        f"**Step rate.** Solved exactly, the kicks are {exact.min():.2f}° to {exact.max():.2f}° from the real robot at "
        f"{exact.index[0]:g} to {exact.index[-1]:g} Hz: a spread of {spread:.2f}°, "
        + (
            "less than what the iterations do."
            if spread < sweeps_matter.iloc[0] - sweeps_matter.iloc[-1]
            else "more than what the iterations do."
        ),
        f"**Enough for reality** (gap of the kicks at most {NEAR:g} times that of the exact solution at that rate): "
        + "; ".join(enough(kicks, NEAR * exact))
        + ".",
        f"**Converged** (cheering within {CLOSE}° of the exact solution at {cheering.columns[-1]:g} Hz; that "
        f"at {rate} Hz is {floor[rate]:.3f}° off): "
        + "; ".join(enough(cheering, pd.Series(CLOSE, cheering.columns)))
        + ".",
    ]


def write_page(out: Path) -> None:
    """Write ode_iterations.md and ode_iterations.svg from ode_iterations.csv."""
    table = pd.read_csv(out / "ode_iterations.csv")
    draw(table, out / "ode_iterations.svg")
    rest = table[table.motion == "cheering"].fillna({"solver_iterations": np.inf})
    rest = rest.pivot(index="solver_iterations", columns="step_rate", values="rest_speed_deg_s")
    lines = [
        "# Which step rate and how many solver iterations does ODE need?",
        "",
        "Made by `python scenarios/ode_iterations/study.py` from `ode_iterations.csv`; every number is computed. The "
        "thesis simulated with ODE's quickStep and left this question open. *exact* is `dWorldStep`, which solves the "
        "same equations by pivoting. Cheering was never recorded: it shows convergence only. The kicks are those of "
        "the bundled Sigmaban scenario, P 32 and P 24, on the real robot's 18 joints without the head.",
        "",
        *(f"- {s}" for s in sentences(table)),
        "",
        "![Gaps by iterations and step rate](ode_iterations.svg)",
        "",
        "What is the best use of a number of sweeps per second? (Kicks, moving joints.)",
        "",
        "| sweeps per second, at most | best | gap |",
        "|---|---|---|",
        *cheapest(grid(table, "kicks")),
        "",
        "Speed of the joints while the robot stands at rest after cheering, rms [°/s]:",
        "",
        "| iterations | " + " | ".join(f"{rate:g} Hz" for rate in rest.columns) + " |",
        "|---" * (rest.shape[1] + 1) + "|",
        *(f"| {words(n)} | " + " | ".join(f"{v:.2g}" for v in row) + " |" for n, row in rest.iterrows()),
        "",
    ]
    (out / "ode_iterations.md").write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    write_page(OUT)
