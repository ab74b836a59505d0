"""A command that is wrong: one sentence on standard error, exit status 2, and nothing written."""

import os
from pathlib import Path

import pytest
from realitygap.robot.effects import EFFECTS
from spoiled import changed, one_sentence, refused

COMMANDS = {
    "unknown engine": (["run", "scenario.yaml", "--engine", "gazebo"], "--engine: found gazebo; expected one of"),
    "engine in capitals": (["run", "scenario.yaml", "--engine", "MuJoCo"], "; did you mean mujoco?"),
    "engines in one": (
        ["run", "scenario.yaml", "--engine", "mujoco,dart"],
        "; name each on its own: --engine A --engine B",
    ),
    "engine of an audit": (["audit", "--engine", "gazebo"], "--engine: found gazebo; expected one of"),
    "engine of a diagnosis": (["diagnose", "scenario.yaml", "--engine", "gazebo"], "--engine: found gazebo"),
    "budget without a number": (["run", "scenario.yaml", "--max-gap", "position=x"], "--max-gap: found 'position=x'"),
    "budget of nothing": (["run", "scenario.yaml", "--max-gap", "speed=1"], "expected SIGNAL=VALUE with one of"),
    "budget that is negative": (["run", "scenario.yaml", "--max-gap", "-1"], "--max-gap: found '-1'"),
    "out is a file": (["run", "scenario.yaml", "--out", "arm.urdf"], "--out: arm.urdf cannot be made because"),
    "out below a file": (["run", "scenario.yaml", "--out", "arm.urdf/out"], "arm.urdf is a file; expected a folder"),
    "out in a place that takes no files": (["run", "scenario.yaml", "--out", "/proc/nope"], "/proc takes no files"),
    "out of a matrix": (["matrix", "matrix.yaml", "--out", "arm.urdf"], "--out: arm.urdf cannot be made"),
    "out of a diagnosis": (["diagnose", "scenario.yaml", "--out", "arm.urdf"], "--out: arm.urdf cannot be made"),
    "out of a bench": (["bench", "servo", "bench.yaml", "--out", "arm.urdf"], "--out: arm.urdf cannot be made"),
    "out of an audit": (["audit", "--out", "arm.urdf"], "--out: arm.urdf cannot be made"),
    "out of a first scenario": (
        ["init", "arm.urdf", "chirp_1.mcap", "--out", "arm.urdf/a"],
        "--out: arm.urdf/a cannot",
    ),
    "out of JUnit": (["run", "scenario.yaml", "--junit", "arm.urdf/j.xml"], "--junit: arm.urdf cannot be made"),
    "JUnit is a folder": (["run", "scenario.yaml", "--junit", "results"], "--junit: results is a folder; expected the"),
    "out is a link to nothing": (
        ["run", "scenario.yaml", "--out", "broken"],
        "is a link to nothing; expected a folder",
    ),
    "out of nobody": (["run", "scenario.yaml", "--out", ""], "--out' / '-o': found an empty name, expected a folder"),
    "a first scenario for nobody": (
        ["init", "arm.urdf", "chirp_1.mcap", "-o", ""],
        "found an empty name, expected a folder",
    ),
    "JUnit of nobody": (["run", "scenario.yaml", "--junit", ""], "--junit': found an empty name, expected a file"),
    "a run into a diagnosis": (
        ["run", "scenario.yaml", "--out", "diagnosed"],
        "--out: diagnosed holds the result of `diagnose`, whose report.html `run` would write over; expected another",
    ),
    "a proposal into a diagnosis": (["propose", "diagnosed", "--out", "diagnosed"], "the result of `diagnose`, whose"),
    "a diagnosis into a run": (["diagnose", "scenario.yaml", "--out", "ran"], "--out: ran holds the result of `run`"),
    "a rehearsal into a run": (["rehearse", "scenario.yaml", "--out", "ran"], "--out: ran holds the result of `run`"),
    "a page of a diagnosis": (["report", "diagnosed"], "holds the result of `diagnose`, which writes its page itself"),
    "a page anew of nothing known": (["report", "diagnosed"], "; `realitygap diagnose SCENARIO --out diagnosed` makes"),
    "a scenario without name": (["run", ""], "invalid value for 'scenario': found an empty name, expected a file"),
    "a recording without name": (["init", "arm.urdf", ""], "'bags': found an empty name, expected a file"),
    "a bench without name": (["bench", "servo", ""], "'file': found an empty name, expected a file"),
    "no matrix": (["matrix", "none.yaml"], "none.yaml: cannot be read (No such file"),
    "no results": (["report", "none"], "none: found no gaps.csv"),
    "results that are no table": (
        ["report", "results"],
        "gaps.csv: has no column scenario, robot_revision, engine_version",
    ),
    "no URDF for an audit": (["audit", "none.urdf"], "none.urdf"),
    "no scenario for a diagnosis": (["diagnose", "none.yaml"], "none.yaml: cannot be read"),
    "unknown effect": (["effects", "magic"], "unknown effect magic; known: coulomb_friction"),
    "an effect misspelt": (["effects", "colomb_friction"], "; did you mean coulomb_friction?"),
    "unknown schema": (["schema", "benh"], "schema: found benh; expected one of scenario, matrix, bench; did you mean"),
    "no servo bench": (["bench", "servo", "none.yaml"], "none.yaml: cannot be read"),
    "no supply bench": (["bench", "supply", "none.yaml"], "none.yaml: cannot be read"),
    "no link bench": (["bench", "links", "none.yaml"], "none.yaml: cannot be read"),
    "no URDF for a first scenario": (["init", "none.urdf", "chirp_1.mcap", "--out", "new"], "none.urdf"),
    "no bag for a first scenario": (["init", "arm.urdf", "none.mcap", "--out", "new"], "none.mcap: does not exist"),
    "a recording before its robot": (
        ["init", "chirp_1.mcap", "arm.urdf", "--out", "new"],
        "chirp_1.mcap: is a recording; expected the robot's file first, and its recordings after it",
    ),
    "two robots": (
        ["init", "arm.urdf", "chirp_1.mcap", "arm.urdf", "--out", "new"],
        "arm.urdf: is a robot's file; expected recordings after arm.urdf, and one robot alone",
    ),
    "a recording twice": (
        ["init", "arm.urdf", "chirp_1.mcap", "results/../chirp_1.mcap", "--out", "new"],
        "chirp_1.mcap: is given 2 times; expected every recording once",
    ),
    "a folder of a table without joints": (
        ["init", "arm.urdf", "tables", "--out", "new"],
        "tables/run.csv: no column holds the position of shoulder, elbow",
    ),
    "a scenario that is there": (["init", "arm.urdf", "chirp_1.mcap"], "scenario.yaml: is already there"),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_commands_refuse(
    name: str, case: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    arguments, sentence = COMMANDS[name]
    monkeypatch.chdir(case)
    (case / "results").mkdir()
    (case / "results" / "gaps.csv").write_text("engine\nmujoco\n")
    (case / "tables").mkdir()
    (case / "tables" / "run.csv").write_text("time\n0\n")
    for folder, name, key in (("diagnosed", "diagnosis.json", "verdict"), ("ran", "manifest.json", "files")):
        (case / folder).mkdir()
        (case / folder / name).write_text(f'{{"{key}": []}}')
    (case / "broken").symlink_to(case / "nothing")
    before = sorted(case.rglob("*"))
    assert refused(*arguments) == 2
    assert sentence in one_sentence(capfd.readouterr())
    assert sorted(case.rglob("*")) == before, "something was written"


@pytest.mark.parametrize("key", ["effects", "suspects", "certain"])
def test_names_that_could_have_been_meant_are_told_without_a_gap(
    key: str, case: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """All of them: one that is close to what was found need not be it."""
    changed(**{key: [{"effect": "magic"}] if key == "effects" else ["magic"]})(case)
    assert refused("check", case / "scenario.yaml") == 2
    said = one_sentence(capfd.readouterr())
    assert ", ".join(EFFECTS) in said
    assert said.endswith(("effort_map\n", f"{list(EFFECTS)[-1]}\n"))


USAGE = {
    "run": "missing argument 'scenario' (--help tells what is expected)\n",
    "run scenario.yaml --engin mujoco": "no such option: --engin (Possible options: --engine) (",
    "run scenario.yaml --out": "option '--out' requires an argument (",
    "rnu": "no such command 'rnu'; did you mean 'run'? (",
    "bench motor a": "no such command 'motor' (expected one of servo, supply, links, ground)\n",
    "frobnicate": "no such command 'frobnicate' (expected one of engines, init, check, run, matrix, audit, report, ",
    "bench serv a": "no such command 'serv'; did you mean 'servo'? (--help tells what is expected)\n",
    "matrix a -j 0": "--jobs: found 0; expected greater than or equal to 1\n",
    "diagnose a -j 1.5": "--jobs: found 1.5; expected a whole number\n",
    "diagnose a --minutes -1": "--minutes: found -1; expected greater than or equal to 0\n",
    "diagnose a --minutes nan": "--minutes: found nan; expected greater than or equal to 0\n",
    "rehearse a --budget soon": "--budget: found soon; expected a number\n",
    "propose a --motions none": "--motions: found none; expected a whole number\n",
}


@pytest.mark.parametrize("line", USAGE)
def test_what_the_parser_refuses_is_one_sentence_too(line: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert refused(*line.split()) == 2
    assert one_sentence(capfd.readouterr()).startswith(f"realitygap: {USAGE[line]}")


@pytest.mark.parametrize(
    ("error", "said"), [(RuntimeError("surprise"), "Traceback"), (MemoryError("5 GiB"), "the memory does not suffice")]
)
def test_no_error_looks_like_a_failed_check(
    error: Exception, said: str, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail() -> str:
        raise error

    monkeypatch.setattr("realitygap.cli.engines_table.engines_table", fail)
    assert refused("engines") == 2
    assert said in capfd.readouterr().err


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_is_read_only(case: Path, capfd: pytest.CaptureFixture[str]) -> None:
    case.chmod(0o555)
    try:
        assert refused("run", case / "scenario.yaml", "--out", case / "out") == 2
    finally:
        case.chmod(0o755)
    assert "takes no files" in one_sentence(capfd.readouterr())
