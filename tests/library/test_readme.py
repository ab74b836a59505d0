"""What the README and the package's docstring show of the library, word for word, on a demo with two runs."""

import re
import shutil
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import realitygap as rg
import yaml

ROOT = Path(__file__).parents[2]
RUNS = [{"path": "triangle_1.mcap", "use": "train"}, {"path": "chirp_1.mcap", "use": "held_out"}]


def readme() -> str:
    (block,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    return str(block)


def calls(text: str) -> list[str]:
    """The code without comments and spaces."""
    return re.findall(r"\S+", re.sub(r"#.*", "", text))


def test_the_docstring_shows_the_same() -> None:
    assert rg.__doc__ is not None
    shown = rg.__doc__[rg.__doc__.index("import realitygap") : rg.__doc__.index("\n\nPaths")]
    assert calls(shown) == calls(readme())


def test_it_does_what_it_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    demo = tmp_path / "scenarios" / "demo"
    shutil.copytree(ROOT / "scenarios" / "demo", demo)
    told = yaml.safe_load((demo / "scenario.yaml").read_text(encoding="utf-8"))
    told["recordings"]["runs"] = RUNS
    (demo / "scenario.yaml").write_text(yaml.safe_dump(told), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(readme(), names)
    frame, gaps = names["t"].to_frame(), rg.compare(names["s"], engines=["mujoco"], floors=False).gaps
    assert isinstance(frame, pd.DataFrame)
    assert frame.columns.names == ["signal", "joint"]
    assert {"engine", "recording", "joint", "signal", "mean_abs", "noise_floor"} <= set(gaps.columns)
    d = names["d"]
    assert (d.verdict, [(f.effect, f.target) for f in d.findings]) == ("explained", [("coulomb_friction", "elbow")])
    assert set(d.findings[0].engines) >= set(rg.available()) - {d.content["engines"][0]}
    assert rg.simulate("fixed/scenario.yaml", "dart", run="chirp_1").joints == ("shoulder", "elbow")


def test_every_name_of_the_readme_is_there() -> None:
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    section = page[page.index("## As a library") : page.index("## Reading a result")]
    nouns = set(re.findall(r"`(?:rg\.)?([A-Z]\w+)`", section)) | set(re.findall(r"^\| `(\w+)", section, re.MULTILINE))
    assert nouns <= {*rg.__all__, "Path"}
    assert len(nouns) > 10
