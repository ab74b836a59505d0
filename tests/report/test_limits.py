"""What the page says of limits: those that concern what was simulated, and what noise floors are."""

from pathlib import Path

import pytest
import synthetic
from realitygap.report import write_page

NAMES = ("lone_body", "mimic_joints", "soft_ground", "solver_iterations")
EMULATED = {name: {"level": "emulated", "how": f"how of {name}"} for name in NAMES}
ARM = {("mujoco", (("ground", "none"),), "position", "moving"): 0.5}
BIPED = {("mujoco", (("ground", "flat"),), "position", "moving"): 0.5}
BODY = {("mujoco", (("ground", "flat"),), "position", "base"): 0.5}


@pytest.mark.parametrize(
    ("gaps", "said"),
    [
        (ARM, {"mimic_joints", "solver_iterations"}),
        (BIPED, {"mimic_joints", "soft_ground", "solver_iterations"}),
        (BODY, {"lone_body", "soft_ground", "solver_iterations"}),
        ({}, set(NAMES)),  # nothing was measured: the table does not tell
    ],
)
def test_only_limitations_of_what_was_simulated_are_told(tmp_path: Path, gaps: synthetic.Gaps, said: set[str]) -> None:
    if not gaps:
        synthetic.write_cell(tmp_path, synthetic.cell(recording=""), synthetic.trace(["pendulum"], 0.01, 1), None)
    synthetic.write_planted(tmp_path, synthetic.planted(gaps), {"capabilities": {"mujoco": EMULATED}})
    text = write_page(tmp_path).read_text(encoding="utf-8")
    assert {name for name in NAMES if f"how of {name}" in text} == said


@pytest.mark.parametrize(("recordings", "rounded"), [(("kick", "squat"), True), (("kick", "squat ×3"), False)])
def test_a_floor_without_repetitions_is_called_rounding(
    tmp_path: Path, recordings: tuple[str, ...], rounded: bool
) -> None:
    gaps = {("mujoco", (("recording", name),), "position", "moving"): 0.5 for name in recordings}
    synthetic.write_planted(tmp_path, synthetic.planted(gaps))
    assert ("No motion was repeated" in write_page(tmp_path).read_text(encoding="utf-8")) == rounded
