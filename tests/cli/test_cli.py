"""The command line: it starts quickly, says what there is, and its commands leave what they promise."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
import realitygap_engines as engines
from realitygap.cli.main import main
from realitygap.cli.options import folder_for, named_after

ROOT = Path(__file__).parents[2]
COMMANDS = (
    *("engines", "init", "check", "run", "matrix", "audit", "report"),
    *("diagnose", "rehearse", "propose", "effects", "schema"),
    "bench",
)


def said(*arguments: str | Path, capfd: pytest.CaptureFixture[str], status: int = 0) -> str:
    """What a command prints."""
    with pytest.raises(SystemExit) as end:
        main([str(a) for a in arguments])
    assert end.value.code == status
    return capfd.readouterr().out


def test_help_names_every_command(capfd: pytest.CaptureFixture[str]) -> None:
    assert re.findall(r"^  (\w+) {2,}\w", said("--help", capfd=capfd).partition("Commands:")[2], re.MULTILINE) == list(
        COMMANDS
    )


@pytest.mark.parametrize("command", [[], ["run"], ["bench"], ["bench", "servo"]], ids=" ".join)
def test_help_is_asked_for_in_short_too(command: list[str], capfd: pytest.CaptureFixture[str]) -> None:
    assert said(*command, "-h", capfd=capfd) == said(*command, "--help", capfd=capfd)


def test_results_of_two_scenarios_of_a_folder_stay_apart() -> None:
    """A folder's own one is called as the folder is."""
    names = {file: named_after(ROOT / "scenarios" / "ur10e" / file) for file in ("scenario.yaml", "loaded.yaml")}
    assert names == {"scenario.yaml": "ur10e", "loaded.yaml": "ur10e_loaded"}
    assert named_after(ROOT / "arm_diagnosis" / "diagnosis.json") == "arm_diagnosis"


@pytest.mark.parametrize(
    ("command", "kind"),
    [("run", ""), ("matrix", ""), ("diagnose", "_diagnosis"), ("rehearse", "_rehearsal"), ("propose", "_proposal")],
)
def test_help_says_where_results_go(command: str, kind: str, capfd: pytest.CaptureFixture[str]) -> None:
    text = " ".join(said(command, "--help", capfd=capfd).split())
    assert f"result folder (default: {folder_for(None, f'NAME{kind}')}, after the file's folder)" in text


def test_without_a_command_there_is_help(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main([])
    assert end.value.code == 2
    assert "Commands:" in "".join(capfd.readouterr())


@pytest.mark.parametrize("group", [[], ["bench"]])
def test_commands_are_told_in_a_line(group: list[str], capfd: pytest.CaptureFixture[str]) -> None:
    listed = said(*group, "--help", capfd=capfd).partition("Commands:")[2].strip().splitlines()
    assert all(line.endswith(".") and not line.endswith("...") for line in listed), "cut off"


def test_the_bench_tells_of_all_its_commands(capfd: pytest.CaptureFixture[str]) -> None:
    text = said("bench", "--help", capfd=capfd)
    about, _, listed = text.partition("Commands:")
    names = re.findall(r"^  (\w+) {2,}\w", listed, re.MULTILINE)
    assert len(names) == 4
    for name in names:
        assert name.rstrip("sy") in about.partition("Options:")[0].partition("\n")[2]


@pytest.mark.parametrize("arguments", ["--help", "--version", "run --help"])
def test_help_imports_nothing_heavy(arguments: str) -> None:
    program = (
        "import sys\nfrom realitygap.cli.main import main\n"
        f"try: main({arguments.split()})\nexcept SystemExit: pass\nprint(*sys.modules, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True)
    heavy = {"numpy", "scipy", "pandas", "matplotlib", "numba", "rosbags", "yaml", *engines.ENGINES}
    assert heavy.isdisjoint(done.stderr.split())


def test_version(capfd: pytest.CaptureFixture[str]) -> None:
    assert re.fullmatch(r"realitygap \d+\.\d+\.\d+\n", said("--version", capfd=capfd))


def test_engines_are_listed_with_what_they_can(capfd: pytest.CaptureFixture[str]) -> None:
    text = said("engines", capfd=capfd)
    assert re.findall(r"^(\w+)[: ]", text, re.MULTILINE) == sorted(engines.ENGINES)
    for name in engines.available():
        assert engines.load(name).version in text
    for what in engines.engine.CAPABILITIES:
        assert len(re.findall(rf"^  {what} +(native|emulated|no) +\S", text, re.MULTILINE)) == len(engines.available())


def test_effects_are_listed(capfd: pytest.CaptureFixture[str]) -> None:
    text = said("effects", capfd=capfd)
    assert "coulomb_friction" in text
    assert "soft_ground" in text


@pytest.mark.parametrize("kind", ["supply"])
def test_a_bench_names_what_it_wrote(kind: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (file,) = (ROOT / "scenarios" / "bench_supply_planted").glob("*.yaml")
    text = said("bench", kind, file, "--out", tmp_path / "out", capfd=capfd)
    written = [Path(line.removeprefix("wrote ")) for line in text.splitlines() if line.startswith("wrote ")]
    assert written
    assert all(path.is_file() and path.is_relative_to(tmp_path / "out") for path in written)


def test_a_report_is_made_again_from_the_files_alone(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    text = """
name: short
robot: {urdf: arm.urdf, base: fixed}
servos: [{joints: "*", kind: pid, kp: 30.0, kd: 1.0}]
motion: {recorded: /joint_commands}
recordings: {state: /joint_states, runs: [{path: chirp_1.mcap}]}
"""
    demo = ROOT / "scenarios" / "demo"
    for name in ("arm.urdf", "chirp_1.mcap"):
        (tmp_path / name).write_bytes((demo / name).read_bytes())
    (tmp_path / "scenario.yaml").write_text(text)
    out = tmp_path / "out"
    said("run", tmp_path / "scenario.yaml", "--engine", "mujoco", "--out", out, capfd=capfd)
    made = [out / "report.html", *(out / "figures").iterdir()]
    before = {path: path.read_bytes() for path in made}
    for path in made:
        path.unlink()
    for name in ("arm.urdf", "chirp_1.mcap", "scenario.yaml"):
        (tmp_path / name).unlink()
    assert said("report", out, capfd=capfd) == f"report: {out / 'report.html'}\n"
    assert {path: path.read_bytes() for path in [out / "report.html", *(out / "figures").iterdir()]} == before
