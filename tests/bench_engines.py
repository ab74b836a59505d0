"""Which engine? What each has natively, what a step costs, and how far it is from closed forms and from real robots.

Costs are the processor time of a `step` and a `read` under a PD law, the least of several batches, so that others on
the machine show least. Errors against closed forms: a pendulum that is let go at 1 rad, against Jacobi's elliptic
function, and a block that slides to rest, against v²/(2 µ g). The cube is that of `results/reference/cube_ground.csv`
(`realitygap bench ground scenarios/cube_toss/bench.yaml`), and the humanoid's error is read from beside it:

    python tests/bench_sigmaban.py --only kick_p32,squat_p32 --write results/reference/engines_humanoid.csv
    python tests/bench_engines.py --write results/reference/engines.md
"""

import argparse
import platform
import time
from dataclasses import dataclass, field
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import realitygap_engines as engines
import yaml
from bench_overhead import humanoid
from realitygap.audit.machines import BLOCK_HEIGHT, block, pendulum, tree
from realitygap.page.style import engine_color, engine_label
from realitygap_engines import Ground, Physics, State
from realitygap_engines.engine import CAPABILITIES
from realitygap_engines.model.robot import Model, link_poses, lowest_point
from scipy.special import ellipj, ellipk

ROOT = Path(__file__).parents[1]
REFERENCE = ROOT / "results" / "reference"
G = 9.81
RATES = (250, 500, 1000, 2000, 4000)
SWING, SECONDS = 1.0, 4.0
FRICTION = 0.6
MARK = {"native": "●", "emulated": "○", "no": "–"}


@dataclass
class Found:
    """What was measured of one engine: cost [µs] by robot, errors by step rate."""

    cost: dict[str, float] = field(default_factory=dict)
    swing: dict[int, float] = field(default_factory=dict)
    slide: dict[int, float] = field(default_factory=dict)


def cost(name: str, model: Model, ground: Ground | None, steps: int, batches: int) -> float:
    """The least time of a step and a read [µs] while a PD law holds the joints at zero."""
    n = len(model.joints)
    position, velocity, base = np.zeros(n), np.zeros(n), np.zeros(13)
    damping, friction = np.full(n, 0.3), np.zeros(n)
    height = -lowest_point(model, link_poses(model, position)) if ground else 0.0
    least = np.inf
    with engines.load(name).open(model, Physics(1e-3, ground=ground)) as simulation:
        for _ in range(batches):
            simulation.reset(State(np.zeros(n), np.zeros(n), np.array([0.0, 0.0, height])))
            simulation.read(position, velocity, base)
            start = time.thread_time()
            for _ in range(steps):
                simulation.step(-30.0 * position, damping, friction)
                simulation.read(position, velocity, base)
            least = min(least, (time.thread_time() - start) / steps)
    return least * 1e6


def swing(name: str, rate: int) -> float:
    """Rms error [rad] of a free pendulum over 4 s.

    q = 2 asin(k sn(K - w t, k)) with k = sin(q0/2) (Landau, Lifshitz, Mechanics, section 11).
    """
    model, h = pendulum(), 1.0 / rate
    bob = model.links[1]
    inertia, torque = bob.inertia[1, 1] + bob.mass * bob.com[2] ** 2, -bob.mass * G * bob.com[2]
    steps = round(SECONDS * rate)
    t, k = h * np.arange(1, steps + 1), np.sin(SWING / 2)
    exact = 2 * np.arcsin(k * ellipj(ellipk(k**2) - np.sqrt(torque / inertia) * t, k**2)[0])
    zero, position, velocity, base, out = np.zeros(1), np.zeros(1), np.zeros(1), np.zeros(13), np.empty(steps)
    with engines.load(name).open(model, Physics(h)) as simulation:
        simulation.reset(State(np.array([SWING]), np.zeros(1)))
        for i in range(steps):
            simulation.step(zero, zero, zero)
            simulation.read(position, velocity, base)
            out[i] = position[0]
    return float(np.sqrt(np.mean((out - exact) ** 2)))


def slide(name: str, rate: int) -> float:
    """Error [m] of the way on which a block at 1 m/s comes to rest."""
    none, base, h = np.zeros(0), np.zeros(13), 1.0 / rate
    with engines.load(name).open(block(), Physics(h, ground=Ground(FRICTION))) as simulation:
        start = np.array([0.0, 0.0, BLOCK_HEIGHT])
        simulation.reset(State(none, none, start, base_linear=np.array([1.0, 0.0, 0.0])))
        for _ in range(round(0.3 * rate)):
            simulation.step(none, none, none)
        simulation.read(none, none, base)
    return float(abs(base[0] - 1 / (2 * FRICTION * G)))


def measure(names: list[str], steps: int, batches: int) -> dict[str, Found]:
    """All of it."""
    robots: dict[str, tuple[Model, Ground | None]] = {
        "pendulum": (pendulum(), None),
        "arm": (tree(False), None),
        "humanoid": (humanoid(), Ground()),
    }
    out = {name: Found() for name in names}
    for name, found in out.items():
        for robot, (model, ground) in robots.items():
            found.cost[robot] = cost(name, model, ground, steps, batches)
        for rate in RATES:
            found.swing[rate] = swing(name, rate)
            found.slide[rate] = slide(name, rate)
        print(engine_label(name), {k: round(v, 1) for k, v in found.cost.items()}, flush=True)
    return out


def real(names: list[str]) -> tuple[dict[str, float], dict[str, float]]:
    """The humanoid's mean error [rad] over all recordings, and the cube's e_q, by engine, from the references."""
    body = pd.read_csv(REFERENCE / "engines_humanoid.csv", index_col="recording").mean()
    cube = pd.read_csv(REFERENCE / "cube_ground.csv", index_col="engine")["both ways"]
    return (
        {name: float(body[name]) for name in names if name in body},
        {name: float(cube[name]) for name in names if name in cube},
    )


def front(found: dict[str, Found], error: dict[str, float]) -> list[str]:
    """The engines that no other beats in both cost and error (Pareto's front), cheapest first."""
    out: list[str] = []
    for name in sorted(error, key=lambda n: found[n].cost["humanoid"]):
        if not out or error[name] < error[out[-1]]:
            out.append(name)
    return out


def table(head: list[str], rows: list[list[str]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def page(found: dict[str, Found], picture: str) -> str:
    """The sheet."""
    names = list(found)
    body, cube = real(names)
    published_body = pd.read_csv(REFERENCE / "engines_humanoid.csv")["published M1"].mean()
    published_cube = yaml.safe_load((ROOT / "scenarios" / "cube_toss" / "bench.yaml").read_text())["published"]
    capabilities = {name: engines.load(name).capabilities() for name in names}
    native = [[what, *(MARK[capabilities[name][key].level] for name in names)] for key, what in CAPABILITIES.items()]
    costs = [[f"{robot}, µs", *(f"{found[n].cost[robot]:.1f}" for n in names)] for robot in found[names[0]].cost]
    swings = [[f"{rate} Hz", *(f"{found[n].swing[rate]:.1e}" for n in names)] for rate in RATES]
    slides = [[f"{rate} Hz", *(f"{found[n].slide[rate] * 1e3:.2f}" for n in names)] for rate in RATES]
    labels = [engine_label(name) for name in names]
    outside = [
        [f"a kick and a squat of a humanoid, rad (published {published_body:.4f})"]
        + [f"{body[n]:.4f}" if n in body else "–" for n in names],
        ["tosses of a cube, e_q", *(f"{cube[n]:.3f}" if n in cube else "–" for n in names)],
        ["published e_q", *(f"{published_cube[n]:.3f}" if n in published_cube else "–" for n in names)],
    ]
    exact = [n for n in names if capabilities[n]["forward_dynamics"].level == "native"]
    swung = [found[n].swing[1000] for n in exact]
    cheap = min(names, key=lambda n: found[n].cost["humanoid"])
    near = min(body, key=lambda n: body[n])
    versions = ", ".join(f"{engine_label(n)} {engines.load(n).version}" for n in names)
    return f"""# Which engine?

Made by `python tests/bench_engines.py --write results/reference/engines.md` with {versions}. Costs are
processor time on one core of {machine()}.

- **Free motion**: at 1000 Hz the pendulum is {min(swung):.2e} to {max(swung):.2e} rad off the closed form in the
  {len(exact)} engines whose step is forward dynamics: that is the step's error, and not the engine's.
- **Cheapest**: {engine_label(cheap)}, {found[cheap].cost["humanoid"]:.0f} µs for a step of the humanoid.
- **Real humanoid**: from {min(body.values()):.4f} ({engine_label(near)}) to {max(body.values()):.4f} rad; the published
  simulation has {published_body:.4f}.
- **No engine is both cheaper and closer** than these: {", ".join(engine_label(n) for n in front(found, body))}.

![Error against cost]({picture})

## What is native

● native, ○ emulated by this project's joint, stop and ground laws, – no. `realitygap engines` says how.

{table(["", *labels], native)}

## Cost of a step with effort in and state out

A pendulum, an arm of six joints and a humanoid of twenty that stands on eight points, at 1 ms.

{table(["", *labels], costs)}

## Error against closed forms

A free pendulum let go at 1 rad: rms error over {SECONDS:g} s [rad].

{table(["", *labels], swings)}

A block that slides at 1 m/s, µ = {FRICTION}: error of its way to rest [mm] (a step at 1 m/s moves it by 4 to 0.25 mm).

{table(["", *labels], slides)}

## Error against real robots

{table(["", *labels], outside)}
"""


def machine() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []:
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def draw(found: dict[str, Found], path: Path) -> None:
    """Error against cost: the pendulum by step rate, and the real humanoid."""
    names = list(found)
    body, _ = real(names)
    plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "realitygap", "font.size": 9})
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.8), constrained_layout=True)
    for name, of in found.items():
        color = engine_color(name, names)
        x = [of.cost["pendulum"] * rate * 1e-6 for rate in RATES]
        left.plot(x, list(of.swing.values()), "o-", ms=3.5, lw=1.1, color=color, label=engine_label(name))
        if name in body:
            right.plot(of.cost["humanoid"] * 1e-3, body[name], "o", color=color)
            at = (of.cost["humanoid"] * 1e-3, body[name])
            right.annotate(engine_label(name), at, (5, 3), textcoords="offset points")
    best = front(found, body)
    x, y = [found[n].cost["humanoid"] * 1e-3 for n in best], [body[n] for n in best]
    right.step(x, y, where="post", color="#8a8a8a", lw=0.9, zorder=0, label="none is cheaper and closer")
    right.legend(fontsize=7.5)
    left.set(xscale="log", yscale="log", xlabel="s per simulated second", ylabel="rms error [rad]")
    left.set_title(f"Pendulum, {RATES[0]} to {RATES[-1]} Hz, against the closed form", fontsize=9)
    left.legend(fontsize=7.5)
    right.set(xscale="log", xlabel="s per simulated second at 1 kHz", ylabel="mean error [rad]")
    right.set_title("Real humanoid, a kick and a squat", fontsize=9)
    right.margins(x=0.25, y=0.15)
    for axes in (left, right):
        axes.grid(color="#e4e2dd", lw=0.7)
    figure.savefig(path, metadata={"Date": None})


def main() -> None:
    """Measure, print, and write where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--engine", action="append", default=[])
    parser.add_argument("--steps", type=int, default=300)
    parser.add_argument("--batches", type=int, default=5)
    parser.add_argument("--write", type=Path)
    options = parser.parse_args()
    found = measure(options.engine or engines.available(), options.steps, options.batches)
    picture = options.write.with_suffix(".svg") if options.write else Path("engines.svg")
    text = page(found, picture.name)
    print(text)
    if options.write:
        options.write.write_text(text, encoding="utf-8")
        draw(found, picture)


if __name__ == "__main__":
    main()
