"""Motions for a robot on its feet: it keeps them under every explanation, or the motion is not proposed."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.propose.condition import conditions
from realitygap.diagnose.propose.design import ENOUGH
from realitygap.diagnose.propose.excitation import BEFORE, Excitation, expected_floors, pose_of, with_motions
from realitygap.diagnose.propose.explanations import ELSE, Open, Question, shown
from realitygap.diagnose.propose.files import write_motion
from realitygap.diagnose.propose.limits import Limits
from realitygap.diagnose.propose.pool import builders, in_step, pool_of
from realitygap.diagnose.propose.proposal import Proposal
from realitygap.diagnose.propose.propose import propose
from realitygap.diagnose.propose.safe import left_in_engines
from realitygap.diagnose.propose.telling import telling
from realitygap.diagnose.propose.told import opened
from realitygap.scenario.file import load_scenario
from realitygap.scenario.propose import ProposeSpec
from realitygap.simulate.experiment import experiments, simulate
from realitygap.simulate.footing import lost_footing

FOOT = 0.24
"""How long the foot is [m]; it is half as wide."""
URDF = """<robot name="stander">
<link name="foot"><inertial><mass value="4"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.03"/></inertial>
<collision><geometry><box size="{long} 0.12 0.04"/></geometry></collision></link>
<link name="upper"><inertial><origin xyz="0 0 0.1"/><mass value="0.4"/>
<inertia ixx="0.002" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.0005"/></inertial></link>
<link name="lower"><inertial><origin xyz="0 0 0.08"/><mass value="0.2"/>
<inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.0002"/></inertial></link>
<joint name="hip" type="revolute"><parent link="foot"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="6" velocity="30"/></joint>
<joint name="knee" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 0.2"/>
<axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="6" velocity="30"/></joint></robot>"""
SERVO: dict[str, Any] = {
    "joints": "*",
    "kind": "dc",
    "gain": 4.0,
    "supply": 12.0,
    "torque_constant": 0.5,
    "resistance": 2.0,
    "armature": 0.01,
    "friction": {"coulomb": 0.05, "viscous": 0.02},
}
NAMES = ("hip", "knee")
USES = {"a": "train", "b": "train", "c": "held_out"}


def stander(folder: Path, long: float, pose: dict[str, float] | None = None) -> Problem:
    """A robot on one foot whose knee has less gain than its model, on small motions of both joints in step."""
    (folder / "robot.urdf").write_text(URDF.format(long=long), encoding="utf-8")
    wide = {"position": [-1.0, 1.0], "speed": 25.0}
    content: dict[str, Any] = {
        "name": "stander",
        "robot": {"urdf": "robot.urdf", "base": "floating"},
        "servos": [SERVO],
        "motion": {"recorded": "command"},
        "suspects": ["controller_gain@knee", "supply_voltage@knee"],
        "propose": {"pose": pose or {}, "limits": {"*": wide}, "forbid": ["multisine", "chirp", "hold"]},
        "recordings": {
            "columns": {what: {n: f"{what}_{n}" for n in NAMES} for what in ("command", "position")},
            "runs": [{"path": f"{name}.csv", "use": use} for name, use in USES.items()],
        },
    }
    time = np.arange(0, 3.0, 0.01)
    command = 0.12 * np.sin(3.0 * time)[:, None] * np.array([1.0, -0.5])
    (folder / "scenario.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    position = command
    own = {**content, "effects": [{"effect": "controller_gain", "target": "knee", "gain": 2.8}]}
    random = np.random.default_rng(1)
    for _ in range(2):
        for name in USES:
            noise = 5e-4 * random.standard_normal(position.shape)
            rows = np.column_stack([time, command, position + noise])
            head = ",".join(["time", *(f"command_{n}" for n in NAMES), *(f"position_{n}" for n in NAMES)])
            np.savetxt(folder / f"{name}.csv", rows, fmt="%.6f", delimiter=",", header=head, comments="")
        (truth,) = [e for e in experiments(load_scenario(own, folder)) if e.name == "a"]
        moved = simulate(truth, "mujoco").trace.at(time).position
        assert moved is not None
        position = moved
    return build_problem(load_scenario(folder / "scenario.yaml"), "mujoco")


@pytest.fixture(scope="module")
def standing(tmp_path_factory: pytest.TempPathFactory) -> Problem:
    """On a foot that is long enough."""
    return stander(tmp_path_factory.mktemp("standing"), FOOT)


@pytest.fixture(scope="module")
def left(standing: Problem) -> tuple[Open, Floors]:
    """What the recordings leave open, and the floors."""
    with Simulations(standing, 1) as simulations:
        return opened(simulations, None, lambda _: None)


def test_a_robot_keeps_its_feet_in_what_is_proposed(
    standing: Problem, left: tuple[Open, Floors], tmp_path: Path
) -> None:
    open_, floors = left
    assert open_.questions
    result = propose(standing, open_, floors, ["mujoco", "dart"], 8.0, 1, lambda _: None, 1)
    (proposed,) = result.proposed
    assert proposed.engines == ("mujoco", "dart")
    assert result.least(proposed) > max(abs(q.now) for q in open_.questions) + 1.0
    write_motion(result, proposed.motion, tmp_path)
    (played,) = experiments(load_scenario(tmp_path / f"{proposed.motion.name}.yaml"))
    for engine in ("mujoco", "dart"):
        trace = simulate(played, engine).trace.between(BEFORE, np.inf)  # it settles on its foot first
        assert result.limits.first(trace) is None
        assert len(lost_footing(played.plant.model, trace)) == 0


def test_of_a_small_foot_no_motion_is_proposed_that_tips_it(
    standing: Problem, left: tuple[Open, Floors], tmp_path: Path
) -> None:
    """The same robot on a foot on which its steps do not stand."""
    small = stander(tmp_path, 0.05)
    open_, floors = left
    result = propose(small, open_, floors, ["mujoco"], 8.0, 1, lambda _: None, 1)
    for proposed in result.proposed:
        assert "large" not in {s.label.split()[0] for s in proposed.motion.segments if s.kind == "step"}
        trace = simulate(result.problem.cases[proposed.case].experiment, "mujoco").trace
        assert len(lost_footing(small.plant.model, trace.between(0.0, np.inf))) == 0
    assert result.proposed or any("no motion within these limits" in note for note in result.notes)


def test_what_comes_behind_a_fall_is_not_blamed(left: tuple[Open, Floors], tmp_path: Path) -> None:
    """On a small foot a large step tips the robot, after which a small one finds it lying."""
    small = stander(tmp_path, 0.05)
    limits = Limits(*(np.full(2, x) for x in (-1.5, 1.5, 60.0, np.inf)))
    result = Proposal(small, left[0], limits, pose_of(small, {}))
    condition = conditions(small, ProposeSpec())[0]
    knee, both = builders(result)
    large, tiny = both.every(["step"])[0], knee.every(["step"])[2]
    for segments, bad in (((tiny, large, tiny), {1}), ((large, tiny), {0})):
        motion = Excitation("steps", segments, condition, both.period)
        assert left_in_engines(small, motion, left[0].explanations[:1], ["mujoco"], limits)[0] == bad


def test_few_pieces_are_looked_at_closely_and_they_part_explanations_most(
    standing: Problem, left: tuple[Open, Floors]
) -> None:
    open_, floors = left
    limits = Limits(*(np.full(2, x) for x in (-1.0, 1.0, 25.0, np.inf)))
    pool = pool_of(Proposal(standing, open_, limits, pose_of(standing, {})), ProposeSpec(forbid=["multisine"]))
    own, wide = len(standing.cases), with_motions(standing, pool)
    with Simulations(wide, 1) as simulations:
        rough, cases = expected_floors(wide, floors, own), range(own, own + len(pool))
        assert telling(simulations, open_, cases, rough) == list(cases)
        kept = telling(simulations, open_, cases, rough, 8)  # of two joints: four
        answers = [simulations.of(e.fit.changes, cases, coarse=rough.coarse) for e in open_.explanations]
        drawn = telling(simulations, replace(open_, questions=()), cases, rough, 8)
    assert len(kept) == len(drawn) == 4
    assert {pool[c - own].segments[0].joints for c in drawn} == {m.segments[0].joints for m in pool}
    for question in open_.questions:
        pairs = zip(answers[question.one], answers[question.other], strict=True)
        far = [float(np.abs(a["position"] - b["position"]).max()) for a, b in pairs if a and b]
        assert max(far[c - own] for c in kept) > 0.9 * max(far)
        assert min(far[c - own] for c in kept) > np.median(far)


def test_no_motion_is_made_for_what_the_recordings_settle(left: tuple[Open, Floors]) -> None:
    """A rival that no other question is about is no explanation any more: no motion is tried under it."""
    named = left[0].explanations[0]
    four = tuple(replace(named, evidence=named.evidence - k) for k in range(4))
    told = ((0, 1, -30.0), (0, 2, 2.0), (1, 3, 30.0), (0, 3, 30.0))
    questions = [Question(a, b, (f"model {a}", f"model {b}"), (), now) for a, b, now in told]
    open_ = Open(four, tuple(questions)).within(ENOUGH)
    assert open_.questions == (replace(questions[1], other=1),)
    assert open_.explanations == (four[0], four[2])


def test_what_the_recordings_show_already_is_said(left: tuple[Open, Floors]) -> None:
    question = Question(1, 0, ("supply voltage at knee", ELSE), (), 9.0)
    open_ = Open(left[0].explanations, (question, replace(question, names=("backlash at knee", ELSE), now=2.0)))
    assert shown(open_, 5.0) == ["supply voltage at knee"]


def test_a_robot_that_does_not_stand_where_motions_start_is_told_so(left: tuple[Open, Floors], tmp_path: Path) -> None:
    leaning = stander(tmp_path, 0.03, {"hip": 0.9})
    open_, floors = left
    result = propose(leaning, open_, floors, ["mujoco"], 8.0, 1, lambda _: None, 1)
    assert result.proposed == []
    assert any("does not keep its feet in the pose" in note for note in result.notes)


def test_joints_go_in_step_as_in_the_recordings(standing: Problem, left: tuple[Open, Floors]) -> None:
    home = pose_of(standing, {})
    ((along, name),) = in_step(standing, home)  # of three repetitions of one motion
    assert along == pytest.approx([1.0, -0.5], abs=1e-6)
    assert name == "all joints as in a"
    limits = Limits(*(np.full(2, x) for x in (-1.0, 1.0, 25.0, np.inf)))
    result = Proposal(standing, left[0], limits, home)
    single, both = builders(result)
    assert single.along == pytest.approx([0.0, 1.0])
    for segment in both.every(["step", "triangle"]):
        assert segment.value[:, 1] == pytest.approx(-0.5 * segment.value[:, 0], abs=1e-6)
        assert np.abs(segment.value).max() <= 1.0
        assert segment.joints == (0, 1)
