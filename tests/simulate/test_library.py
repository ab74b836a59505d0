"""`rg.simulate`: the motion that `realitygap run` simulates, with effects that act as those of a file."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import realitygap as rg
from realitygap.simulate.experiment import experiments
from realitygap.simulate.experiment import simulate as simulate_one

DEMO = Path(__file__).parents[2] / "scenarios" / "demo" / "scenario.yaml"


@pytest.fixture(scope="module")
def demo() -> rg.ScenarioFile:
    return rg.load_scenario(DEMO)


def same(a: rg.Trace, b: rg.Trace) -> bool:
    return a.to_frame().equals(b.to_frame())


def test_it_is_what_a_run_simulates(demo: rg.ScenarioFile) -> None:
    (one,) = experiments(demo, only=["chirp_1"])
    assert same(rg.simulate(demo, "mujoco", run="chirp_1"), simulate_one(one, "mujoco").trace)
    assert same(rg.simulate(str(DEMO), "mujoco", run="chirp_1"), simulate_one(one, "mujoco").trace)


def test_an_effect_acts_as_in_the_file(demo: rg.ScenarioFile) -> None:
    """Also where the run overrides the scenario's keys."""
    friction = rg.effects.coulomb_friction("elbow", torque=0.6)
    added = rg.simulate(demo, "mujoco", run="steps_1", effects=[friction])
    stated = rg.simulate(demo.override({"effects": [friction]}), "mujoco", run="steps_1")
    assert same(added, stated)
    assert same(added, rg.simulate(demo, "mujoco", run="steps_1", effects=[dict(friction)]))
    assert not same(added, rg.simulate(demo, "mujoco", run="steps_1"))


def test_effects_stand_beside_those_of_the_scenario(demo: rg.ScenarioFile) -> None:
    late, friction = rg.effects.command_delay("*", time=0.02), rg.effects.coulomb_friction("elbow", torque=0.6)
    both = rg.simulate(demo, "mujoco", run="chirp_1", effects=[late, friction])
    assert same(both, rg.simulate(demo.override({"effects": [late]}), "mujoco", run="chirp_1", effects=[friction]))
    with pytest.raises(rg.InputError, match="coulomb_friction stands twice on elbow"):
        rg.simulate(demo.override({"effects": [friction]}), "mujoco", run="chirp_1", effects=[friction])


def test_half_the_step_is_twice_the_samples(demo: rg.ScenarioFile) -> None:
    coarse = rg.simulate(demo, "mujoco", run="chirp_1")
    fine = rg.simulate(demo, "mujoco", run="chirp_1", step_rate=2000.0)
    assert np.median(np.diff(fine.time)) == pytest.approx(np.median(np.diff(coarse.time)) / 2)


def test_what_was_measured(demo: rg.ScenarioFile) -> None:
    recording = rg.read_run(demo, "chirp_1")
    assert recording.name == "chirp_1"
    assert recording.trace.joints == rg.simulate(demo, "mujoco", run="chirp_1").joints


@pytest.mark.parametrize(
    ("engine", "arguments", "sentence"),
    [
        ("mojoco", {"run": "chirp_1"}, "engine: found mojoco; expected one of dart, .*; did you mean mujoco"),
        ("mujoco", {"run": "chrip_1"}, "run: found chrip_1; expected one of steps_1, .*; did you mean chirp_1"),
        (5, {"run": "chirp_1"}, "engine: found 5; expected one of dart, "),
        ("mujoco", {"run": "chirp_1", "step_rate": "fast"}, r"step_rate: found 'fast'; expected a number"),
        ("mujoco", {"run": 7}, "run: found 7; expected one of steps_1, "),
        ("mujoco", {}, "run: is missing; expected one of steps_1, sines_1_rep1"),
        ("mujoco", {"run": "chirp_1", "effects": [{"efect": "backlash"}]}, "effect: is missing"),
        (
            "mujoco",
            {"run": "chirp_1", "effects": [{"effect": "backlsh"}]},
            r"effects\[0\]: unknown effect backlsh; .*did you mean backlash",
        ),
        ("mujoco", {"run": "chirp_1", "effects": ["backlash"]}, r"yaml: effects\[0\]: found 'backlash'; expected"),
    ],
)
def test_what_is_wrong_is_one_sentence(
    demo: rg.ScenarioFile, engine: str, arguments: dict[str, Any], sentence: str
) -> None:
    with pytest.raises(rg.InputError, match=sentence) as caught:
        rg.simulate(demo, engine, **arguments)
    assert "\n" not in str(caught.value)


def test_a_recording_may_be_called_like_a_pattern(demo: rg.ScenarioFile, tmp_path: Path) -> None:
    copy = tmp_path / "chirp [new].mcap"
    copy.write_bytes((DEMO.parent / "chirp_1.mcap").read_bytes())
    file = demo.override({"recordings.runs": [{"path": copy}, {"path": "triangle_1.mcap"}]})
    assert rg.read_run(file, "chirp [new]").name == "chirp [new]"


def test_a_scenario_without_recordings_has_one_motion(tmp_path: Path) -> None:
    (tmp_path / "move.json").write_text('{"keyframes": [{"duration": 0.2, "goals": {"elbow": 10.0}}]}')
    told = {
        "name": "move",
        "robot": {"urdf": DEMO.parent / "arm.urdf", "base": "fixed"},
        "servos": [{"joints": "*", "kind": "pid", "kp": 30.0, "kd": 1.0}],
        "motion": {"keyframes": "move.json"},
    }
    file = rg.load_scenario(told, tmp_path)
    assert rg.simulate(file, "mujoco").to_frame()["position", "elbow"].iloc[-1] == pytest.approx(
        np.radians(10), abs=0.1
    )
    with pytest.raises(rg.InputError, match="run: found a; the scenario has none"):
        rg.simulate(file, "mujoco", run="a")
    with pytest.raises(rg.InputError, match="found none; expected a recording to read"):
        rg.read_run(file)


def test_one_effect_is_as_good_as_a_list_of_it(demo: rg.ScenarioFile) -> None:
    one = rg.effects.coulomb_friction("elbow", torque=0.6)
    alone, listed = (rg.simulate(demo, "mujoco", run="chirp_1", effects=e) for e in (one, [one]))
    np.testing.assert_array_equal(alone.to_frame(), listed.to_frame())
    told = {"effect": "coulomb_friction", "target": "elbow", "torque": 0.6}
    np.testing.assert_array_equal(
        rg.simulate(demo, "mujoco", run="chirp_1", effects=told).to_frame(), listed.to_frame()
    )


@pytest.mark.parametrize("none", [3, "backlash", None])
def test_what_is_no_effect_is_said_to_be_none(none: Any, demo: rg.ScenarioFile) -> None:
    with pytest.raises(rg.InputError, match=r"effects: found .*; expected effects, as rg.effects makes them"):
        rg.simulate(demo, "mujoco", run="chirp_1", effects=none)


@pytest.mark.parametrize("verb", [rg.compare, rg.diagnose])
def test_a_list_of_no_engines_is_not_all_of_them(verb: Any, demo: rg.ScenarioFile) -> None:
    with pytest.raises(rg.InputError, match="engines: found an empty list; expected names of engines, or None for all"):
        verb(demo, engines=[])
    with pytest.raises(rg.InputError, match="engines: found 5; expected names of engines"):
        verb(demo, engines=5)
