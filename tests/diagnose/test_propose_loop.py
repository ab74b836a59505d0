"""A proposal as a whole: from recordings that leave two explanations to files that play a motion within its limits."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import realitygap_engines as engines
import yaml
from realitygap.cli.main import app
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.propose.design import answer
from realitygap.diagnose.propose.excitation import Excitation, expected_floors, pose_of, with_motions
from realitygap.diagnose.propose.explanations import Open, Question
from realitygap.diagnose.propose.files import ProposalFile, summary, write_proposal
from realitygap.diagnose.propose.foreseen import Foreseen
from realitygap.diagnose.propose.limits import Limits
from realitygap.diagnose.propose.pool import pool_of
from realitygap.diagnose.propose.predict import predict
from realitygap.diagnose.propose.predicted_discrepancy import predicted_discrepancy
from realitygap.diagnose.propose.proposal import Proposal
from realitygap.diagnose.propose.propose import propose
from realitygap.diagnose.propose.safe import left_in_engines
from realitygap.diagnose.propose.told import Origin, mended, opened
from realitygap.diagnose.result.odds import MOST
from realitygap.diagnose.search.criterion import Criterion
from realitygap.files.errors import InputError
from realitygap.files.interrupted import Interrupted
from realitygap.robot.effects.place import place
from realitygap.scenario.file import load_scenario
from realitygap.scenario.propose import ProposeSpec
from realitygap.scenario.schema import EffectSpec
from realitygap.simulate.experiment import experiments, simulate
from typer.testing import CliRunner

URDF = """<robot name="pendulum"><link name="base"/>
<link name="arm"><inertial><origin xyz="0 0 -0.15"/><mass value="1.2"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/></inertial></link>
<joint name="elbow" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="12" velocity="8"/></joint></robot>"""
SERVO: dict[str, Any] = {
    "joints": "*",
    "kind": "dc",
    "gain": 6.0,
    "supply": 12.0,
    "torque_constant": 1.6,
    "resistance": 2.0,
}
USES = {"a": "train", "b": "train", "c": "held_out"}
FRICTION = {"coulomb": 0.1, "viscous": 0.05}


@pytest.fixture(scope="module")
def problem(tmp_path_factory: pytest.TempPathFactory) -> Problem:
    """A pendulum whose servo has less gain than its model, on a sine that never saturates it: gain or supply?"""
    folder = tmp_path_factory.mktemp("gain")
    (folder / "pendulum.urdf").write_text(URDF, encoding="utf-8")
    content = {
        "name": "gain",
        "robot": {"urdf": "pendulum.urdf", "base": "fixed"},
        "servos": [{**SERVO, "armature": 0.01, "friction": FRICTION}],
        "motion": {"recorded": "command"},
        "suspects": ["controller_gain", "supply_voltage"],
        "propose": {"limits": {"elbow": {"position": [-1.2, 1.2], "speed": 7.0}}, "forbid": ["multisine", "chirp"]},
        "recordings": {"virtual": True, "runs": [{"path": f"{name}.csv", "use": use} for name, use in USES.items()]},
    }
    time = np.arange(0, 4.0, 0.01)
    command = 0.3 * np.sin(3.0 * time)

    def table(position: np.ndarray, name: str) -> None:
        rows = "".join(f"{t:.3f},{c:.6f},{p:.6f}\n" for t, c, p in zip(time, command, position, strict=True))
        (folder / name).write_text("time,command,position\n" + rows, encoding="utf-8")

    for name in USES:
        table(command, f"{name}.csv")
    (folder / "scenario.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    file = load_scenario(folder / "scenario.yaml")
    own = {**content, "effects": [{"effect": "controller_gain", "target": "elbow", "gain": 4.2}]}
    (truth,) = [e for e in experiments(load_scenario(own, folder)) if e.name == "a"]
    moved = simulate(truth, "mujoco").trace.at(time).position
    random = np.random.default_rng(1)
    for name in USES:
        table(moved[:, 0] + 1e-3 * random.standard_normal(len(time)), f"{name}.csv")
    return build_problem(load_scenario(file.path), "mujoco")


@pytest.fixture(scope="module")
def left(problem: Problem) -> tuple[Open, Floors]:
    """What the recordings leave open, and the floors."""
    with Simulations(problem, 1) as simulations:
        return opened(simulations, None, lambda _: None)


def test_what_a_diagnosis_adjusted_stays_in_its_model_and_no_motion_is_asked_for_it(problem: Problem) -> None:
    def told(effect: str, name: str, value: float, discrepancy: float) -> dict[str, Any]:
        values = {"value": value, "low": value - discrepancy, "high": value + discrepancy}
        return {"effect": effect, "target": "elbow", "parameters": {name: values}}

    gain, supply = told("controller_gain", "gain", 4.4, 0.3), told("supply_voltage", "supply", 11.4, 0.5)
    changes = mended(problem, Origin(problem.file.path, "mujoco", [gain], (supply,)), problem.file.path)
    assert changes is not None
    assert [(c.suspect.effect, c.free) for c in changes] == [("controller_gain", ("gain",)), ("supply_voltage", ())]
    with Simulations(problem, 1) as simulations:
        left, _ = opened(simulations, changes, lambda _: None)
    (named, *_) = left.explanations
    assert [c.parameters["supply"] for c in named.fit.changes if c.suspect.effect == "supply_voltage"] == [11.4]
    assert [name for _, name in named.fit.names] == ["gain"]
    assert "supply voltage at elbow" not in {name for q in left.questions for name in q.names}


@pytest.fixture(scope="module")
def asked(problem: Problem, left: tuple[Open, Floors]) -> tuple[Open, Proposal, list[str]]:
    """What is open, the proposal, and what was said."""
    said: list[str] = []
    open_, floors = left
    result = propose(problem, open_, floors, ["mujoco", "dart"], 8.0, 1, said.append, 1)
    return open_, result, said


def test_what_one_motion_leaves_open_is_told_apart_by_the_proposed_one(asked: tuple[Open, Proposal, list[str]]) -> None:
    open_, result, said = asked
    assert {e for q in open_.questions for e in q.names} >= {"controller gain at elbow", "supply voltage at elbow"}
    (proposed,) = result.proposed
    assert proposed.motion.seconds <= 8.0
    assert proposed.engines == ("mujoco", "dart")
    done = simulate(result.problem.cases[proposed.case].experiment, "mujoco").trace
    assert done.command is not None
    assert done.position is not None
    assert np.nanmax(np.abs(done.command - done.position)) > 1.0 / SERVO["gain"]  # only saturation parts these two
    assert result.least(proposed) > max(abs(q.now) for q in open_.questions) + 3.0
    assert not {s.kind for s in proposed.motion.segments} & {"multisine", "chirp", "release"}
    assert any("pieces of motion" in line for line in said)


def test_files_say_and_play_what_was_designed(asked: tuple[Open, Proposal, list[str]], tmp_path: Path) -> None:
    _, result, _ = asked
    write_proposal(result, tmp_path)
    content = ProposalFile.model_validate(json.loads((tmp_path / "proposal.json").read_text(encoding="utf-8")))
    (told,) = content.motions
    assert all((tmp_path / name).is_file() for name in told.files.values())
    assert told.says in summary(result)[0]
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<svg" in page
    assert "Virtual recordings." in page
    assert '<td data-label="position">−68.8 to 68.8°</td>' in page, "limits as people write angles"
    (played,) = experiments(load_scenario(tmp_path / told.files["scenario"]))
    trace = simulate(played, "mujoco").trace
    assert trace.position is not None
    assert np.abs(trace.position).max() <= 1.2
    assert abs(trace.position[-1, 0] - result.home[0]) < 0.1
    (tmp_path / "mine.csv").write_text("", encoding="utf-8")
    write_proposal(replace(result, proposed=[]), tmp_path)
    assert not any((tmp_path / name).exists() for name in told.files.values())
    assert (tmp_path / "mine.csv").exists()


def test_pieces_are_slower_where_faster_ones_take_more_effort_than_there_is(
    problem: Problem, left: tuple[Open, Floors]
) -> None:
    open_, _ = left
    home, spec = pose_of(problem, {}), ProposeSpec(forbid=["chirp", "multisine"])
    strong, weak = (Limits(*(np.array([x]) for x in (-1.2, 1.2, 7.0, effort))) for effort in (np.inf, 1.0))
    fast, slow = (pool_of(Proposal(problem, open_, limits, home), spec) for limits in (strong, weak))
    assert {m.segments[0].maker.pace for m in fast} == {1.0}
    assert min(m.segments[0].maker.pace for m in slow) < 1.0
    assert len({m.segments[0].label for m in slow}) == len(slow)
    for motion in slow:
        assert left_in_engines(problem, motion, open_.explanations[:1], [problem.engine], weak)[0] == set()


def test_an_interrupt_while_multisines_are_fitted_leaves_the_best_so_far(
    problem: Problem, left: tuple[Open, Floors]
) -> None:
    def say(text: str) -> None:
        if "that were fitted" in text:
            raise Interrupted(2)

    open_, floors = left
    result = propose(problem, open_, floors, ["mujoco"], 8.0, 3, say, 1)
    assert result.ended is not None
    (proposed,) = result.proposed
    assert proposed.engines == ("mujoco",)
    assert any("ended early" in note for note in result.notes)


@pytest.mark.parametrize("engine", engines.available())
def test_a_segment_that_leaves_a_limit_is_found_in_every_engine(
    problem: Problem, left: tuple[Open, Floors], engine: str
) -> None:
    """Steps as wide as the limits allow overshoot them; small reversals do not."""
    wide, narrow = (Limits(*(np.array([x]) for x in (-r, r, v, np.inf))) for r, v in ((1.2, 50.0), (0.6, 50.0)))
    home, (open_, _) = pose_of(problem, {}), left
    pool = pool_of(Proposal(problem, open_, wide, home), ProposeSpec(forbid=["chirp", "multisine"]))
    segments = {m.segments[0].label: m for m in pool}
    first = segments["tiny steps"]
    both = Excitation("both", (first.segments[0], segments["large steps"].segments[0]), first.condition, first.period)
    assert left_in_engines(problem, both, open_.explanations, [engine], wide) == (set(), (engine,))
    assert left_in_engines(problem, both, open_.explanations, [engine], narrow) == ({1}, ())


def test_an_interruption_keeps_the_best_so_far(problem: Problem, left: tuple[Open, Floors]) -> None:
    open_, floors = left

    def say(text: str) -> None:
        if "as a whole" in text:
            raise Interrupted(2)

    result = propose(problem, open_, floors, ["mujoco"], 6.0, 1, say, 1)
    assert result.ended is not None
    assert len(result.proposed) == 1
    assert "ended early" in result.notes[-1]


def test_what_a_slow_motion_cannot_part_is_foreseen_to_stay_as_it_is(
    problem: Problem, left: tuple[Open, Floors]
) -> None:
    """A gain and a supply that never saturate do the same: nothing parts them, by lines and by foreseen recordings."""
    open_, floors = left
    limits = Limits(*(np.array([x]) for x in (-0.4, 0.4, 3.0, np.inf)))
    pool = pool_of(Proposal(problem, open_, limits, pose_of(problem, {})), ProposeSpec())
    (slow,) = [m for m in pool if m.segments[0].label == "narrow slow triangle"]
    wide, case, question = with_motions(problem, [slow]), len(problem.cases), gain_or_supply(open_)
    with Simulations(wide, 1) as simulations:
        rough = expected_floors(wide, floors, case)
        discrepancy = predicted_discrepancy(simulations, open_.explanations, suspects(wide), [case], rough)
        told = predict(simulations, open_.explanations, [case], rough, discrepancy)
        assert discrepancy is not None
        assert told is not None
        lines = answer(question, told.grams[0], told.beliefs)
        (seen,) = Foreseen(simulations, open_, told, rough, discrepancy, case).answers([question])
    assert seen is not None
    for a, b, now in ((lines.one, seen.one, question.now), (lines.other, seen.other, -question.now)):
        assert abs(a - now) < 0.5
        assert abs(b - now) < 1.0
    assert not seen.moves(question)
    assert seen.alike == (True, True)


def test_foreseen_odds_are_those_of_the_recording_that_follows(
    problem: Problem, left: tuple[Open, Floors], asked: tuple[Open, Proposal, list[str]], tmp_path: Path
) -> None:
    """The proposed motion is played by the true machine, and judged as a diagnosis judges: odds as they were told."""
    open_, result, _ = asked
    (proposed,), question = result.proposed, gain_or_supply(open_)
    foreseen = proposed.answers[open_.questions.index(question)]
    one, other = (open_.explanations[k].fit for k in (question.one, question.other))
    case = result.problem.cases[proposed.case]
    truth = {"effect": "controller_gain", "target": "elbow", "gain": 4.2}
    own = place(case.experiment.plant, [EffectSpec.model_validate(truth)])
    moved = simulate(case.experiment.with_plant(own), "mujoco").trace.at(case.measured.time).position
    noise = 1e-3 * np.random.default_rng(5).standard_normal(moved.shape)
    told = replace(case, measured=replace(case.measured, position=moved + noise), use="train")
    with Simulations(replace(problem, cases=(*problem.cases, told)), 1) as simulations:
        criterion = Criterion(simulations, one.changes)
        near = criterion.fit(one.changes)
        assert near is not None
        criterion.set_discrepancy(near.fit, criterion.responses(near.fit, suspects(problem)))
        both = [criterion.fit(f.changes) for f in (one, other)]
    found = [b.evidence for b in both if b is not None]
    first = one.changes[0].suspect.effect == "controller_gain"
    expected, realised = (foreseen.one, found[0] - found[1]) if first else (foreseen.other, found[1] - found[0])
    most = MOST * np.log(10.0)
    assert realised > 0.0
    assert abs(min(expected, most) - min(realised, most)) < np.log(10.0)


def gain_or_supply(open_: Open) -> Question:
    """What the sine leaves open."""
    both = {"controller gain at elbow", "supply voltage at elbow"}
    return next(q for q in open_.questions if set(q.names) == both)


def test_a_robot_without_recordings_gets_a_first_set_and_what_it_would_show(problem: Problem, tmp_path: Path) -> None:
    content = {k: v for k, v in problem.file.raw.items() if k not in ("recordings", "motion")}
    for path in problem.file.path.parent.glob("*.urdf"):
        (tmp_path / path.name).write_text(path.read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "first.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    out = tmp_path / "out"
    arguments = ["propose", str(tmp_path / "first.yaml"), "-e", "mujoco", "-o", str(out), "--seconds", "8", "-j", "1"]
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 0, done.exception
    told = ProposalFile.model_validate(json.loads((out / "proposal.json").read_text(encoding="utf-8")))
    assert [m.name for m in told.motions] == ["slow", "fast", "fine"]
    assert all(m.seconds <= 8.0 and m.stays_within_limits_in == ["mujoco"] for m in told.motions)
    assert {row["effect"] for row in told.shows} == {"controller_gain", "supply_voltage"}
    assert all(row["seen_from"] for row in told.shows)
    assert "controller gain at elbow: seen from" in done.output
    assert "What these motions would show" in (out / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"propose.limits": {}}, "nothing says how far and how fast elbow may go"),
        ({"robot.base": "floating", "ground": "none"}, "robots with servos, on a fixed base or on their feet"),
    ],
)
def test_what_cannot_be_proposed_for_is_one_sentence(
    problem: Problem, tmp_path: Path, change: dict[str, Any], sentence: str
) -> None:
    file = problem.file.override(change)
    raw = {k: v for k, v in file.raw.items() if k not in ("recordings", "motion")}
    urdf = URDF.replace('lower="-3" upper="3"', "").replace("revolute", "continuous")
    (tmp_path / "pendulum.urdf").write_text(urdf, encoding="utf-8")
    (tmp_path / "s.yaml").write_text(yaml.safe_dump(raw), encoding="utf-8")
    done = CliRunner().invoke(app, ["propose", str(tmp_path / "s.yaml"), "-o", str(tmp_path / "out")])
    assert isinstance(done.exception, InputError)
    assert sentence in str(done.exception)
    assert not (tmp_path / "out").exists()
