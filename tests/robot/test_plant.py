"""What a scenario's plant takes from its servos and recordings, and that effects edit a copy of it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from realitygap.matrix.digest import Digest
from realitygap.robot.effects import EFFECTS, Effect
from realitygap.robot.effects.place import place, targets
from realitygap.robot.held import held_joints
from realitygap.robot.plant import PAST, build_plant
from realitygap.robot.servos import servos_of
from realitygap.robot.suspicion import may_be_suspected
from realitygap.scenario.file import load_scenario
from realitygap.scenario.schema import EffectSpec, Motion
from realitygap.simulate.effect_bench import bench
from realitygap_engines.model.robot import Actuator
from signals import there

DEMO = Path(__file__).parents[2] / "scenarios" / "demo" / "scenario.yaml"


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=list(EFFECTS))
def test_an_effect_edits_a_copy(effect: Effect) -> None:
    plant, index = bench(effect)
    before, size = Digest().of(plant), effect.first_size(plant, index)
    edited = plant.copy()
    effect.apply(edited, [index], size)
    assert Digest().of(edited) != before
    assert Digest().of(plant) == before


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=list(EFFECTS))
def test_what_an_effect_says_is_what_it_reads_of_a_plant_that_has_it(effect: Effect) -> None:
    plant, index = bench(effect)
    size = effect.first_size(plant, index)
    effect.apply(plant, [index], size)
    own = effect.own(plant, index)
    told = {name: value for name, value in size.items() if name in own and effect is not EFFECTS["link_inertia"]}
    assert {name: own[name] for name in told} == pytest.approx(told)  # a scale is that of the tensor there is


def test_efforts_by_table_and_over_time_stay_with_the_copy_that_has_them() -> None:
    plant = build_plant(load_scenario(DEMO))
    table = {"variables": ["speed"], "knots": [[-1.0, 1.0]], "values": [0.1, -0.1]}
    mapped = place(plant, [EffectSpec.model_validate({"effect": "effort_map", "target": "elbow", **table})])
    assert len(mapped.maps) == 1
    edited = mapped.copy()
    edited.efforts.append(lambda time: np.ones((len(time), 2)))
    edited.maps.clear()
    assert (len(mapped.maps), mapped.efforts, plant.maps) == (1, [], [])


def test_the_effort_of_a_motor_bounds_only_joints_that_have_one() -> None:
    """A limit of the URDF stands for its motor, and says nothing of a joint that swings freely."""
    servo = {"name": "drive", "joints": "shoulder", "kind": "pid", "kp": 20.0, "kd": 1.0}
    plant = build_plant(load_scenario(DEMO).override({"servos": [servo]}))
    stated = [j.effort for j in plant.model.joints]
    assert np.isfinite(stated).all()
    assert plant.drive["effort_limit"].tolist() == [stated[0], np.inf]


def test_what_is_fixed_to_a_link_is_a_name_of_that_body() -> None:
    """As a target, and for what is certain."""
    file = load_scenario(DEMO)
    plant = build_plant(file)
    *others, forearm = plant.model.links
    model = replace(plant.model, links=(*others, replace(forearm, merged=("forearm", "tool"))))
    assert targets(replace(plant, model=model), EFFECTS["link_mass"], "tool") == [2]
    certain = file.override({"certain": ["robot.mass@forearm"]}).scenario
    assert not may_be_suspected(certain, model, "link_mass", "tool")
    assert may_be_suspected(certain, model, "link_inertia", "tool")


def test_a_joint_is_held_where_the_first_pattern_that_matches_it_says() -> None:
    file = load_scenario(DEMO)
    assert held_joints(file, build_plant(file).model, {"elb*": 0.3, "*w": -0.2}) == {1: 0.3}


def test_actuators_of_a_robots_file_drive_no_motion_that_is_followed() -> None:
    file, kp = load_scenario(DEMO).override({"servos": []}), {"kp": 20.0, "ki": 0.0, "kd": 1.0}
    model = replace(build_plant(file).model, actuators=(Actuator("elbow", "pid", kp),))
    followed = file.scenario.model_copy(update={"motion": Motion(followed=True)})
    assert servos_of(followed, model) == ([], [])
    (servo,), _ = servos_of(file.scenario, model)
    assert servo.joints == ["elbow"]


@pytest.mark.parametrize(("roll", "leans"), [(0.2, False), (0.4, True), (-np.pi / 2 + 0.2, False), (np.pi - 0.4, True)])
def test_a_base_leans_from_the_quarter_turn_at_which_it_may_be_mounted(roll: float, leans: bool) -> None:
    absurd = there(EFFECTS["base_tilt"].absurd)
    assert (absurd(build_plant(load_scenario(DEMO)), 0, {"roll": roll, "pitch": 0.1}) is not None) == leans


@pytest.mark.parametrize(("side", "sign"), [("upper", 1.0), ("lower", -1.0)])
@pytest.mark.parametrize(("past", "gone"), [(0.5 * PAST, False), (2.0 * PAST, True)])
def test_a_limit_that_a_joint_was_measured_past_is_none(side: str, sign: float, past: float, gone: bool) -> None:
    plant = build_plant(load_scenario(DEMO))
    position = np.zeros((10, 2))
    position[4, 1] = getattr(plant.model.joints[1], side) + sign * past
    passing, notes = plant.passing(position)
    assert np.isinf(getattr(passing.model.joints[1], side)) == gone
    assert len(notes) == gone
    assert passing.model.joints[0] == plant.model.joints[0]
