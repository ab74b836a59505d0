"""A first scenario from a URDF and recordings: it loads, its recordings read, and its guesses are the right ones."""

import json
import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from first_scenario import EPOCH, STATE, arm, messages, read_all
from jsonschema import Draft202012Validator
from lerobot_sets import data_set, motion
from realitygap.check import check
from realitygap.files.errors import InputError
from realitygap.files.yaml_file import load_yaml
from realitygap.init.draft import init, parse_packages
from realitygap.init.probe import JointStream
from realitygap.init.roles import lead
from realitygap.robot.plant import build_plant
from realitygap.scenario.file import load_scenario
from realitygap.scenario.servos import DcServo, PidServo
from realitygap_engines.errors import ModelError
from signals import Signals, there


@pytest.mark.parametrize("form", ["bag", "mcap", "db3"])
def test_what_is_written_loads_and_reads(form: str, tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    names = [f"{k}.bag" if form == "bag" else f"{k}" for k in range(3)]
    bags = [write_bag(tmp_path / name, form, messages(lag=0.05 + 1e-3 * k)) for k, name in enumerate(names)]
    path = init(arm(tmp_path / "arm.urdf"), bags, tmp_path / "scenarios" / "arm").path
    assert path == tmp_path / "scenarios" / "arm" / "scenario.yaml"
    text = path.read_text()
    assert str(tmp_path) not in text  # paths are relative to the file
    assert text.startswith("# yaml-language-server: $schema=scenario.schema.json\n")
    schema = json.loads((path.parent / "scenario.schema.json").read_text(encoding="utf-8"))
    assert Draft202012Validator(schema).is_valid(load_yaml(path)), "an editor would mark it"
    scenario, recordings = read_all(path, ["shoulder", "elbow"])
    assert there(scenario.recordings).state == "/joint_states"
    assert there(scenario.motion).recorded == "/joint_commands"
    assert [run.use for run in there(scenario.recordings).runs] == [None] * 3  # repetitions of one motion stay together
    assert scenario.robot.base == "fixed"
    assert scenario.ground_name == "none"
    (servo,) = scenario.servos
    assert isinstance(servo, PidServo)
    assert servo.kp == pytest.approx(30.0)
    assert all(len(r.trace.time) == 300 for r in recordings)
    for key in ("base", "kp", "kd", "state"):
        assert any(f"{key}:" in line and "GUESS" in line for line in text.splitlines())


@pytest.mark.parametrize("names", [("/a", "/b"), ("/b", "/a")])
@pytest.mark.parametrize("velocity", [True, False])
def test_where_names_say_nothing_the_command_comes_first(
    names: tuple[str, str], velocity: bool, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    state, command = names
    bag = write_bag(tmp_path / "run", "mcap", messages(state, command, velocity=velocity))
    path = init(arm(tmp_path / "arm.urdf"), [bag], tmp_path / "out").path
    scenario, _ = read_all(path, ["shoulder", "elbow"])
    assert (there(scenario.recordings).state, there(scenario.motion).recorded) == (state, command)
    assert "comes 50 ms before" in path.read_text()


def test_a_topic_of_commands_is_never_the_state(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    """Neither alone nor beside states that are all NaN."""
    sent = messages()
    alone = [message for message in sent if message[0] == "/joint_commands"]
    lost = [
        (topic, at, kind, {**m, "position": [np.nan] * 3} if topic == "/joint_states" else m)
        for topic, at, kind, m in sent
    ]
    urdf, out = arm(tmp_path / "arm.urdf"), tmp_path / "out"
    with pytest.raises(
        InputError, match=r"alone: the positions of /joint_commands are commands by name or type; expec"
    ):
        init(urdf, [write_bag(tmp_path / "alone", "mcap", alone)], out)
    with pytest.raises(InputError, match=r"lost: all positions of /joint_states are NaN or left out, and the posi"):
        init(urdf, [write_bag(tmp_path / "lost", "mcap", lost)], out)
    assert not out.exists()


def test_of_two_states_the_other_is_told(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    sent = messages()
    more = [("/arm/joint_states", *rest) for topic, *rest in sent if topic == "/joint_states"]
    draft = init(arm(tmp_path / "arm.urdf"), [write_bag(tmp_path / "run", "mcap", [*sent, *more])], tmp_path / "out")
    (state,) = [line for line in draft.guessed if line.startswith("state: ")]
    assert "/arm/joint_states" in state
    assert state.endswith("; there is also /joint_states)")


def test_a_command_that_is_a_duty_gets_a_motor(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    out = []
    for k in range(100):
        stamp = {"stamp": EPOCH + 0.01 * k, "name": ["elbow"]}
        out.append(("/joint_states", EPOCH + 0.01 * k, STATE, {**stamp, "position": [0.1 * k]}))
        out.append(("/duty_commands", EPOCH + 0.01 * k, STATE, {**stamp, "effort": [0.5]}))
        out.append(("/joint_currents", EPOCH + 0.01 * k, STATE, {**stamp, "effort": [0.7]}))
    path = init(
        arm(tmp_path / "arm.urdf", ("elbow",)), [write_bag(tmp_path / "run", "db3", out)], tmp_path / "out"
    ).path
    scenario, (recording,) = read_all(path, ["elbow"])
    assert (there(scenario.motion).recorded, there(scenario.motion).meaning) == ("/duty_commands", "duty")
    servo = scenario.servos[0]
    assert isinstance(servo, DcServo)
    assert isinstance(servo.supply, float)
    # stalls at the URDF's effort limit, runs free at its velocity limit
    assert servo.torque_constant * servo.supply / servo.resistance == pytest.approx(3.0, rel=0.01)
    assert servo.supply / servo.torque_constant == pytest.approx(6.0, rel=0.01)
    assert there(scenario.recordings).effort == "none"  # of a current nobody said the factor
    text = (tmp_path / "out" / "scenario.yaml").read_text()
    offered = next(line.partition("a current: ")[2] for line in text.splitlines() if "effort: none" in line)
    offered = offered.partition(" with ")[0].replace("FACTOR", "2.0")
    (tmp_path / "out" / "scenario.yaml").write_text(text.replace("effort: none", f"effort: {offered}"))
    _, (recording,) = read_all(tmp_path / "out" / "scenario.yaml", ["elbow"])
    np.testing.assert_allclose(Signals(recording.trace).effort, 1.4)


def test_a_robot_with_feet_floats_and_its_sensors_are_used(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    out = messages()
    for k in range(100):
        t = EPOCH + 0.03 * k
        turn = {"orientation": {"w": 1.0}}
        out.append(("/imu/data", t, "sensor_msgs/msg/Imu", {"stamp": t, **turn}))
        out.append(("/mocap", t, "geometry_msgs/msg/PoseStamped", {"stamp": t, "pose": turn}))
        out.append(("/power", t, "sensor_msgs/msg/BatteryState", {"stamp": t, "voltage": 12.0}))
    urdf = arm(tmp_path / "arm.urdf", feet=True)
    with_sensors = init(urdf, [write_bag(tmp_path / "one", "mcap", out)], tmp_path / "a").path
    scenario, (recording,) = read_all(with_sensors, ["shoulder", "elbow"])
    assert scenario.robot.base == "floating"
    assert (there(scenario.recordings).imu, there(scenario.recordings).pose) == ("/imu/data", "/mocap")
    np.testing.assert_allclose(Signals(recording.trace).supply, 12.0)
    without = init(urdf, [write_bag(tmp_path / "two", "mcap", messages())], tmp_path / "b").path
    assert load_scenario(without).scenario.robot.base == "floating"


def test_a_root_called_world_is_fixed(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    urdf = arm(tmp_path / "arm.urdf", feet=True, root="world")
    path = init(urdf, [write_bag(tmp_path / "run", "mcap", messages())], tmp_path / "out").path
    assert load_scenario(path).scenario.robot.base == "fixed"
    assert "the root link is called world" in path.read_text()


def test_the_terminal_hears_what_was_guessed_not_used_and_missing(
    tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    out = [*messages(), ("/tf", EPOCH, "tf2_msgs/msg/TFMessage", {}), ("/log", EPOCH, "std_msgs/msg/String", {})]
    bag = write_bag(tmp_path / "run", "mcap", out)
    lines = init(arm(tmp_path / "arm.urdf"), [bag], tmp_path / "out").lines()
    assert lines[0].startswith("wrote ")
    assert 'guessed: state: "/joint_states" (its name says state, it holds velocity)' in lines
    assert any(line.startswith("guessed: kp: 30 (the URDF's effort limit of 3") for line in lines)
    assert any(line.startswith("guessed: kd: 0.15 (") and "motion's held: false" in line for line in lines)
    assert "not used: /log (std_msgs/String), /tf (tf2_msgs/TFMessage)" in lines
    assert "note: no effort was found: torques are not compared" in lines


def test_the_next_command_can_be_copied(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    """Also where the path has what a shell would take apart."""
    bag = write_bag(tmp_path / "run", "mcap", messages())
    draft = init(arm(tmp_path / "arm.urdf"), [bag], tmp_path / "the arm's ($1)")
    command = shlex.split(draft.lines()[-1].removeprefix("next: "), comments=True)
    assert command[:5] == ["realitygap", "run", str(draft.path), "--engine", "mujoco"]


def test_before_the_next_command_stands_what_it_needs(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    """A run of a scenario that nothing drives is refused."""
    states = [m for m in messages() if m[0] == "/joint_states"]
    bag = write_bag(tmp_path / "run", "mcap", states)
    draft = init(arm(tmp_path / "arm.urdf"), [bag], tmp_path / "out")
    assert "drives_nothing" in [mistake.kind for mistake in check(load_scenario(draft.path))]
    last = draft.lines()[-1]
    assert last.startswith(f"next: say in {draft.path} what drives the joints: motion: {{recorded: COMMANDS}} or ")
    assert f"; then realitygap run {draft.path}" in last


@pytest.mark.parametrize("version", ["v2.1", "v3.0"])
def test_every_episode_of_a_data_set_is_a_run(version: str, tmp_path: Path) -> None:
    data_set(tmp_path / "set", version)
    draft = init(arm(tmp_path / "arm.urdf", ("elbow", "gripper")), [tmp_path / "set"], tmp_path / "out")
    scenario, recordings = read_all(draft.path, ["elbow", "gripper"])
    assert [run.episode for run in there(scenario.recordings).runs] == ["lift", "lower"]
    assert there(there(scenario.recordings).dataset).units == "degrees"
    for k, recording in enumerate(recordings):
        np.testing.assert_allclose(Signals(recording.trace).position, motion(k)[0], atol=2e-6)
    assert any("units: degrees (they fit" in line for line in draft.guessed)


def test_degrees_of_a_data_set_are_told_as_it_says_them(tmp_path: Path) -> None:
    urdf = arm(tmp_path / "arm.urdf", ("elbow", "gripper"))
    draft = init(urdf, [data_set(tmp_path / "set")], tmp_path / "out")
    found = check(load_scenario(draft.path).override({"recordings.dataset.units": "radians"}))
    degrees = [m for m in found if m.kind == "degrees" and m.key == "recordings.dataset.units"]
    assert degrees
    assert all("expected rad, or `units: degrees` under recordings.dataset" in m.sentence for m in degrees)


def test_units_and_names_of_a_data_set_are_guessed(tmp_path: Path) -> None:
    urdf = arm(tmp_path / "arm.urdf", ("elbow", "gripper"))
    radians = init(urdf, [data_set(tmp_path / "r", scale=1.0)], tmp_path / "a").path
    assert there(there(load_scenario(radians).scenario.recordings).dataset).units == "radians"
    wide = data_set(tmp_path / "w", scale=330.0, names="main_{}.pos")  # ±99, beyond ±30° and what the URDF allows
    urdf.write_text(urdf.read_text().replace('lower="-3" upper="3"', 'lower="-0.5" upper="0.5"'))
    normalized = there(there(load_scenario(init(urdf, [wide], tmp_path / "b").path).scenario.recordings).dataset)
    assert normalized.units == "normalized"
    assert normalized.range == {"elbow": (-0.5, 0.5), "gripper": (-0.5, 0.5)}
    assert normalized.joints == {"elbow": "main_elbow", "gripper": "main_gripper"}
    other = data_set(tmp_path / "o", names="{}_x")
    with pytest.raises(InputError, match=r"observation.state has elbow_x, gripper_x, which are not the joints of"):
        init(arm(tmp_path / "three.urdf", ("a", "b", "c")), [other], tmp_path / "c")


def test_packages_are_named_on_the_command_line(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    assert parse_packages([f"arm={tmp_path}"]) == {"arm": tmp_path}
    with pytest.raises(InputError, match=r"--package: found arm; expected NAME=DIR"):
        parse_packages(["arm"])
    bag = write_bag(tmp_path / "run", "mcap", messages())
    path = init(arm(tmp_path / "arm.urdf"), [bag], tmp_path / "out", {"arm": tmp_path / "meshes"}).path
    assert load_scenario(path).scenario.robot.packages == {"arm": "../meshes"}


@pytest.mark.parametrize("joints", [("shoulder", "elbow", "wrist"), ("finger", "shoulder", "elbow")])
def test_a_joint_that_was_not_recorded_is_held(
    joints: tuple[str, ...], tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    """At 0, or at the limit that is nearest to it."""
    urdf = arm(tmp_path / "arm.urdf", joints)
    urdf.write_text(urdf.read_text().replace('lower="-3"', 'lower="0.02"', 1))
    draft = init(urdf, [write_bag(tmp_path / "run", "mcap", messages())], tmp_path / "out")
    scenario, _ = read_all(draft.path, ["shoulder", "elbow"])
    assert scenario.robot.hold == ({"wrist": 0.0} if "wrist" in joints else {"finger": 0.02})
    assert any(line.startswith("hold: ") and "not recorded" in line for line in draft.guessed)
    assert build_plant(load_scenario(draft.path)).model.joint_names == ["shoulder", "elbow"]


def test_a_joint_that_is_commanded_and_not_measured_is_told(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    states = [m for m in messages(names=("shoulder",)) if m[0] == "/joint_states"]
    commands = [m for m in messages() if m[0] == "/joint_commands"]
    bag = write_bag(tmp_path / "run", "mcap", sorted([*states, *commands], key=lambda m: m[1]))
    draft = init(arm(tmp_path / "arm.urdf"), [bag], tmp_path / "out")
    assert draft.told[0].startswith("elbow is held where robot.hold says")
    assert "may have moved: it has /joint_commands" in draft.told[0]


def test_what_cannot_be_used_is_told_and_nothing_is_written(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    urdf = arm(tmp_path / "arm.urdf")
    good = write_bag(tmp_path / "good", "mcap", messages())
    power = {"stamp": EPOCH, "voltage": 12.0}
    power_only = write_bag(tmp_path / "power", "mcap", [("/power", EPOCH, "sensor_msgs/msg/BatteryState", power)])
    other = write_bag(tmp_path / "other", "mcap", messages(state="/states"))
    bare = write_bag(tmp_path / "bare", "mcap", messages(names=("shoulder",)))
    out = tmp_path / "out"
    legs = arm(tmp_path / "legs.urdf", ("hip",))
    cases = [
        (urdf, [power_only], r"no topic holds the positions of shoulder, elbow .*/power \(sensor_msgs/BatteryState\)"),
        (legs, [good], r"no topic holds the positions of hip .*; /joint_states names elbow, gripper, shoulder; expect"),
        (legs, [good], r"names as in the URDF: rename one or the other"),
        (urdf, [good, bare], r"bare: /joint_states: has no joint elbow; it has shoulder; .*robot.hold"),
        (urdf, [good, other], r"other has no topic /joint_states; it has .*/states"),
        (urdf, [], r"no recordings were given"),
        (tmp_path / "none.urdf", [good], r"none.urdf: cannot be read"),
    ]
    for robot, bags, sentence in cases:
        with pytest.raises(InputError, match=sentence):
            init(robot, bags, out)
        assert not out.exists()
    init(urdf, [good], out)
    with pytest.raises(InputError, match=r"scenario.yaml: is already there"):
        init(urdf, [good], out)


@pytest.mark.parametrize(
    ("urdf", "pattern", "base"),
    [
        ("sigmaban/robot.urdf", "sigmaban/kick_p*", "floating"),
        ("mx106_bench/arm_0w.urdf", "mx106_bench/chirp_*.bag", "fixed"),
        ("xl330_pendulum/pendulum.urdf", "xl330_pendulum/sin_sin_kp*", "fixed"),
        ("xl330_pendulum/pendulum.urdf", "sts3215_pendulum/sin_sin_m0.535_l0.10_kp16_rep*.csv", "fixed"),
        ("cube_toss/cube.urdf", "cube_toss/toss_00*.csv", "free"),
        ("xl330_pendulum/pendulum.urdf", "emps/*.csv", "fixed"),
        ("so101/so101.urdf", "so101", "fixed"),
        ("so101/so101.xml", "so101", "fixed"),
        ("ur10e/ur10e.urdf", "ur10e/free_*.csv", "fixed"),
    ],
)
def test_real_recordings(urdf: str, pattern: str, base: str, data_dir: Path, tmp_path: Path) -> None:
    path = init(data_dir / urdf, sorted(data_dir.glob(pattern)), tmp_path / "out").path
    scenario = load_scenario(path).scenario
    assert scenario.robot.base == base
    assert (scenario.motion is None) == (base == "free")


def test_missing_meshes_are_no_error_where_nothing_touches_the_ground(
    tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    urdf = arm(tmp_path / "arm.urdf")
    mesh = '<collision><geometry><mesh filename="package://nowhere/link.stl"/></geometry></collision>'
    urdf.write_text(urdf.read_text().replace('<link name="elbow_link">', f'<link name="elbow_link">{mesh}'))
    path = init(urdf, [write_bag(tmp_path / "run", "mcap", messages())], tmp_path / "out").path
    plant = build_plant(load_scenario(path))
    assert plant.ground is None
    assert not any("ground" in note for note in plant.model.notes)
    path.write_text(path.read_text().replace("ground: none", "ground: flat"))
    with pytest.raises(ModelError, match=r"mesh package://nowhere/link.stl of link elbow_link was not found"):
        build_plant(load_scenario(path))


def test_of_one_message_each_nothing_tells_which_topic_leads() -> None:
    one = JointStream("/a", "JointState", ("elbow",), np.array([0.1]), {"position": np.array([[0.2]])})
    assert lead(one, replace(one, topic="/b")) is None
