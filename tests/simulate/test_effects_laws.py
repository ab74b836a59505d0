"""Laws that hold for every effect, in every engine; a new line in `EFFECTS` is tested without a new test."""

import math
from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest
import realitygap_engines as engines
from realitygap.diagnose.candidates.suspects import fitted
from realitygap.files.errors import InputError
from realitygap.robot.drive import NONE, PID
from realitygap.robot.effects import EFFECTS, Effect
from realitygap.robot.effects.place import place
from realitygap.robot.plant import Plant
from realitygap.scenario.schema import EffectSpec
from realitygap.simulate.effect_bench import Excitation, arm, bench, block, motion, pid_arm, planted, simulate
from realitygap.trace.trace import Trace
from realitygap_engines import Unsupported
from realitygap_engines.model.robot import Model
from signals import Signals

ENGINES = engines.available()
DURATION = 1.7
SIGNALS = ("position", "velocity", "effort", "base_position", "base_quaternion")

each = pytest.mark.parametrize("effect", EFFECTS.values(), ids=list(EFFECTS))
everywhere = pytest.mark.parametrize("engine", ENGINES)


@cache
def trace(name: str, engine: str, size: float | None) -> Trace:
    """The bench with so much of an effect's first size: 0 is its own values, None is without it."""
    effect = EFFECTS[name]
    plant, index = bench(effect)
    if size is not None:
        plant = planted(effect, effect.own(plant, index) if size == 0 else sized(effect, size))
    try:
        return simulate(plant, engine, motion(effect), duration=DURATION)
    except Unsupported as reason:
        level = engines.load(engine).capabilities()["soft_ground"].level
        assert (name, level) == ("soft_ground", "no"), "an engine says in its capabilities what it cannot do"
        pytest.skip(str(reason))


def sized(effect: Effect, size: float) -> dict[str, float]:
    """The neutral values, so much of the way to the first size; a stiffness by the inverse."""
    plant, index = bench(effect)
    own, first = effect.own(plant, index), effect.first_size(plant, index)
    out = {}
    for p in effect.parameters:
        a, b = own[p.name], first[p.name]
        if p.shape:
            out[p.name] = b
        elif not math.isfinite(a) or (a == 0 and p.logarithmic):  # neutral is infinite
            out[p.name] = b / size
        else:
            out[p.name] = a + size * (b - a)
    return out


def change(name: str, engine: str, size: float) -> dict[str, np.ndarray]:
    with_effect, without = trace(name, engine, size), trace(name, engine, None)
    both = [(s, getattr(with_effect, s), getattr(without, s)) for s in SIGNALS]
    return {s: a - b for s, a, b in both if a is not None and a.size}


def same(a: Plant, b: Plant) -> bool:
    """Whether two plants are equal in every number."""

    def links(plant: Plant) -> list[tuple[object, ...]]:
        return [(link.name, link.mass, link.com.tolist(), link.inertia.tolist()) for link in plant.model.links]

    arrays = ("drive", "delay", "velocity_lag", "velocity_scale", "base_tilt")
    known = {"model", "ground", "efforts", "maps", "payloads", "reached", "travelled", "lagged", "exerted", *arrays}
    assert {f.name for f in fields(Plant)} == known, "this comparison has to know every part of a plant"
    equal = all(np.array_equal(getattr(a, n), getattr(b, n)) for n in arrays)
    equal = equal and links(a) == links(b) and a.payloads == b.payloads
    equal = equal and a.reached is b.reached and a.travelled is b.travelled and a.exerted is b.exerted
    equal = equal and a.lagged is b.lagged
    return equal and a.ground == b.ground and (a.efforts, a.maps) == (b.efforts, b.maps)


@each
@everywhere
def test_the_neutral_value_changes_nothing_bit_for_bit(effect: Effect, engine: str) -> None:
    neutral = change(effect.name, engine, 0)
    assert neutral
    for name, difference in neutral.items():
        assert not difference.any(), name


@each
def test_the_neutral_value_leaves_the_plant_as_it_is(effect: Effect) -> None:
    plant, index = bench(effect)
    assert same(planted(effect, effect.own(plant, index)), plant)
    absent = {p.name: effect.own(plant, index)[p.name] if p.absent is None else p.absent for p in effect.parameters}
    assert absent == effect.own(plant, index)


@each
def test_bounds_units_and_first_size_are_there(effect: Effect) -> None:
    plant, index = bench(effect)
    first, own = effect.first_size(plant, index), effect.own(plant, index)
    assert list(first) == list(own) == [p.name for p in effect.parameters]
    for p in effect.parameters:
        assert p.low < p.high
        assert p.low <= first[p.name] <= p.high
        assert p.low <= own[p.name] <= p.high or own[p.name] == p.absent or math.isinf(own[p.name])
        assert p.unit or p.name in ("exponent", "coefficient", "static_coefficient", "scale", "share", "asymmetry")
        assert not p.logarithmic or p.low > 0
    assert any(first[p.name] != own[p.name] for p in effect.parameters)


@each
@everywhere
def test_what_is_planted_acts_on_its_signal_in_one_direction(effect: Effect, engine: str) -> None:
    """A part of an effect changes the trace the same way as the whole of it, and less."""
    part, whole = change(effect.name, engine, 0.8), change(effect.name, engine, 1.0)
    shown = [s for s in effect.signals if s in whole]
    assert shown
    for name in shown:
        a, b = part[name].ravel(), whole[name].ravel()
        assert np.sqrt(np.mean(b**2)) > 1e-4
        assert a @ b > 0.5 * np.linalg.norm(a) * np.linalg.norm(b)
        assert np.linalg.norm(a) < np.linalg.norm(b)
    if effect.changes == "observation" and "position" not in effect.signals:
        assert not whole["position"].any(), "the sensor, not the robot"


@each
@pytest.mark.parametrize("engine", [e for e in ENGINES if e != "mujoco"])
def test_the_same_effect_gives_the_same_trajectory_in_every_engine(effect: Effect, engine: str) -> None:
    """Without dry friction engines agree to 1e-13 rad; MuJoCo's friction is a soft constraint, which moves a joint by
    some 1e-5 rad/s while it should hold and costs up to 1e-4 rad. Contacts are each engine's own: 1 mm.
    """
    name = effect.name
    one, other = trace(name, "mujoco", 1.0), trace(name, engine, 1.0)
    if effect.sits_at == "ground":
        assert one.base_position is not None
        assert other.base_position is not None
        assert np.sqrt(np.mean((one.base_position - other.base_position) ** 2)) < 1e-3
        return
    assert one.position is not None
    assert other.position is not None
    assert np.sqrt(np.mean((one.position - other.position) ** 2)) < 1.5e-4


@pytest.mark.parametrize(
    "name", [e.name for e in EFFECTS.values() if e.sits_at == "joint" and not (e.dissipative and e.changes == "torque")]
)
def test_without_dry_friction_engines_agree_to_rounding(name: str) -> None:
    effect = EFFECTS[name]
    traces = []
    for engine in ENGINES:
        plant = planted(effect)
        plant.drive["coulomb"] = plant.drive["static"] = 0.0
        traces.append(Signals(simulate(plant, engine, duration=0.8)).position)
    for engine, other in zip(ENGINES[1:], traces[1:], strict=True):
        # an engine whose bodies are held together by constraints does not solve to rounding, and says so
        exact = engines.load(engine).capabilities()["forward_dynamics"].level != "no"
        assert np.abs(other - traces[0]).max() < (1e-8 if exact else 1e-6)


@pytest.mark.parametrize("name", [e.name for e in EFFECTS.values() if e.dissipative])
@everywhere
def test_a_dissipative_effect_never_adds_energy(name: str, engine: str) -> None:
    """An arm without servo swings freely (a block slides): its energy only falls, but for the step's own error."""
    effect = EFFECTS[name]

    def energy(size: float | None) -> np.ndarray:
        plant, _ = bench(effect) if size is None else (planted(effect), 0)
        plant.drive["kind"] = NONE
        plant.drive["coulomb"] *= size is not None
        plant.drive["static"] *= size is not None
        plant.drive["viscous"] *= size is not None
        if effect.sits_at == "ground":
            out = simulate(plant, engine, Excitation(push=1.0), duration=0.5)
            assert out.base_linear is not None
            assert out.base_position is not None
            moving = 0.6 * np.sum(out.base_linear**2, axis=1)
            return np.asarray(moving + 1.2 * 9.81 * out.base_position[:, 2])
        plant.base_tilt = np.array([0.0, 0.8])  # q = 0 is then a start at 0.8 rad
        out = simulate(plant, engine, duration=1.0)
        assert out.position is not None
        assert out.velocity is not None
        link = 0.5 * 0.15**2 + 1e-3
        rotor = 0.0 if name == "backlash" else 0.0266
        height = -0.15 * np.cos(out.position[:, 0] + 0.8)
        return 0.5 * (link + rotor) * out.velocity[:, 0] ** 2 + 0.5 * 9.81 * height

    def gained(curve: np.ndarray) -> float:
        return float((curve - np.minimum.accumulate(curve)).max())

    with_effect = energy(1.0)
    assert np.ptp(with_effect) > 1e-3
    # a rotor with play takes energy at one impact and returns part of it at the next: see the closed forms
    allowed = 0.25 * np.ptp(with_effect) if name == "backlash" else 2e-3 * np.ptp(with_effect)
    assert gained(with_effect) < allowed + gained(energy(None)) * (effect.sits_at != "ground")


@pytest.mark.parametrize("first", EFFECTS)
def test_two_effects_commute(first: str) -> None:
    """In whatever order a scenario names them, the plant is the same."""
    benches = [replace(a, ground=block().ground, model=_with_feet(a, block())) for a in (arm(), pid_arm())]
    for second in EFFECTS:
        if second == first or second in EFFECTS[first].excludes or first in EFFECTS[second].excludes:
            continue
        pair = [EFFECTS[first], EFFECTS[second]]
        both = next((b for b in benches if not any(e.possible(b, _index(e)) for e in pair)), None)
        if both is None:
            assert {"derivative_gain", "derivative_lag"} & {first, second}, "of a pid servo; others are of a dc motor"
            continue
        one, other = (_first(e, both) for e in pair)
        forward = place(both, [one, other])
        assert same(forward, place(both, [other, one]))
        assert not same(forward, both)


def _index(effect: Effect) -> int:
    return 1 if effect.sits_at == "link" else 0


def _first(effect: Effect, plant: Plant) -> EffectSpec:
    target = {"joint": "hinge", "link": "arm"}.get(effect.sits_at, effect.sits_at)
    return EffectSpec(effect=effect.name, target=target, **effect.first_size(plant, _index(effect)))


def _with_feet(one: Plant, other: Plant) -> Model:
    links = one.model.links
    return replace(one.model, links=(links[0], replace(links[1], spheres=other.model.links[0].spheres)))


@each
def test_the_page_says_it_all(effect: Effect) -> None:
    page = effect.page
    for text in (page.physics, page.equation, page.signature, page.confused_with, page.source):
        assert len(text) > 8
    assert any(other in page.confused_with for other in EFFECTS if other != effect.name)
    for other in effect.excludes:
        assert effect.name in EFFECTS[other].excludes
    for more in (EFFECTS[name] for name in effect.special_of):
        assert (more.law, more.sits_at) == (effect.law, effect.sits_at)
        assert len(fitted(more)) > len(fitted(effect))


def test_an_effect_says_why_it_cannot_act_somewhere() -> None:
    bare, pid, floating = arm(), arm(), block()
    bare.drive["kind"] = NONE
    bare.drive["armature"] = 0.0
    pid.drive["kind"] = PID
    recorded = arm()
    recorded.drive["recorded_supply"] = 1
    expected = {
        "controller_gain": bare,
        "command_delay": bare,
        "torque_speed_limit": bare,
        "backlash": bare,
        "joint_compliance": bare,
        "derivative_gain": arm(),
        "derivative_lag": arm(),
        "torque_constant": pid,
        "supply_voltage": pid,
        "voltage_sag": pid,
        "motor_heating": pid,
        "base_tilt": floating,
        "ground_friction": arm(),
        "soft_ground": arm(),
        "link_mass": arm(),
        "center_of_mass": arm(),
        "link_inertia": arm(),
        "payload": arm(),
    }
    for name in ("dead_band", "command_profile", "gain_law", "servo_rate"):
        expected[name] = bare
    for name in ("effort_limit", "current_lag", "motor_saturation"):
        expected[name] = bare
    expected["motor_braking"] = pid
    for name, plant in expected.items():
        reason = EFFECTS[name].possible(plant, 0)
        assert reason, name
        assert "expected" in reason
    assert EFFECTS["supply_voltage"].possible(recorded, 0)
    for effect in EFFECTS.values():
        assert effect.possible(*bench(effect)) is None


@pytest.mark.parametrize(
    ("specs", "told"),
    [
        ([{"effect": "friktion", "target": "hinge"}], "backlash"),
        ([{"effect": "backlash", "target": "knee", "angle": 0.1}], "hinge"),
        ([{"effect": "backlash", "target": [], "angle": 0.1}], "empty"),
        ([{"effect": "backlash", "target": "hinge", "width": 0.1}], "angle"),
        ([{"effect": "backlash", "target": "hinge"}], "angle"),
        ([{"effect": "backlash", "target": "hinge", "angle": "2 deg"}], "rad"),
        ([{"effect": "backlash", "target": "hinge", "angle": 7.0}], "0 to 0.5"),
        ([{"effect": "backlash", "target": "hinge", "angle": math.nan}], "number"),
        ([{"effect": "base_tilt", "target": "hinge", "roll": 0.1}], "base"),
        ([{"effect": "soft_ground", "target": "ground", "stiffness": 3e3, "damping": 1e2}], "ground"),
        ([{"effect": "link_mass", "target": "thigh", "mass": 0.1}], "arm"),
        ([{"effect": "backlash", "target": t, "angle": 0.1} for t in ("hinge", "*")], "twice"),
        (
            [
                {"effect": "coulomb_friction", "target": "*", "torque": 0.1},
                {"effect": "stribeck_friction", "target": "*", "static": 0.2, "coulomb": 0.1, "velocity": 1.0},
            ],
            "exclude",
        ),
    ],
)
def test_bad_input_is_told_in_one_sentence_that_lists_what_exists(specs: list[dict[str, object]], told: str) -> None:
    with pytest.raises(InputError) as error:
        place(arm(), [EffectSpec.model_validate(s) for s in specs])
    assert told in str(error.value)
    assert "\n" not in str(error.value)
