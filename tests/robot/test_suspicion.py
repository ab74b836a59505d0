"""What is certain is not suspected, what is listed alone is, and everything else as before."""

from pathlib import Path

import pytest
from realitygap.files.errors import InputError
from realitygap.robot.effects import EFFECTS
from realitygap.robot.plant import build_plant
from realitygap.robot.suspicion import QUANTITIES, SERVO, check_suspicion, may_be_suspected
from realitygap.scenario.file import load_scenario

FILE = load_scenario(Path(__file__).parents[2] / "scenarios" / "demo" / "scenario.yaml")
MODEL = build_plant(FILE).model
JOINTS, LINKS = ("shoulder", "elbow"), ("upper_arm", "forearm")


def places(effect: str) -> tuple[str, ...]:
    sits_at = EFFECTS[effect].sits_at
    return {"joint": (*JOINTS, "*"), "link": LINKS}.get(sits_at, (sits_at,))


def allowed(**keys: object) -> set[tuple[str, str]]:
    scenario = FILE.override(keys).scenario
    return {(e, t) for e in EFFECTS for t in places(e) if may_be_suspected(scenario, MODEL, e, t)}


ALL = {(e, t) for e in EFFECTS for t in places(e)}


def test_without_a_word_everything_may_be_suspected() -> None:
    assert allowed() == ALL


@pytest.mark.parametrize("quantity", [*QUANTITIES, *(f"servos.*.{key}" for key in SERVO)])
def test_a_certain_quantity_rules_out_its_effects_and_no_others(quantity: str) -> None:
    effects = QUANTITIES.get(quantity) or SERVO[quantity.removeprefix("servos.*.")]
    assert ALL - allowed(certain=[quantity]) == {(e, t) for e, t in ALL if e in effects}


def test_one_joint_or_link_can_be_certain() -> None:
    assert ALL - allowed(certain=["robot.mass@forearm"]) == {("link_mass", "forearm")} | {
        (e, t) for e, t in ALL if e == "payload" and t == "forearm"
    }
    assert ALL - allowed(certain=["joint_offset@elbow"]) == {("joint_offset", "elbow"), ("joint_offset", "*")}


def test_a_servo_by_name_has_the_joints_that_it_matches_first() -> None:
    drive = FILE.raw["servos"][0]
    servos = [{**drive, "name": "upper", "joints": "should*"}, {**drive, "name": "rest", "joints": "*"}]
    file = FILE.override({"servos": servos, "certain": ["servos.rest.gain"]})
    assert may_be_suspected(file.scenario, MODEL, "controller_gain", "shoulder")
    assert not may_be_suspected(file.scenario, MODEL, "controller_gain", "elbow")
    assert not may_be_suspected(file.scenario, MODEL, "controller_gain", ("shoulder", "elbow"))


def test_suspects_narrow_the_list() -> None:
    found = allowed(suspects=["link_mass", "backlash@elb*"])
    assert found == {("link_mass", "upper_arm"), ("link_mass", "forearm"), ("backlash", "elbow")}


def test_something_else_stays_comparable() -> None:
    scenario = FILE.override({"suspects": ["backlash"]}).scenario
    assert may_be_suspected(scenario, MODEL, "something_else", "elbow")


@pytest.mark.parametrize(
    ("key", "entry", "said"),
    [
        ("suspects", "backlsh", "did you mean backlash"),
        ("suspects", "backlash@knee", "knee matches no joint or link"),
        ("certain", "robot.mas", "did you mean robot.mass"),
        ("certain", "servos.*.colour", "servos.NAME"),
        ("certain", "servos.drives.gain", "did you mean drive"),
    ],
)
def test_an_unknown_name_is_one_sentence(key: str, entry: str, said: str) -> None:
    file = FILE.override({key: [entry]})
    with pytest.raises(InputError, match=f"{key}\\[0\\].*{said}"):
        check_suspicion(file, MODEL)
