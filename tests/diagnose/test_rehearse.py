"""Rehearsal: what is planted is there, sizes that are said to be seen are seen, and twins are known as such."""

import csv
import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import yaml
from realitygap.cli.main import app
from realitygap.diagnose.candidates.suspects import neutral, suspects
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.gaps import cost
from realitygap.diagnose.likelihood.floors import Floors, measure
from realitygap.diagnose.rehearse.files import COLUMNS, searched_from, size, summary, to_json, write_rehearsal
from realitygap.diagnose.rehearse.page import sentence
from realitygap.diagnose.rehearse.planting import plant_recordings, planted
from realitygap.diagnose.rehearse.rehearse import Rehearsal, Tried, rehearse, searched
from realitygap.diagnose.rehearse.visible import Look, Visible, confusables, visible, within_law
from realitygap.diagnose.search.rivals import ODDS
from realitygap.files.errors import InputError
from realitygap.recording.quantum import quantum
from realitygap.robot.effects import EFFECTS
from realitygap.scenario.file import load_scenario
from synthetic_tosses import write_tosses
from typer.testing import CliRunner

URDF = """<robot name="pendulum"><link name="base"/>
<link name="arm"><inertial><origin xyz="0 0 -0.15"/><mass value="1.2"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/></inertial></link>
<joint name="elbow" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="12" velocity="8"/></joint></robot>"""
SERVO = {"joints": "*", "kind": "dc", "gain": 6.0, "supply": 12.0, "torque_constant": 1.6, "resistance": 2.0}
MOTIONS: dict[str, Callable[[Any], Any]] = {
    "sines": lambda t: 0.6 * np.sin(5 * t) + 0.3 * np.sin(11 * t),
    "steps": lambda t: 0.7 * np.sign(np.sin(5 * t)),
}
STEP = 1e-3
"""Quantum of the recorded angles [rad]."""


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One servo with a pendulum, two short motions; the recordings are the commands, roughly followed."""
    folder = tmp_path_factory.mktemp("pendulum")
    (folder / "pendulum.urdf").write_text(URDF, encoding="utf-8")
    random = np.random.default_rng(3)
    t = np.arange(0, 1.5, 0.01)
    for name, motion in MOTIONS.items():
        angle = np.round((motion(t) + 2e-3 * random.standard_normal(len(t))) / STEP) * STEP
        rows = [
            f"{a:.4f},{motion(a):.6f},{q:.4f},{random.normal(0, 0.05):.4f}"
            for a, q in zip(t.tolist(), angle.tolist(), strict=True)
        ]
        (folder / f"{name}.csv").write_text("time,command,position,effort\n" + "\n".join(rows), encoding="utf-8")
    content = {
        "name": "pendulum",
        "robot": {"urdf": "pendulum.urdf", "base": "fixed"},
        "servos": [{**SERVO, "armature": 0.01, "friction": {"coulomb": 0.1, "viscous": 0.05}}],
        "motion": {"recorded": "command"},
        "recordings": {
            "effort": "motor",
            "runs": [{"path": "sines.csv", "use": "train"}, {"path": "steps.csv", "use": "held_out"}],
        },
    }
    (folder / "scenario.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    return folder / "scenario.yaml"


@pytest.fixture(scope="module")
def problem(scenario: Path) -> Problem:
    """The problem of the scenario."""
    return build_problem(load_scenario(scenario), "mujoco")


@pytest.fixture(scope="module")
def simulations(problem: Problem) -> Iterator[Simulations]:
    """Its simulations, in this process."""
    with Simulations(problem, 1) as made:
        yield made


@pytest.fixture(scope="module")
def floors(simulations: Simulations) -> Floors:
    """The floors of its model."""
    return measure(simulations, [])


@pytest.fixture(scope="module")
def seen(simulations: Simulations, floors: Floors, problem: Problem) -> dict[str, Visible]:
    """Every effect's smallest size."""
    return {v.suspect.effect: v for v in visible(simulations, floors, suspects(problem), NEEDED)}


NEEDED = 6.0
"""The evidence that a name needs."""


def test_a_planted_size_lies_within_its_bounds_and_none_is_neutral(problem: Problem) -> None:
    for suspect in suspects(problem):
        effect, zero = EFFECTS[suspect.effect], neutral(problem.plant, suspect)
        for factor in (1e-3, 1.0, 64.0, 1e9):
            values = planted(problem, suspect, factor).parameters
            for p in effect.parameters:
                assert p.low <= values[p.name] <= p.high or values[p.name] == p.default
        moved = [p.name for p in effect.parameters if not p.shape and np.isfinite(zero[p.name]) and p.absent is None]
        small = planted(problem, suspect, 0.0 if moved else 1.0).parameters
        if effect.name not in ("soft_ground", "torque_speed_limit"):
            assert {n: small[n] for n in moved} == pytest.approx({n: zero[n] for n in moved})


def test_planted_recordings_keep_stamps_quantum_and_noise(problem: Problem, floors: Floors) -> None:
    recorded = plant_recordings(problem, floors, [], "mujoco", seed=1)
    for old, new in zip(problem.cases, recorded.cases, strict=True):
        np.testing.assert_array_equal(new.measured.time, old.measured.time)
        np.testing.assert_array_equal(new.measured.command, old.measured.command)
        assert quantum(new.value("position"))[0] == pytest.approx(STEP, rel=1e-6)
        assert new.use == old.use
    with Simulations(recorded, 1) as own:
        answers = own.of([], range(len(recorded.cases)))
    gaps = [np.sqrt(cost(recorded, floors, i, a)) for i, a in enumerate(answers)]
    assert all(0.6 < g < 1.15 for g in gaps)  # as far apart as noise and rounding


def test_the_same_seed_is_the_same_noise(problem: Problem, floors: Floors) -> None:
    a, b, c = (plant_recordings(problem, floors, [], "mujoco", seed=s).cases[0].value("position") for s in (1, 1, 2))
    np.testing.assert_array_equal(a, b)
    assert not np.array_equal(a, c)


def test_a_disturbing_torque_moves_the_robot_and_not_the_model(problem: Problem, floors: Floors) -> None:
    still = plant_recordings(problem, floors, [], "mujoco", seed=1).cases[0].value("position")
    shaken = replace(floors, torque=np.array([1.0]))
    pushed = plant_recordings(problem, shaken, [], "mujoco", seed=1).cases[0].value("position")
    assert np.sqrt(np.mean((still - pushed) ** 2)) > 5 * STEP


@pytest.mark.parametrize(
    "effect", ["coulomb_friction", "backlash", "command_delay", "link_mass", "torque_constant", "joint_compliance"]
)
def test_what_is_said_to_be_seen_shows_and_a_third_of_it_hardly(
    simulations: Simulations, floors: Floors, problem: Problem, seen: dict[str, Visible], effect: str
) -> None:
    """By the definition: half the whitened square of its signature is the evidence that it gives."""
    found = seen[effect]
    assert found.seen
    look = Look(simulations, floors)
    third, there, more = look.signatures([planted(problem, found.suspect, found.factor * k) for k in (1 / 3, 1, 3)])
    given = [0.5 * float(x @ x) for x in (third, there, more)]
    assert given[0] < NEEDED < given[1] < given[2]


def test_what_never_acts_is_never_seen(problem: Problem, seen: dict[str, Visible]) -> None:
    change = seen["torque_speed_limit"].change
    assert change.parameters["stall_torque"] > 0
    assert "ground_friction" not in seen
    assert all(v.signature.any() for v in seen.values() if v.seen)


def test_twins_are_known_and_different_things_are_not_taken_for_each_other(seen: dict[str, Visible]) -> None:
    pairs = {(c.planted.effect, c.other.effect): c for c in confusables(list(seen.values()))}
    assert pairs["rotor_inertia", "link_inertia"].apart_from == np.inf
    assert pairs["joint_offset", "base_tilt"].share > 0.98
    assert pairs["coulomb_friction", "stribeck_friction"].share > 0.98  # nested
    assert pairs["backlash", "command_delay"].share < 0.7
    assert pairs["link_mass", "coulomb_friction"].share < 0.7
    assert all(0.0 <= c.share <= 1.0 + 1e-9 for c in pairs.values())
    for c in pairs.values():
        found = seen[c.planted.effect]
        if np.isfinite(c.apart_from):  # what is left at that size is as much as two rivals may differ by
            whole = 0.5 * float(found.signature @ found.signature)
            assert whole * (c.apart_from / found.factor) ** 2 * (1 - c.share) == pytest.approx(ODDS, rel=0.01)


def test_a_full_search_names_what_was_planted_in_another_engine(
    problem: Problem, floors: Floors, seen: dict[str, Visible]
) -> None:
    friction = seen["viscous_friction"]
    rehearsal = Rehearsal(problem, "dart", (1.0, 1.0), floors)
    size = 6 * friction.factor  # far beyond what laws may be off by, because the motion is short
    tried = searched(2, rehearsal, planted(problem, friction.suspect, size), size)
    assert tried is not None
    assert tried.outcome == "named"
    assert tried.named == (friction.suspect,)


def test_a_rehearsal_says_what_it_planted_and_what_it_saw(
    simulations: Simulations, problem: Problem, tmp_path: Path
) -> None:
    heard: list[str] = []
    result = rehearse(simulations, ["dart"], 10.0, heard.append)
    write_rehearsal(result, tmp_path)
    content = json.loads((tmp_path / "rehearsal.json").read_text(encoding="utf-8"))
    assert content["engines"] == {"search": "mujoco", "robot": "dart"}
    assert content["synthetic"] is True
    searches = [t for t in content["searches"] if t["planted"]]
    named = sum(t["outcome"] == "named" for t in searches)
    assert not searches or f"{len(searches)} full search" in summary(result)[0]
    assert f"{named} named it" in summary(result)[0] or not named
    assert content["nothing_planted"]["held_out"] < 1.2
    assert "ground_friction" in content["impossible"]
    assert {r["effect"] for r in content["detection"]} == {s.effect for s in suspects(problem)}
    friction = next(r for r in content["detection"] if r["effect"] == "coulomb_friction")
    size = friction["seen_from"]["torque"]
    assert size["model"] == pytest.approx(0.1)
    assert size["change"] == pytest.approx(size["value"] - 0.1, rel=1e-3)
    with (tmp_path / "rehearsal.csv").open(encoding="utf-8") as file:
        rows = list(csv.reader(file))
    assert tuple(rows[0]) == COLUMNS
    assert len(rows) == len(content["detection"]) + 1
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Synthetic data." in page
    assert "<script" not in page
    assert "http" not in page.replace("http://www.w3.org", "")
    assert content["searches"][0]["planted"] is None
    assert content["searches"][0]["outcome"] == "nothing"
    assert any("planting" in line for line in heard)
    assert any("coulomb friction at elbow: shows from" in line for line in summary(result))
    assert to_json(result) == content


def test_an_engine_that_plays_the_robot_itself_is_told_by_its_name(simulations: Simulations) -> None:
    result = rehearse(simulations, [], 5.0, lambda _: None)
    assert result.robot == "mujoco"
    assert any(note.startswith("MuJoCo plays the robot itself") for note in result.notes)


def test_a_search_counts_only_where_all_larger_sizes_were_right(problem: Problem) -> None:
    first = suspects(problem)[0]

    def tried(factor: float, right: bool) -> Tried:
        return Tried(planted(problem, first, factor), factor, (first,) if right else (), ())

    assert searched_from([tried(1.0, True), tried(2.0, True)]) == 1.0
    assert searched_from([tried(1.0, True), tried(2.0, False), tried(4.0, True)]) == 4.0
    assert searched_from([tried(2.0, False)]) == np.inf
    assert Tried(None, 0.0, (), ()).right
    assert not Tried(None, 0.0, (first,), ()).right


def test_the_headline_tells_what_full_searches_named(
    problem: Problem, floors: Floors, seen: dict[str, Visible]
) -> None:
    result = Rehearsal(problem, "dart", (1.0, 1.0), floors, found=list(seen.values()))
    assert "the time was too short for a full search" in sentence(result)
    found = seen["coulomb_friction"]
    change, other = planted(problem, found.suspect, 2 * found.factor), seen["backlash"].suspect

    def tried(*named: Suspect) -> Tried:
        return Tried(change, 2 * found.factor, named, ())

    result.tried = [Tried(None, 0.0, (), ()), tried(found.suspect)]
    assert sentence(result).endswith(
        ". Of 1 full search for an effect of 2 times the smallest size that shows, 1 named it."
    )
    result.tried += [tried(), tried(), tried(other)]
    assert sentence(result).endswith(
        ". A diagnosis names fewer, because no law is exact: of 4 full searches for an effect of 2 times the smallest "
        "size that shows, 1 named it, 1 took it for something else and 2 named nothing."
    )


def test_what_laws_are_off_by_anyway_is_told_as_such(
    problem: Problem, floors: Floors, seen: dict[str, Visible]
) -> None:
    friction = seen["coulomb_friction"]
    model = neutral(problem.plant, friction.suspect)["torque"]
    shares = {}
    for share in (0.01, 0.07, 0.09, 0.5):
        change = Change(
            friction.suspect, (("torque", model * (1 + share)), ("onset", 0.0), ("presliding", 0.0)), ("torque",)
        )
        shares[share] = within_law(problem, change)
        result = Rehearsal(problem, "dart", (1.0, 1.0), floors, found=[replace(friction, change=change)])
        told = next(line for line in summary(result) if line.startswith("  coulomb friction at elbow"))
        assert (", within the 8 % that such laws are off by" in told) == (share < 0.08)
    assert shares == {0.01: 0.08, 0.07: 0.08, 0.09: 0.0, 0.5: 0.0}
    assert within_law(problem, seen["backlash"].change) == 0.0, "a model has nothing of it that could be off"


def test_no_time_is_an_error_and_writes_nothing(scenario: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    result = CliRunner().invoke(app, ["rehearse", str(scenario), "--out", str(out), "--budget", "0"])
    assert isinstance(result.exception, InputError)
    assert "--budget: found 0, expected seconds above 0" in str(result.exception)
    assert not out.exists()


def test_a_rigid_ground_has_no_stiffness_to_write_down(tmp_path: Path) -> None:
    problem = build_problem(load_scenario(write_tosses(tmp_path, 0.17)), "mujoco")
    soft = next(s for s in suspects(problem) if s.effect == "soft_ground")
    written = size(cast(Rehearsal, SimpleNamespace(problem=problem)), soft, 1.0)
    assert written["stiffness"]["model"] is None
    json.dumps(written, allow_nan=False)
