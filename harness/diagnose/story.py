"""The page of a diagnosis: the story in order."""

from __future__ import annotations

from pathlib import Path

from harness.diagnose.diagnosis import Diagnosis


def write_story(result: Diagnosis, out: Path) -> Path:
    """Write the page and its figures into a result folder."""
    return out / "report.html"
