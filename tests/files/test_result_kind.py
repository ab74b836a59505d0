"""A command writes over its own results alone: what it has not written stays, and is told before the work."""

import json
from pathlib import Path

import pytest
from realitygap.bench.page import write_page
from realitygap.bench.summary import Summary
from realitygap.cli.options import folder_for
from realitygap.files.errors import InputError
from realitygap.files.result_folder import FINISHED, MANIFEST
from realitygap.files.result_kind import TABLES, WRITTEN, check_free


def result(folder: Path, command: str) -> None:
    """What a command leaves, as far as it tells whose it is."""
    folder.mkdir(exist_ok=True)
    name, key = WRITTEN[command]
    (folder / name).write_text(json.dumps({key: []}))
    write_page(Summary(["gap: 1"]), "demo", folder)
    for table in TABLES.get(command, ()):
        (folder / table).write_text("a\n1\n")


@pytest.mark.parametrize("command", WRITTEN)
def test_a_command_writes_over_its_own_result(command: str, tmp_path: Path) -> None:
    result(tmp_path, command)
    (tmp_path / "notes.txt").write_text("mine")
    check_free(tmp_path, command)


@pytest.mark.parametrize(
    ("command", "name"),
    [(command, name) for command, (name, _) in WRITTEN.items()]
    + [(command, name) for command, names in TABLES.items() for name in names]
    + [(command, "report.html") for command in (*WRITTEN, "bench")],
)
@pytest.mark.parametrize("text", ['{"mine": 1}', "<html>mine</html>", ""])
def test_it_does_not_over_what_somebody_else_has_written(text: str, command: str, name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError) as told:
        folder_for(tmp_path, command=command)
    assert str(told.value) == (
        f"--out: {tmp_path} holds {name}, which no `{command}` has written and this one would write over; expected "
        "another folder"
    )
    assert (tmp_path / name).read_text() == text


def test_nor_over_a_page_that_took_the_place_of_its_own(tmp_path: Path) -> None:
    result(tmp_path, "run")
    (tmp_path / "report.html").write_text("<title>mine</title>")
    with pytest.raises(InputError, match=r"holds report.html, which no `run` has written"):
        check_free(tmp_path, "run")


def test_a_bench_does_not_over_the_page_of_a_run(tmp_path: Path) -> None:
    result(tmp_path, "run")
    with pytest.raises(InputError, match=r"holds the result of `run`, whose report.html `bench` would write over"):
        check_free(tmp_path, "bench")


def test_what_was_on_its_way_when_a_run_was_killed_is_its_own(tmp_path: Path) -> None:
    """The manifest comes last, so that until then nothing says whose the files are that came before."""
    (tmp_path / "gaps.csv").write_text("a\n1\n")
    part = tmp_path / f"{FINISHED}x"
    part.mkdir()
    (part / MANIFEST).write_text(json.dumps({"files": ["gaps.csv"]}))
    assert folder_for(tmp_path, command="run") == tmp_path
    assert not part.exists()


def test_and_no_diagnosis_is_saved_over_it(tmp_path: Path) -> None:
    """As a library's `save` asks, which no command precedes."""
    part = tmp_path / f"{FINISHED}x"
    part.mkdir()
    (part / MANIFEST).write_text(json.dumps({"files": ["gaps.csv"]}))
    with pytest.raises(InputError, match="holds the result of `run`"):
        check_free(tmp_path, "diagnose", "save")
