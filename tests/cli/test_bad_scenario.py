"""A scenario that is wrong: one sentence on standard error, exit status 2, and nothing written."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from spoiled import Edit, changed, cut, file, folder_instead, gone, one_sentence, refused, text


def copied(folder: Path) -> None:
    shutil.copy(folder / "chirp_1.mcap", folder / "chirp_2.mcap")
    changed(recordings__runs=[{"path": "chirp_1.mcap"}, {"path": "chirp_2.mcap"}])(folder)


def free_with_joints(folder: Path) -> None:
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    text('<link name="base"/>', f'<link name="base">{inertial}</link>')(folder)
    changed(robot__base="free")(folder)


RUN = "recordings__runs__0__"
KEYFRAMES = {"motion": {"keyframes": "move.json"}}
BOMB = "a: &a [x,x,x,x,x,x,x,x,x]\n" + "".join(
    f"{b}: &{b} [{','.join([f'*{a}'] * 9)}]\n" for a, b in zip("abcdefghij", "bcdefghijk", strict=True)
)
ENTITIES = '<!DOCTYPE r [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]><robot name="&b;"/>'
TABLE = pd.DataFrame({"time": [0.0, 0.1, 0.2], "position_shoulder": [0.0, 0.1, 0.2], "position_elbow": [0.0, 0.1, 0.2]})
COLUMNS = {"motion": None, "recordings__state": None, "recordings__effort": "none", RUN + "path": "run.csv"}


def table(frame: pd.DataFrame | str, encoding: str = "utf-8", **keys: object) -> Edit:
    content = (frame if isinstance(frame, str) else frame.to_csv(index=False)).encode(encoding)
    return file("run.csv", content, **(COLUMNS | keys))


def moved(**keyframe: object) -> Edit:
    content = {"keyframes": [{"duration": 1.0, "goals": {"elbow": 10.0}} | keyframe]}
    return file("move.json", json.dumps(content), **KEYFRAMES)


def lean(asymmetry: object, **more: object) -> Edit:
    sides = {"forward": 1, "backward": 1, "asymmetry": asymmetry}
    return changed(effects=[{"effect": "direction_friction"} | sides | more])


CASES: dict[str, tuple[Edit, str]] = {
    # the scenario file
    "no scenario": (gone("scenario.yaml"), "scenario.yaml: cannot be read (No such file"),
    "scenario is a folder": (
        folder_instead("scenario.yaml"),
        "scenario.yaml: is a folder; expected a scenario file, which",
    ),
    "scenario empty": (file("scenario.yaml", ""), "scenario.yaml: holds nothing, expected a mapping of keys"),
    "scenario a list": (file("scenario.yaml", "- a"), "holds a list, expected a mapping of keys"),
    "scenario malformed": (file("scenario.yaml", "robot: {"), "is not valid YAML at line 1"),
    "scenario with tabs": (file("scenario.yaml", "robot:\n\turdf: a\n"), "expected spaces in place of a tab"),
    "not a boolean": (changed(recordings={"virtual": "maybe"}), "found 'maybe'; expected true or false"),
    "scenario binary": (file("scenario.yaml", bytes(range(256))), "is not valid YAML"),
    "scenario of aliases": (file("scenario.yaml", BOMB), "its aliases stand for"),
    "scenario that holds itself": (file("scenario.yaml", "a: &a [*a]"), "line 1: a value holds itself"),
    "scenario nested": (file("scenario.yaml", "[" * 5000), "is nested too deeply"),
    "key twice": (file("scenario.yaml", "name: a\nname: b"), "at line 2: key 'name' stands twice"),
    "unknown key": (changed(robot__bse="fixed"), "robot.bse: unknown key; known here: base, "),
    "unknown key at the top": (changed(grund="flat"), "grund: unknown key"),
    "unknown key of a servo": (changed(servos__0__gian=1), "servos[0].gian: unknown key"),
    "keys of another kind of servo": (
        changed(servos=[{"joints": "*", "kind": "dc", "kp": 1.0, "kd": 0.1}]),
        "servos[0].kd: unknown key of kind dc, which belongs to kind pid; unknown too: kp; missing: gain, supply, "
        "torque_constant, resistance; known here: armature, duty_limit, friction, gain, joints, kind, name, "
        "resistance, supply, torque_constant\n",
    ),
    "unknown key in place of a missing one": (
        changed(robot={"urfd": "arm.urdf"}),
        "robot.urfd: unknown key; missing: urdf; known here: ",
    ),
    "missing key": (changed(robot={"base": "fixed"}), "robot.urdf: is missing; expected the robot's file"),
    "unknown servo": (changed(servos__0__kind="ac"), "servos[0].kind: found 'ac'; expected one of dc, pid, cascade"),
    "unknown unit": (changed(servos__0__supply="15 V"), "servos[0].supply: found '15 V'"),
    "a number that is true": (changed(servos__0__gain=True), "servos[0].gain: found true; expected a number"),
    "a number that is nan": (changed(servos__0__gain=float("nan")), "found nan; expected a finite number"),
    "step rate infinite": (changed(physics__step_rate=float("inf")), "physics.step_rate: found inf"),
    "step rate negative": (
        changed(physics__step_rate=-1000),
        "physics.step_rate: found -1000; expected greater than or equal to 10",
    ),
    "step rate beyond all memory": (changed(physics__step_rate=1e9), "physics.step_rate: found 1e+09, which makes"),
    "left out what is not there": (
        changed(recordings__exclude=["elbow", "nope"]),
        "scenario.yaml: recordings.exclude: nope matches no joint; the robot has shoulder, elbow",
    ),
    "a decimal comma": (changed(servos__0__gain="5,05"), "servos[0].gain: found '5,05'; expected a number, as 5.05 ("),
    "a decimal comma in braces": (
        file("scenario.yaml", "name: a\nservos: [{kind: pid, kp: 1,38, kd: 0.1}]\n"),
        "scenario.yaml: line 2: kp: found 1,38; expected a number with a decimal point, as 1.38\n",
    ),
    "a run that is a path alone": (
        changed(recordings__runs=["chirp_1.mcap"]),
        "recordings.runs[0]: found 'chirp_1.mcap'; expected a mapping, as {path: chirp_1.mcap} (",
    ),
    "a motion that is a topic alone": (
        changed(motion="/joint_commands"),
        "motion: found '/joint_commands'; expected a mapping, as {recorded: /joint_commands} (",
    ),
    "a window of one number": (
        changed(recordings__runs__0__window=3),
        "recordings.runs[0].window: found 3; expected a list of numbers ([start, end]: what is judged [s",
    ),
    "a recording that is none": (
        changed(recordings__runs__0__path="arm.urdf"),
        "scenario.yaml: recordings.runs[0].path: /",
    ),
    "an animation that is none": (
        changed(motion={"keyframes": "arm.urdf"}),
        "scenario.yaml: motion.keyframes: /",
    ),
    "unknown ground": (changed(ground="mud"), "ground: found 'mud'; expected 'none', 'flat' or 'grass'"),
    "ground damping alone": (
        changed(ground={"damping": 100}),
        "ground.damping: found 100; expected a stiffness beside it: without one the ground is rigid",
    ),
    "no suspects at all": (changed(suspects=[]), "suspects: found []; expected at least 1 item"),
    "ground damping negative": (changed(ground={"stiffness": 1e3, "damping": -1}), "ground.damping: found -1"),
    "servos that match nothing": (
        changed(servos__0__joints="knee_*"),
        "scenario.yaml: servos[0].joints: knee_* matches no joint; the robot has shoulder, elbow",
    ),
    "servos of a joint that is held": (
        changed(robot__hold={"elbow": 0.5}, servos=[{"joints": ["elbow"], "kind": "pid", "kp": 1.0}]),
        "servos[0].joints: elbow matches no joint that moves, as robot.hold holds elbow; the robot has shoulder\n",
    ),
    "two motions": (
        changed(motion={"recorded": "/a", "keyframes": "b"}),
        "expected one of recorded, keyframes and followed",
    ),
    "start of an unknown joint": (
        changed(robot__start={"knee": 0.1}),
        "robot.start: found joint 'knee'; the robot has",
    ),
    "start in degrees": (
        changed(robot__start={"elbow": 45}),
        "robot.start: elbow: found 45, which is outside the limits of elbow, -3.2 to 3.2 rad; degrees?",
    ),
    "start outside the limits": (
        changed(robot__start={"elbow": -400}),
        "robot.start: elbow: found -400, which is outside the limits of elbow, -3.2 to 3.2 rad\n",
    ),
    "hold in degrees": (
        changed(robot__hold={"elbow": 90}),
        "robot.hold: elbow: found 90, which is outside the limits of elbow, -3.2 to 3.2 rad; degrees?",
    ),
    "start of no keyframes": (changed(robot__start="keyframe"), "robot.start: found keyframe, but the motion has none"),
    "start is nan": (changed(robot__start={"elbow": float("nan")}), "robot.start.elbow: found nan"),
    "nothing to do": (changed(recordings=None, motion=None), "recordings.runs: found none"),
    "environment": (changed(robot__urdf="${NOT_SET}/arm.urdf"), "the environment variable NOT_SET is not set"),
    "no data folder": (
        changed(robot__urdf="${REALITYGAP_DATA}/arm.urdf"),
        "robot.urdf: the environment variable REALITYGAP_DATA is not set (the folder with the recordings)",
    ),
    # recordings
    "no recording": (changed(**{RUN + "path": "none.mcap"}), "recordings.runs[0].path: "),
    "pattern without match": (changed(**{RUN + "path": "none_*.mcap"}), "nothing matches"),
    "same run twice": (
        changed(recordings__runs=[{"path": "chirp_1.mcap"}, {"path": "chirp_*.mcap", "use": "held_out"}]),
        "recordings.runs[1]: ",
    ),
    "copy of a run": (copied, "holds the same measurement as"),
    "window outside": (
        changed(**{RUN + "window": [100, 200]}),
        "scenario.yaml: recordings.runs[0].window: found [100.0, 200.0], which holds 0 samples of",
    ),
    "window between two samples": (
        changed(**{RUN + "window": [1.0, 1.0001]}),
        "window: found [1.0, 1.0001], which holds 0",
    ),
    "window backwards": (
        changed(**{RUN + "window": [5, 2]}),
        "scenario.yaml: recordings.runs[0].window: found [5, 2]; expected a start before its end, [start, end] in s, ",
    ),
    "part without length": (
        changed(**{RUN + "part": [2, 2]}),
        "scenario.yaml: recordings.runs[0].part: found [2, 2]; expected a start before its end, [start, end] in s\n",
    ),
    "window with one end": (changed(**{RUN + "window": [1]}), "recordings.runs[0].window[1]: is missing"),
    "override of nothing": (
        changed(**{RUN + "with": {"servos.leg.gain": 2}}),
        "recordings.runs[0].with: servos.leg.gain: there is no leg; expected one of drive, *",
    ),
    "override with an unknown key": (
        changed(**{RUN + "with": {"servos.drive.gian": 2}}),
        "recordings.runs[0].with: servos[0].gian: unknown key",
    ),
    "override of what no servo has": (changed(**{RUN + "with": {"servos.*.kp": 2}}), "none of drive has kp"),
    "unknown topic": (changed(recordings__state="/states"), "has no topic /states; it has "),
    "unknown command topic": (changed(motion={"recorded": "/goals"}), "motion.recorded: "),
    "bag cut off": (cut("chirp_1.mcap", 0.5), "chirp_1.mcap: the bag cannot be read"),
    "bag empty": (file("chirp_1.mcap", b""), "chirp_1.mcap: the bag cannot be read"),
    "bag of noise": (file("chirp_1.mcap", os.urandom(2000)), "chirp_1.mcap: the bag cannot be read"),
    "bag is an empty folder": (folder_instead("chirp_1.mcap"), "is a folder without metadata.yaml"),
    "unknown kind of recording": (file("run.txt", "x", **{RUN + "path": "run.txt"}), "is not a kind of recording"),
    "joints that were not recorded": (text('"elbow"', '"knee"'), "knee"),
    "supply that was not recorded": (changed(servos__0__supply={"recorded": "/battery"}), "/battery"),
    "table empty": (table(""), "run.csv: is not a table"),
    "table in UTF-16 without a mark": (
        table(TABLE, encoding="utf-16-le"),
        "expected columns with a header line, saved as UTF-8",
    ),
    "table without rows": (table("time,position\n"), "run.csv: the table holds no rows"),
    "table without time": (table(TABLE.drop(columns="time")), "has no column time, named by recordings.columns.time"),
    "table without a joint": (table(TABLE.drop(columns="position_elbow")), "has no position of joint elbow"),
    "time goes back": (
        table(TABLE.assign(time=[0.0, 0.2, -9.0])),
        "time goes back from 0.2 to -9 s in line 4, expected times that increase: sort the rows",
    ),
    "time stands still": (table(TABLE.assign(time=[0.5] * 3)), "time is 0.5 s in all of its 3 rows; expected times"),
    "time is nan": (table(TABLE.assign(time=[0.0, np.nan, 0.2])), "time is empty in line 3, expected a time in s"),
    "text in a table": (table(TABLE.assign(position_elbow=["a", "b", "c"])), "position_elbow is 'a' in line 2"),
    "infinite position": (table(TABLE.assign(position_elbow=[0.0, "inf", 0.0])), "run.csv"),
    "positions missing": (
        table(TABLE.assign(position_elbow=[np.nan, np.nan, 0.0])),
        "2 of 3 samples are without the position of elbow (2); expected at least two",
    ),
    # the robot
    "no URDF": (changed(robot__urdf="none.urdf"), "scenario.yaml: robot.urdf: "),
    "URDF is a folder": (folder_instead("arm.urdf"), "arm.urdf: cannot be read (Is a directory)"),
    "a table for a URDF": (file("arm.urdf", "time,elbow\n"), "scenario.yaml: robot.urdf: "),
    "URDF empty": (file("arm.urdf", ""), "arm.urdf: is not well-formed XML"),
    "URDF cut off": (cut("arm.urdf", 0.5), "arm.urdf: is not well-formed XML"),
    "URDF with entities": (file("arm.urdf", ENTITIES), "arm.urdf: found XML entities"),
    "xacro": (file("arm.urdf", "<robot><xacro:if/></robot>"), "arm.urdf: is a xacro file"),
    "mass nan": (text('<mass value="', '<mass value="nan" was="'), "mass value is 'nan'"),
    "inertia that no body has": (text('ixx="', 'ixx="9" was="'), "which no body has"),
    "link that touches nothing": (changed(robot__contact_links=["foot"]), "has no link foot"),
    "stand on nothing": (changed(robot__stand_on="foot"), "robot.stand_on: found 'foot'; expected one of the links"),
    "a base that floats without mass": (
        changed(robot__base="floating"),
        "link base moves but has no mass; expected an <inertial> on it, or a base that is fixed",
    ),
    "a free body with joints": (free_with_joints, "robot.base: found free, but the robot has 2 joints"),
    # the motion
    "no animation": (
        changed(motion={"keyframes": "none.json"}),
        "none.json does not exist; expected an animation file",
    ),
    "no animation of a scenario": (changed(motion={"keyframes": "none.json"}), "scenario.yaml: motion.keyframes: "),
    "animation malformed": (file("move.json", "{", **KEYFRAMES), "move.json: is not valid JSON"),
    "animation nested": (file("move.json", "[" * 100000, **KEYFRAMES), "move.json: is nested too deeply"),
    "animation a list": (file("move.json", "[]", **KEYFRAMES), "move.json: holds a list"),
    "animation empty": (file("move.json", '{"keyframes": []}', **KEYFRAMES), "move.json: keyframes: found []"),
    "goal of an unknown joint": (moved(goals={"knee": 1.0}), "moves knee; the robot has shoulder, elbow"),
    "goal outside the limits": (moved(goals={"elbow": 400.0}), "puts elbow at 400°, outside its limits"),
    "goal nan": (moved(goals={"elbow": float("nan")}), "keyframes[0].goals.elbow: found nan"),
    "duration negative": (moved(duration=-1.0), "keyframes[0].duration: found -1.0"),
    # effects
    "unknown effect": (changed(effects=[{"effect": "friction"}]), "unknown effect friction; known: coulomb_friction"),
    "unknown target": (
        changed(effects=[{"effect": "coulomb_friction", "target": "knee", "torque": 0.1}]),
        "scenario.yaml: effects[0].target: no joint knee; the robot has shoulder, elbow",
    ),
    "unknown parameter": (
        changed(effects=[{"effect": "coulomb_friction", "force": 0.1}]),
        "effects[0].force: unknown parameter; coulomb_friction needs torque [N·m] and may have onset [rad/s], "
        "presliding [rad]\n",
    ),
    "parameter missing": (
        changed(effects=[{"effect": "command_delay", "time": 0.01}, {"effect": "coulomb_friction"}]),
        "scenario.yaml: effects[1].torque: is missing; coulomb_friction needs torque [N·m] and may have onset",
    ),
    "parameter with a unit": (
        changed(effects=[{"effect": "coulomb_friction", "torque": "0.1 Nm"}]),
        "effects[0].torque: found '0.1 Nm'; expected a number in N·m",
    ),
    "parameter out of bounds": (
        changed(effects=[{"effect": "coulomb_friction", "torque": -0.1}]),
        "effects[0].torque: found -0.1 N·m; expected 0 to",
    ),
    "parameter without a unit out of bounds": (lean(2), "effects[0].asymmetry: found 2; expected -1 to 1"),
    "parameter without a unit that is text": (lean("a"), "effects[0].asymmetry: found 'a'; expected a number\n"),
    "unknown parameter beside one without a unit": (
        lean(0, torque=1),
        "torque: unknown parameter; direction_friction needs forward [N·m], backward [N·m] and may have asymmetry, "
        "presliding [rad]\n",
    ),
    "parameter nan": (
        changed(effects=[{"effect": "coulomb_friction", "torque": float("nan")}]),
        "effects[0].torque: found nan",
    ),
    "effect twice": (
        changed(effects=[{"effect": "coulomb_friction", "target": t, "torque": 0.1} for t in ("elbow", "*")]),
        "effects[1]: coulomb_friction stands twice on *",
    ),
    "effects that exclude each other": (
        changed(
            effects=[
                {"effect": "coulomb_friction", "torque": 0.1},
                {"effect": "stribeck_friction", "static": 0.2, "coulomb": 0.1, "velocity": 0.1},
            ]
        ),
        "exclude each other on *",
    ),
    "effect without ground": (
        changed(effects=[{"effect": "ground_friction", "coefficient": 0.5}]),
        "scenario.yaml: effects[0]: ground_friction on *: ",
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_run_refuses(name: str, case: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("REALITYGAP_DATA", raising=False)
    edit, sentence = CASES[name]
    edit(case)
    before = sorted(case.rglob("*"))
    assert refused("run", case / "scenario.yaml", "--engine", "mujoco", "--out", case / "out") == 2
    said = one_sentence(capfd.readouterr())
    assert sentence in said
    assert str(case) in said, "names no file"
    assert sorted(case.rglob("*")) == before, "something was written"


@pytest.mark.parametrize("name", CASES)
def test_check_refuses_what_run_refuses(
    name: str, case: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the same words: of what is wrong with the scenario alone, and of what only its motions show."""
    monkeypatch.delenv("REALITYGAP_DATA", raising=False)
    edit, sentence = CASES[name]
    edit(case)
    assert refused("check", case / "scenario.yaml") == 2
    assert sentence.removeprefix("scenario.yaml: ") in "".join(capfd.readouterr())


@pytest.mark.parametrize("name", ["unknown key", "bag cut off"])
def test_the_installed_command_refuses(name: str, case: Path) -> None:
    edit, sentence = CASES[name]
    edit(case)
    command = [str(Path(sys.executable).with_name("realitygap")), "run", "scenario.yaml", "--engine", "mujoco"]
    done = subprocess.run(command, cwd=case, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert sentence in one_sentence((done.stdout, done.stderr))
    assert not (case / "results").exists()
