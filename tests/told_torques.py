"""What benches of motors that are told torques share: how they are driven, recordings as tables, what is named."""

import argparse
import sys
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np
from named import named
from realitygap.trace.trace import Array

DRIVEN = {
    "commanded": "servos: [{joints: '*', kind: effort}]\nmotion: {recorded: command, as: effort, held: true}\n",
    "measured": "servos: [{joints: '*', kind: effort}]\nmotion: {recorded: effort, as: effort, held: false}\n",
    "followed": "motion: {followed: true}\n",
}
SIGNALS = ("position", "velocity", "command", "effort")
Recorded = Iterable[tuple[str, str, Array]]
"""Name, use and table of every motion: time, then `SIGNALS` of all joints. Shape (t, 1 + 4·joints)."""


def bench(
    description: str | None,
    name: str,
    urdf: str,
    joints: Sequence[str],
    machine: Callable[[np.random.Generator], tuple[object, Recorded]],
) -> None:
    """Print what was planted in a machine that is drawn, and what is named of its recordings."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--way", choices=DRIVEN, default="commanded")
    parser.add_argument("--out", type=Path, help="keep scenario and recordings here")
    options = parser.parse_args()
    truth, recorded = machine(np.random.default_rng(options.seed))
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.out or Path(temporary)
        folder.mkdir(exist_ok=True)
        (folder / f"{name}.urdf").write_text(urdf, encoding="utf-8")
        header, runs = ",".join(["time", *(f"{s}_{j}" for s in SIGNALS for j in joints)]), ""
        for title, use, table in recorded:
            np.savetxt(folder / f"{title}.csv", table, fmt="%.7g", delimiter=",", header=header, comments="")
            runs += f"    - {{path: {title}.csv, use: {use}}}\n"
        robot = f"name: {name}\nrobot: {{urdf: {name}.urdf, base: fixed}}\n"
        recordings = f"recordings:\n  virtual: true\n  effort: motor\n  runs:\n{runs}"
        (folder / "scenario.yaml").write_text(robot + DRIVEN[options.way] + recordings, encoding="utf-8")
        sys.stdout.write(f"planted {truth}\n")
        sys.stdout.write(named(folder / "scenario.yaml"))
