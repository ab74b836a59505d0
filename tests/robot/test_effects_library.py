"""The effects as functions: each makes what a scenario would say, and checks it at once."""

import inspect

import pytest
from realitygap.files.errors import InputError
from realitygap.robot.effects import EFFECTS, WRITABLE, Effect
from realitygap.robot.effects.library import effects
from realitygap.robot.effects.place import values
from realitygap.simulate.effect_bench import bench

EVERY = pytest.mark.parametrize("effect", EFFECTS.values(), ids=list(EFFECTS))


@EVERY
def test_every_effect_has_a_function_that_says_it(effect: Effect) -> None:
    size = effect.first_size(*bench(effect))
    spec = getattr(effects, effect.name)("knee", **size)
    assert (spec.effect, spec.target) == (effect.name, "knee")
    assert values(effect, spec) == size


@EVERY
def test_every_function_tells_what_it_takes(effect: Effect) -> None:
    make = getattr(effects, effect.name)
    target, *rest = inspect.signature(make).parameters.values()
    assert target.name == "target"
    assert [p.name for p in rest] == [p.name for p in effect.parameters]
    assert all(f"{p.name}: " in make.__doc__ for p in effect.parameters)
    needed = {p.name for p in rest if p.default is inspect.Parameter.empty}
    assert needed == {p.name for p in effect.parameters if p.default is None}


def test_they_are_listed() -> None:
    assert set(WRITABLE) == set(dir(effects))
    assert all(name in repr(effects) for name in WRITABLE)


def test_an_effect_that_is_not_there() -> None:
    with pytest.raises(AttributeError, match=r"no effect colomb_friction; did you mean coulomb_friction\? \(known: "):
        effects.colomb_friction  # noqa: B018


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ({}, "torque: is missing; coulomb_friction needs torque"),
        ({"force": 0.1}, r"force: unknown parameter; coulomb_friction needs torque \[N·m\]"),
        ({"torque": -1.0}, "torque: found -1 N·m; expected 0 to"),
        ({"torque": "0.1 N·m"}, "expected a number in N·m"),
    ],
)
def test_what_is_wrong_is_told_at_once(parameters: dict[str, float], sentence: str) -> None:
    with pytest.raises(InputError, match=f"effect coulomb_friction: .*{sentence}"):
        effects.coulomb_friction("elbow", **parameters)


def test_every_effect_of_the_design_is_there_in_its_order() -> None:
    """The order decides between explanations that are equal."""
    expected = """coulomb_friction viscous_friction stribeck_friction load_dependent_friction backlash joint_compliance
    rotor_inertia torque_constant torque_speed_limit supply_voltage voltage_sag command_delay controller_gain
    joint_offset torque_ripple motor_heating constant_effort link_mass center_of_mass link_inertia base_tilt
    ground_friction soft_ground velocity_filter payload dead_band joint_stop command_profile effort_limit
    direction_friction friction_ripple cable_spring motor_braking current_lag gain_law servo_rate
    derivative_gain derivative_lag motor_saturation effort_hysteresis"""
    assert list(EFFECTS) == expected.split()


def test_what_an_effect_may_have_is_told_where_it_needs_nothing() -> None:
    with pytest.raises(InputError, match="effect base_tilt: target: found 5; expected text"):
        effects.base_tilt(5)
    with pytest.raises(InputError, match=r"effect base_tilt: rol: unknown parameter; base_tilt may have roll \[rad\]"):
        effects.base_tilt("base", rol=0.1)
