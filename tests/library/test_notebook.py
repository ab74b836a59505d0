"""The notebook of the library runs from top to bottom, beside the demo, and shows what its text says."""

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import realitygap as rg

NOTEBOOK = Path(__file__).parents[2] / "scenarios" / "demo" / "library.ipynb"
CELLS = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
PLANTED = 0.6447
"""Coulomb friction of the recorded elbow [N·m]; the model has 0.2756 (SOURCE.md)."""


@pytest.fixture(scope="module")
def names(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Any]]:
    """What the notebook has defined at its end, in the folder in which it ran."""
    folder = tmp_path_factory.mktemp("notebook") / "demo"
    shutil.copytree(NOTEBOOK.parent, folder)
    found: dict[str, Any] = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for cell in CELLS:
            if cell["cell_type"] == "code":
                exec("".join(cell["source"]), found)
        yield found


def test_it_is_stored_without_outputs() -> None:
    assert [cell for cell in CELLS if cell.get("outputs") or cell.get("execution_count")] == []


def test_friction_brings_the_model_to_what_was_measured(names: dict[str, Any]) -> None:
    assert names["gap"](names["with_friction"]) < 0.5 * names["gap"](names["t"])


def test_the_diagnosis_names_what_was_planted(names: dict[str, Any]) -> None:
    d = names["d"]
    assert d.verdict == "explained"
    (finding,) = d.findings
    assert (finding.effect, finding.target) == ("coulomb_friction", "elbow")
    assert finding.parameters["torque"] == pytest.approx(PLANTED, rel=0.05)
    low, high = finding.intervals["torque"]
    assert low < finding.parameters["torque"] < high
    assert finding.units == {"torque": "N·m"}
    before, after = d.gap["held_out"]
    assert after < 1.3 < before
    assert d.content == json.loads(json.dumps(d.content)), "as diagnosis.json"


def test_nouns_tell_themselves_in_a_line(names: dict[str, Any]) -> None:
    d = names["d"]
    assert repr(d) == "<Diagnosed demo: explained; coulomb_friction at elbow>"
    assert repr(d.findings[0]).startswith("<Finding coulomb_friction at elbow: torque 0.6")
    for noun in (names["s"], names["t"], names["c"], d, d.revised, names["s"].scenario):
        assert len(repr(noun)) < 160
        assert "\n" not in repr(noun)


def test_the_mended_model_moves_as_the_finding_says(names: dict[str, Any]) -> None:
    gap, spec = names["gap"], names["found"].spec
    """But for the digits that a finding tells."""
    mended = gap(rg.simulate("fixed/scenario.yaml", "mujoco", run="chirp_1"))
    assert mended == pytest.approx(gap(rg.simulate(names["s"], "mujoco", run="chirp_1", effects=[spec])), rel=0.01)
    assert mended < 0.5 * gap(names["t"])


def test_the_scenario_is_not_overwritten(names: dict[str, Any]) -> None:
    with pytest.raises(rg.InputError, match=r"save: .* is the folder of scenario.yaml, which would be replaced"):
        names["d"].revised.save(names["s"].path.parent)
