"""Diagnosis on the bundled synthetic scenario: the planted effect is named, and nothing where nothing is missing."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from realitygap.diagnose.candidates.starts import guess, starts
from realitygap.diagnose.candidates.suspects import building_up, in_shape_of, neutral, richer, suspects
from realitygap.diagnose.data.changes import Change, Suspect, changed
from realitygap.diagnose.data.noise import local_maximum, repetition_noise, shared_noise
from realitygap.diagnose.data.problem import build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.gaps import costs, rms
from realitygap.diagnose.likelihood.disturbance import LIKELY, disturbances, sensitivities, spread
from realitygap.diagnose.likelihood.floors import measure
from realitygap.diagnose.propose.told import opened
from realitygap.diagnose.rehearse.rehearse import rehearse
from realitygap.diagnose.rehearse.visible import visible
from realitygap.diagnose.result.summary import summary
from realitygap.diagnose.result.workflow import run_diagnosis
from realitygap.diagnose.search.search import search
from realitygap.diagnose.search.simpler import simpler
from realitygap.diagnose.search_budget import SearchBudget
from realitygap.files.errors import InputError
from realitygap.files.progress import Progress
from realitygap.recording.noise import own_noise
from realitygap.scenario.file import load_scenario

DEMO = Path(__file__).parents[2] / "scenarios" / "demo" / "scenario.yaml"
PLANTED = 0.6447
"""Coulomb friction of the recorded elbow [N·m]; the model has 0.2756."""


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, object]]:
    """The demo's diagnosis in MuJoCo, confirmed in DART, and what it says."""
    out = tmp_path_factory.mktemp("diagnosis")
    result = run_diagnosis(DEMO, ["mujoco", "dart"], out, Progress(quiet=True), workers=2)
    assert any("coulomb_friction" in line for line in summary(result))
    return out, json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))


def test_the_planted_effect_is_named_and_nothing_else(diagnosed: tuple[Path, dict[str, Any]]) -> None:
    _, said = diagnosed
    assert [(f["effect"], f["target"]) for f in said["findings"]] == [("coulomb_friction", "elbow")]
    assert said["verdict"] == "explained"
    value = said["findings"][0]["parameters"]["torque"]
    assert value["value"] == pytest.approx(PLANTED, rel=0.05)
    assert value["low"] < value["value"] < value["high"]


def test_it_is_judged_on_held_out_runs_and_in_another_engine(diagnosed: tuple[Path, dict[str, Any]]) -> None:
    _, said = diagnosed
    assert said["gap"]["held_out"]["after"] < 1.3 < said["gap"]["held_out"]["before"]
    finding = said["findings"][0]
    assert finding["engines"]["dart"]["after"] < 0.5 * finding["engines"]["dart"]["before"]
    assert said["where"][0]["joint"] == "elbow"


def test_the_mended_model_runs_and_has_no_gap_left(diagnosed: tuple[Path, dict[str, Any]]) -> None:
    out, _ = diagnosed
    problem = build_problem(load_scenario(out / "revised" / "scenario.yaml"), "mujoco")
    with Simulations(problem, 2) as simulations:
        found = search(simulations, suspects(problem), [], lambda _: None)
        judge = problem.of("held_out")
        gap = rms(costs(simulations, found.floors, [], judge), judge)
    assert found.best.fit.changes == ()
    assert gap < 1.25


def test_a_search_that_has_no_time_proves_what_it_found_first() -> None:
    """The friction is found in the first round; what would be lost without it is told, and that more may be missing.

    Without the effort, by which it is found before that round.
    """
    problem = build_problem(load_scenario(DEMO).override({"recordings.effort": "none"}), "mujoco")
    with Simulations(problem, 2) as simulations:
        found = search(simulations, suspects(problem), [], lambda _: None, SearchBudget(steps=0.0))
    assert found.cut
    assert {c.suspect.effect for c in found.best.fit.changes} == {"coulomb_friction"}
    (gain,) = found.gains.values()
    assert gain > found.limit


def test_every_suspect_can_be_neutral() -> None:
    problem = build_problem(load_scenario(DEMO), "mujoco")
    everyone = suspects(problem)
    assert {s.effect for s in everyone} >= {"coulomb_friction", "backlash", "link_mass", "command_delay"}
    for suspect in everyone:
        zero = neutral(problem.plant, suspect)
        assert set(zero) == {p.name for p in suspect.kind.parameters}
        plant = changed(problem.plant, [Change(suspect, tuple(zero.items()))], problem.plant)
        same = {n: v for n, v in zero.items() if suspect.kind.parameter(n).absent is None}
        own = suspect.kind.own(plant, suspect.indices[0])
        assert {n: own[n] for n in same if n in own} == pytest.approx({n: same[n] for n in same if n in own})


def test_a_target_is_told_as_people_know_it() -> None:
    assert Suspect("coulomb_friction", "elbow", (1,)).where == "elbow"
    assert Suspect("coulomb_friction", ("hip", "knee"), (0, 1)).where == "hip, knee"
    assert Suspect("coulomb_friction", ("hip", "knee"), (0, 1), "mx106").where == "the 2 joints of servo mx106"


def test_friction_under_load_is_the_same_at_rest_when_its_shape_is_freed() -> None:
    problem = build_problem(load_scenario(DEMO), "mujoco")
    plain = {s.effect: guess(problem, s) for s in suspects(problem) if s.target == "elbow"}
    found = plain["load_dependent_friction"]
    freed = richer(problem.plant, found)
    assert freed is not None
    values = freed.parameters
    assert values["coefficient"] + values["static_coefficient"] == pytest.approx(found.parameters["coefficient"])
    assert set(freed.free) > set(found.free)
    assert richer(problem.plant, plain["viscous_friction"]) is None
    assert richer(problem.plant, freed) == freed  # what has a shape goes on from it


def test_dry_friction_with_a_shape_begins_to_grow_slowly() -> None:
    """All there at once, no derivative would say over which speed it grows from rest."""
    problem = build_problem(load_scenario(DEMO), "mujoco")
    (friction,) = (s for s in suspects(problem) if (s.effect, s.target) == ("coulomb_friction", "elbow"))
    freed = richer(problem.plant, guess(problem, friction))
    assert freed is not None
    assert freed.free == ("torque", "onset")
    assert 0.0 < freed.parameters["onset"] < 1.0
    assert guess(problem, friction).free == ("torque",)


def test_friction_that_builds_up_begins_as_joints_give_and_is_no_other_shape() -> None:
    problem = build_problem(load_scenario(DEMO), "mujoco")
    plain = {s.effect: guess(problem, s) for s in suspects(problem) if s.target == "elbow"}
    dry, by_side, falling = (plain[n] for n in ("coulomb_friction", "direction_friction", "stribeck_friction"))
    grows, builds = richer(problem.plant, dry), building_up(problem.plant, dry)
    assert grows is not None
    assert builds is not None
    assert builds.free == ("torque", "presliding")
    assert builds.parameters == dry.parameters | {"presliding": 1e-3}
    assert building_up(problem.plant, grows) == builds, "one shape in the place of another"
    assert building_up(problem.plant, builds) == builds
    assert building_up(problem.plant, falling) is None
    shaped = in_shape_of(by_side, builds)
    assert shaped.free == ("forward", "backward", "presliding")
    assert shaped.parameters == by_side.parameters | {"presliding": 1e-3}
    assert in_shape_of(by_side, dry) == in_shape_of(by_side, grows) == by_side
    assert in_shape_of(falling, builds) == falling, "it has no such shape"
    assert in_shape_of(plain["load_dependent_friction"], falling) == plain["load_dependent_friction"]


def test_an_effect_that_the_scenario_has_is_neutral_at_its_own_value() -> None:
    file = load_scenario(DEMO).override({"effects": [{"effect": "constant_effort", "target": "elbow", "effort": 0.2}]})
    problem = build_problem(file, "mujoco")
    push = next(s for s in suspects(problem) if (s.effect, s.target) == ("constant_effort", "elbow"))
    assert neutral(problem.plant, push) == {"effort": 0.2}


@pytest.mark.parametrize(
    ("prismatic", "armature", "first"), [(False, 0.0, "rotor"), (True, 0.0, "mass"), (True, 0.1, "rotor")]
)
def test_inertia_of_a_linear_axis_is_its_mass(prismatic: bool, armature: float, first: str) -> None:
    """Unless the model has a rotor there already."""
    problem = build_problem(load_scenario(DEMO), "mujoco")
    plant = problem.plant
    plant.model = replace(plant.model, joints=tuple(replace(j, prismatic=prismatic) for j in plant.model.joints))
    plant.drive["armature"] = armature
    rotor, mass = Suspect("rotor_inertia", "elbow", (1,)), Suspect("link_mass", "forearm", (2,))
    assert simpler(problem, rotor, mass) == (first == "rotor")


def test_a_change_keeps_its_ratio_where_runs_differ() -> None:
    problem = build_problem(load_scenario(DEMO), "mujoco")
    forearm = next(s for s in suspects(problem) if s.effect == "link_mass" and s.target == "forearm")
    heavy = next(
        c for c in problem.cases if c.experiment.plant.model.mass != problem.cases[1].experiment.plant.model.mass
    )
    reference = problem.plant
    own = reference.model.links[forearm.indices[0]].mass
    mended = changed(heavy.experiment.plant, [Change(forearm, (("mass", 1.1 * own),))], reference)
    before = heavy.experiment.plant.model.links[forearm.indices[0]].mass
    assert mended.model.links[forearm.indices[0]].mass == pytest.approx(1.1 * before)


def test_noise_of_a_signal_and_of_repetitions() -> None:
    rng = np.random.default_rng(1)
    t = np.linspace(0, 5, 1000)[:, None]
    clean = np.sin(2 * t)
    values = [clean + 0.01 * rng.standard_normal((1000, 1)) for _ in range(4)]
    assert own_noise(values[0])[0] == pytest.approx(0.01, rel=0.15)
    assert repetition_noise(values)[0] == pytest.approx(0.01, rel=0.1)
    quantum = 0.002
    assert own_noise(np.round(clean / quantum) * quantum)[0] >= quantum / np.sqrt(12) * 0.99


def test_a_sensor_that_never_moves_is_as_noisy_as_its_kind() -> None:
    moving, resting = np.array([0.01, 0.03, 0.0]), np.array([0.02, 0.0, 0.0])
    first, second = shared_noise([moving, resting])
    assert first.tolist() == pytest.approx([0.01, 0.03, 0.02])  # never seen to move: the median of the others
    assert second.tolist() == pytest.approx([0.02, 0.03, 0.02])
    assert shared_noise([np.zeros(2)])[0].tolist() == [0.0, 0.0]


def variant(tmp_path: Path, change: Callable[[list[dict[str, Any]]], object], **recordings: object) -> Path:
    """The demo's scenario with other runs."""
    raw = yaml.safe_load(DEMO.read_text(encoding="utf-8"))
    raw["robot"]["urdf"] = str(DEMO.parent / raw["robot"]["urdf"])
    for run in raw["recordings"]["runs"]:
        run["path"] = str(DEMO.parent / run["path"])
        if "robot.urdf" in run.get("with", {}):
            run["with"]["robot.urdf"] = str(DEMO.parent / run["with"]["robot.urdf"])
    change(raw["recordings"]["runs"])
    raw["recordings"] |= recordings
    path = tmp_path / "scenario.yaml"
    path.write_text(yaml.safe_dump(raw), encoding="utf-8")
    return path


def all_held_out(runs: list[dict[str, Any]]) -> None:
    for run in runs:
        run["use"] = "held_out"


def overlapping(runs: list[dict[str, Any]]) -> None:
    runs[:] = [runs[0] | {"window": [0, 3], "use": "train"}, runs[0] | {"window": [2, 4.5], "use": "held_out"}]


def short(runs: list[dict[str, Any]]) -> None:
    runs[:] = [runs[0] | {"window": [2, 2.05]}]


@pytest.mark.parametrize(
    ("change", "recordings", "said"),
    [
        (all_held_out, {}, "found use: held_out in every run; expected some to fit"),
        (overlapping, {}, "is fitted in its window [0, 3] and judged on in its window [2, 4.5]; expected"),
        (short, {}, "samples to fit; expected at least 10"),
        (lambda _: None, {"exclude": ["*"]}, "leaves no joint; expected some to judge on"),
    ],
)
def test_what_cannot_be_fitted_and_judged_is_refused(
    change: Callable[[list[dict[str, Any]]], None], recordings: dict[str, Any], said: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=re.escape(said)):
        build_problem(load_scenario(variant(tmp_path, change, **recordings)), "mujoco")


BLOWS_UP: dict[str, Any] = {
    "servos": [{"joints": "*", "kind": "pid", "kp": 20000.0, "kd": 0.0}],
    "physics.step_rate": 20.0,
}


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize(
    "begun",
    [
        lambda s: search(s, [], [], lambda _: None),
        lambda s: rehearse(s, [], 60.0),
        lambda s: visible(s, measure(s, []), [], 1.0),
        lambda s: opened(s, None, lambda _: None),
    ],
    ids=["diagnose", "rehearse", "screen", "propose"],
)
def test_a_model_that_blows_up_is_one_sentence(begun: Callable[[Simulations], object], workers: int) -> None:
    """Nothing can be said of recordings beside it; it is told before anything is looked for."""
    problem = build_problem(load_scenario(DEMO).override(BLOWS_UP), "mujoco")
    with Simulations(problem, workers) as simulations, pytest.raises(InputError) as told:
        begun(simulations)
    (sentence,) = str(told.value).splitlines()
    for part in ("recordings.runs[0]: MuJoCo cannot", "in steps_1: diverged at ", "than 20 Hz", "lower gains"):
        assert part in sentence


def test_a_motion_that_is_both_fitted_and_judged_on_is_said(tmp_path: Path) -> None:
    def mixed(runs: list[dict[str, Any]]) -> None:
        repeated = [run for run in runs if "sines_1" in run["path"]]
        assert len(repeated) > 1
        repeated[-1]["use"] = "held_out"

    problem = build_problem(load_scenario(variant(tmp_path, mixed)), "mujoco")
    assert "one motion is fitted in some repetitions and judged on in others" in problem.split
    assert build_problem(load_scenario(DEMO), "mujoco").split == ""


def test_values_are_those_of_the_scenario_whatever_the_first_run_overrides(tmp_path: Path) -> None:
    def loaded_first(runs: list[dict[str, Any]]) -> None:
        runs.sort(key=lambda run: "robot.urdf" not in run.get("with", {}))

    problem = build_problem(load_scenario(variant(tmp_path, loaded_first)), "mujoco")
    mass = next(s for s in suspects(problem) if s.effect == "link_mass" and s.target == "forearm")
    loaded = problem.cases[0].experiment.plant
    assert neutral(loaded, mass)["mass"] > neutral(problem.plant, mass)["mass"] == pytest.approx(1.203)


def test_what_may_have_either_sign_is_tried_to_both_sides() -> None:
    problem = build_problem(load_scenario(DEMO), "mujoco")
    offset = next(s for s in suspects(problem) if s.effect == "joint_offset")
    angles = [try_.parameters["angle"] for start in starts(problem, offset) for try_ in start.tries]
    assert min(angles) < 0.0 < max(angles)
    mass = next(s for s in suspects(problem) if s.effect == "link_mass")
    assert len(starts(problem, mass)) == 1


def test_local_maximum_looks_to_both_sides() -> None:
    value = np.zeros((9, 1))
    value[4] = 1.0
    assert local_maximum(value, 2)[:, 0].tolist() == [0, 0, 1, 1, 1, 1, 1, 0, 0]


def test_disturbances_move_a_repeated_motion_about_as_far_as_its_repetitions_show() -> None:
    """However large a torque other motions tell of, and however far a model without friction would swing under it."""
    problem = build_problem(load_scenario(DEMO), "mujoco")
    with Simulations(problem, 2) as simulations:
        moved = sensitivities(simulations, [], range(len(problem.cases)))
    torque = 100.0 * disturbances(problem, moved)
    assert torque.max() > 0.0
    for i, case in enumerate(problem.cases):
        size = np.sqrt(np.mean(spread(case, moved[i], torque)["position"] ** 2, axis=0)) * np.sqrt(case.repetitions)
        seen = case.spread.get("position")
        if case.repetitions > 1 and seen is not None:
            assert (size <= LIKELY * seen * 1.001).all()
        else:
            assert size.max() > 0.0
    assert any(case.repetitions > 1 for case in problem.cases)
