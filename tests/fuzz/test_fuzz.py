"""Whatever a file holds: one sentence or a result, soon, in little memory, and nothing written where it was refused.

`make fuzz` tries 10,000 cases; here stand a few of every kind, always the same, and those that once broke.
"""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from fuzz.corpus import CORPUS
from fuzz.judge import Zygote, judged, zygote
from fuzz.kinds import KINDS, Case
from fuzz.template import written
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import seed as seeded

FEW = 4


@pytest.fixture(scope="module")
def process() -> Iterator[Zygote]:
    with zygote() as started:
        yield started


@pytest.mark.parametrize("name", CORPUS)
def test_what_once_broke_a_command(name: str, process: Zygote, tmp_path: Path) -> None:
    case, sentence = CORPUS[name]
    files, arguments = case()
    written(tmp_path, files)
    assert sentence in judged(process, tmp_path, arguments)["said"]


@pytest.mark.parametrize("kind", KINDS)
def test_no_file_breaks_a_command(kind: str, process: Zygote, tmp_path: Path) -> None:
    @seeded(1)
    @settings(
        max_examples=FEW,
        phases=[Phase.generate],
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(KINDS[kind]())
    def no_case_breaks_it(case: Case) -> None:
        shutil.rmtree(tmp_path / "case", ignore_errors=True)
        written(tmp_path / "case", case[0])
        judged(process, tmp_path / "case", case[1])

    no_case_breaks_it()
