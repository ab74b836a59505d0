"""What benches tell of a diagnosis."""

import time as clock
from pathlib import Path

import realitygap as rg


def named(scenario: Path) -> str:
    """What `diagnose` names in MuJoCo: the verdict, the held-out gap and the time in a line, and a line per finding."""
    began = clock.monotonic()
    found = rg.diagnose(scenario, ["mujoco"])
    before, after = found.gap["held_out"]
    took = clock.monotonic() - began
    lines = [f"{found.verdict}, held out {before:.2f} -> {after:.2f} floors, {took:.0f} s"]
    lines += [f"    {f!r}" for f in found.findings]
    lines += [f"    adjusted {f!r}" for f in found.adjusted]
    return "\n".join(lines) + "\n"
