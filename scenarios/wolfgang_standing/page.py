"""The page of the sweep, from its table alone: `python scenarios/wolfgang_standing/page.py`."""

from pathlib import Path


def write_page(out: Path) -> None:
    """Write pid_sweep.md and pid_sweep.svg from pid_sweep.csv."""
