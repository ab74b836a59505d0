"""Matrix files, the cells they mean, and keys by content."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
import realitygap
import realitygap_engines
from realitygap.files.errors import InputError
from realitygap.matrix.digest import code_digest
from realitygap.matrix.estimate import costs
from realitygap.matrix.matrix import Settings, dry_run
from realitygap.matrix.matrix_file import load_matrix
from realitygap.matrix.plan import plan
from realitygap.matrix.task import Task
from signals import there

DEMO = Path(__file__).parents[2] / "scenarios" / "demo"


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., list[Task]]:
    """A function that writes a matrix of the demo scenario and returns its cells."""

    def write(text: str, folder: Path = DEMO) -> list[Task]:
        path = tmp_path / "matrix.yaml"
        path.write_text(f"name: test\nscenarios: {folder}/scenario.yaml\nrecordings: chirp_*\n{text}")
        return plan(load_matrix(path))

    return write


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """The demo scenario in a folder of its own."""
    return Path(shutil.copytree(DEMO, tmp_path / "copy"))


def test_every_combination_is_a_cell(write: Callable[..., list[Task]]) -> None:
    tasks = write("engines: [mujoco, dart]\naxes: {step_rate: [500, 1000], servos.drive.gain: [4, 5, 6]}\n")
    assert len(tasks) == 12
    found = {(t.engine, t.cell.step_rate, t.cell.overrides) for t in tasks}
    assert ("dart", 500.0, '{"servos.drive.gain": 6}') in found
    assert len(found) == len({t.key for t in tasks}) == 12
    gains = {t.axes["servos.drive.gain"]: t.motion.experiments[0].plant.drive["gain"][0] for t in tasks}
    assert gains == {4: 4.0, 5: 5.0, 6: 6.0}


@pytest.mark.parametrize(
    ("seconds", "said"), [(61, "1 minute"), (89, "1 minute"), (91, "2 minutes"), (600, "10 minutes")]
)
def test_what_takes_long_is_told_in_minutes(seconds: float, said: str) -> None:
    assert costs(seconds, [], 2, 1e9) == [f"this takes about {said}"]
    assert costs(60, [], 2, 1e9) == []


@pytest.mark.parametrize(
    ("leave_out", "count"),
    [
        ("{engine: dart, step_rate: 500}", 7),
        ("{engine: dart}", 4),
        ("{recording: chirp_*}", 0),
        ("{step_rate: [500, 1000], engine: d*}", 6),
    ],
)
def test_combinations_are_left_out(write: Callable[..., list[Task]], leave_out: str, count: int) -> None:
    text = f"engines: [mujoco, dart]\naxes: {{step_rate: [500, 1000, 2000, 4000]}}\nleave_out: [{leave_out}]\n"
    if count:
        assert len(write(text)) == count
    else:
        with pytest.raises(InputError, match="holds no cell"):
            write(text)


def test_what_is_left_out_may_be_of_another_choice_of_engines_and_recordings(write: Callable[..., list[Task]]) -> None:
    """So that a matrix is made smaller for a first look without another change."""
    text = "engines: mujoco\nleave_out: [{engine: dart}, {recording: sines_*}, {recording: [triangle_1, step*]}]\n"
    assert len(write(text)) == 1


def test_values_that_only_together_are_wrong_are_told_together(write: Callable[..., list[Task]]) -> None:
    text = "engines: mujoco\naxes: {servos.0.kind: [pid], servos.0.kp: [1, 2]}\n"
    with pytest.raises(
        InputError, match=r"matrix.yaml: axes: servos.0.kind 'pid', servos.0.kp 1: servos\[0\].\w+: unk"
    ):
        write(text)


def test_patterns_that_match_nothing_are_told_with_what_there_is(tmp_path: Path) -> None:
    path = tmp_path / "matrix.yaml"
    path.write_text(f"name: test\nscenarios: {DEMO}/scenario.yaml\nengines: mujoco\nrecordings: [foo*, bar]\n")
    with pytest.raises(
        InputError, match=r"holds no cell; recordings is foo\*, bar; expected .* match chirp_1, sines_1_rep1"
    ):
        plan(load_matrix(path))


def test_cells_are_listed_as_the_file_says_their_values(tmp_path: Path) -> None:
    path = tmp_path / "matrix.yaml"
    path.write_text(
        f"name: test\nscenarios: {DEMO}/scenario.yaml\nengines: mujoco\nrecordings: chirp_*\n"
        "axes: {step_rate: [500, 2000, 1000], servos.drive.gain: [5, 4, 10]}\n"
    )
    *cells, last = dry_run(load_matrix(path), tmp_path / "out", Settings())
    assert last.startswith("9 cells, 0 of them there; ")
    listed = [re.findall(r"step_rate (\d+) gain (\d+)", line)[0] for line in cells]
    assert listed == [(rate, gain) for rate in ("500", "2000", "1000") for gain in ("5", "4", "10")]


def test_cells_come_in_the_order_in_which_they_are_listed(write: Callable[..., list[Task]]) -> None:
    cells = write("engines: mujoco\naxes: {step_rate: [500, 2000, 1000, 250, 750]}\n")
    assert [cell.axes["step_rate"] for cell in cells] == [500, 2000, 1000, 250, 750]


def test_repetitions_stay_one_motion_under_every_axis_value(tmp_path: Path) -> None:
    path = tmp_path / "matrix.yaml"
    path.write_text(
        f"name: test\nscenarios: {DEMO}/scenario.yaml\nengines: mujoco\nrecordings: sines_1_*\n"
        "axes: {step_rate: [500, 1000]}\n"
    )
    tasks = plan(load_matrix(path))
    assert [len(t.motion.experiments) for t in tasks] == [2, 2]
    assert {t.motion.experiments[0].scenario.physics.step_rate for t in tasks} == {500.0, 1000.0}
    assert tasks[0].motion.experiments[0].recording is tasks[1].motion.experiments[0].recording


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            "axes: {speed: [1]}",
            "axes: found speed; expected revision, ground, step_rate, solver_iterations or a dotted",
        ),
        ("axes: {revision: [new]}", "axes.revision: found new; .* has under revisions: none"),
        ("axes: {step_rate: [500, 500]}", "axes.step_rate: a value stands twice"),
        ("axes: {robot.urdf: [arm.urdf]}", r"axes: robot.urdf is set by recordings.runs\[0\].with"),
        ("axes: {servos.arm.gain: [1]}", "there is no arm; expected one of drive"),
        ("axes: {step_rate: [500, abc]}", r"matrix.yaml: axes.step_rate\[1\]: found 'abc'; expected a number"),
        ("axes: {servos.drive.gain: -1}", r"matrix.yaml: axes.servos.drive.gain\[0\]: found -1; expected greater than"),
        ("axes: {ground: [flat, sand]}", r"matrix.yaml: axes.ground\[1\]: found 'sand'; expected 'none', 'flat' or"),
        ("axes: {servos.0.kind: [dc, pid]}", r"matrix.yaml: axes: servos\[0\].\w+: unknown key of kind pid"),
        (
            "axes: {physics.rate: [1], step_rate: [500, abc]}",
            "matrix.yaml: axes: physics.rate: unknown key",
        ),
        ("axes: {effects.0.torque: [1]}", "matrix.yaml: axes: effects.0.torque: there is no 0; effects holds none$"),
        ("axes: {physics.rate: [1]}", "physics.rate: unknown key; known here: solver_iterations, step_rate"),
        ("leave_out: [{rate: 3}]", r"leave_out\[0\]: rate is no axis of this matrix"),
        ("leave_out: [{engine: mujoko}]", r"leave_out\[0\].engine: found 'mujoko', which .* did you mean mujoco\?"),
        ("leave_out: [{engine: ode}, {recording: chrip_*}]", r"leave_out\[1\].recording: .* one of chirp_1; did you"),
        ("leave_out: [{scenario: damo}]", r"leave_out\[0\].scenario: found 'damo', which .* did you mean demo\?"),
        (
            "axes: {step_rate: [500, 1000]}\nleave_out: [{step_rate: [500, 100]}]",
            r"leave_out\[0\].step_rate: found 100, which matches nothing; expected one of 500, 1000",
        ),
        ("traces: maybe", "traces: found 'maybe'; expected 'whole' or true or false"),
        ("engines: [havok]", "engines: found havok; expected one of"),
        ("speed: 3", "speed: unknown key; known here: axes, "),
    ],
)
def test_what_is_wrong_is_one_sentence(write: Callable[..., list[Task]], text: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        write(f"{text}\n")


def test_a_scenario_that_is_not_there_is_told_with_its_key(tmp_path: Path) -> None:
    path = tmp_path / "matrix.yaml"
    path.write_text(f"name: test\nscenarios: [{DEMO}/scenario.yaml, none.yaml]\n")
    with pytest.raises(
        InputError, match=r"matrix\.yaml: scenarios\[1\]: .*none\.yaml does not exist; expected a scenario"
    ):
        load_matrix(path)


def keys(write: Callable[..., list[Task]], folder: Path) -> list[str]:
    return [t.key for t in write("engines: mujoco\n", folder)]


def test_a_key_does_not_depend_on_where_files_lie_or_what_they_say_besides(
    write: Callable[..., list[Task]], copy: Path
) -> None:
    urdf = copy / "arm.urdf"
    urdf.write_text(urdf.read_text().replace("</robot>", "<!-- the same arm --></robot>"))
    scenario = copy / "scenario.yaml"
    scenario.write_text(scenario.read_text() + "budget: {position: 1.0}\n")
    assert keys(write, copy) == keys(write, DEMO)


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("arm.urdf", '<mass value="', '<mass value="1'),
        ("scenario.yaml", "gain: 5.048", "gain: 5.049"),
        ("scenario.yaml", "effort: motor", "effort: joint"),
    ],
)
def test_a_key_changes_with_what_a_cell_depends_on(
    write: Callable[..., list[Task]], copy: Path, file: str, old: str, new: str
) -> None:
    path = copy / file
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    assert keys(write, copy) != keys(write, DEMO)


def test_a_key_changes_with_the_recording(write: Callable[..., list[Task]], copy: Path) -> None:
    shutil.copy(copy / "triangle_1.mcap", copy / "chirp_1.mcap")
    assert keys(write, copy) != keys(write, DEMO)


def test_a_further_recording_changes_no_key(write: Callable[..., list[Task]], copy: Path) -> None:
    scenario = copy / "scenario.yaml"
    scenario.write_text(scenario.read_text().replace("    - {path: triangle_1.mcap, use: train}\n", ""))
    assert keys(write, copy) == keys(write, DEMO)


@pytest.mark.parametrize(
    ("file", "kept"),
    [
        ("realitygap/cli/main.py", True),
        ("realitygap/report/page.py", True),
        ("realitygap/page/style.py", True),
        ("realitygap/diagnose/search/search.py", True),
        ("realitygap/matrix/plan.py", True),
        ("realitygap/page/web/page.css", True),
        ("realitygap/matrix/task.py", False),
        ("realitygap/simulate/rollout.py", False),
        ("realitygap/compare/gap.py", False),
        ("realitygap/recording/readers/rosbag.py", False),
        ("realitygap/trace/parquet.py", False),
        ("realitygap_engines/law/joints.py", False),
    ],
)
def test_cells_are_kept_until_code_that_computes_them_changes(tmp_path: Path, file: str, kept: bool) -> None:
    places = [Path(there(package.__file__)).parent for package in (realitygap_engines, realitygap)]
    copies = [shutil.copytree(p, tmp_path / p.name, ignore=shutil.ignore_patterns("__pycache__")) for p in places]
    before = code_digest(*copies)
    assert before == code_digest(*places)
    with (tmp_path / file).open("a") as changed:
        changed.write("# a change\n")
    assert (code_digest(*copies) == before) is kept
