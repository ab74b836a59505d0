"""A motion that is followed takes the effort that drove it: laws over every effect and engine, and closed forms."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import realitygap_engines as engines
from realitygap.compare.comparison import compare, motions_of
from realitygap.files.errors import InputError
from realitygap.robot.effects import EFFECTS, Effect
from realitygap.robot.effects.place import place
from realitygap.robot.plant import Plant
from realitygap.robot.suspicion import may_be_suspected
from realitygap.scenario.effort import effort_factors
from realitygap.scenario.file import load_scenario
from realitygap.scenario.schema import EffectSpec, EffortStream, Scenario
from realitygap.simulate.effect_bench import arm, planted
from realitygap.simulate.effect_bench import simulate as driven
from realitygap.simulate.experiment import experiments, simulate
from realitygap.simulate.follow import Followed, follow
from realitygap.simulate.start import start_state
from realitygap.trace.trace import Array, Trace
from realitygap_engines import GRAVITY
from scipy.integrate import cumulative_trapezoid

ENGINES = engines.available()
CURRENT = ("torque_constant", "motor_heating")
"""Effects that change what is told from a current."""
MEANT = [
    e
    for e in EFFECTS.values()
    if not e.unseen_when_followed
    and e.name not in CURRENT
    and e.changes in ("model", "torque")
    and e.possible(arm(), 1 if e.sits_at == "link" else 0) is None
]


FOLLOWED = Path(__file__).parents[2] / "scenarios" / "effort_driven" / "followed.yaml"


def followed(plant: Plant, time: Array, position: Array, engine: str = "mujoco", *, off: bool = False) -> Trace:
    start = start_state(plant, position[0])
    return follow(engine, plant, Followed(time, position), start, of_joint=False, off=off).trace


def swing(time: Array) -> Array:
    return np.array([np.sin(3 * time), 3 * np.cos(3 * time), -9 * np.sin(3 * time)])


@pytest.mark.parametrize("engine", ENGINES)
def test_an_arm_takes_what_the_closed_form_says(engine: str) -> None:
    """Gravity, inertia, rotor, viscous friction, ripple and a constant effort; friction where it moves."""
    plant, time = arm(), np.arange(0.0, 3.0, 0.002)
    d = plant.drive
    d["constant"], d["ripple"], d["ripple_periods"] = 0.3, 0.1, 5.0
    q, v, a = swing(time)
    effort = followed(plant, time, q[:, None], engine).effort
    assert effort is not None
    link = 0.5 * 0.15**2 + 1e-3
    smooth = (link + 0.0266) * a + 0.5 * GRAVITY * 0.15 * np.sin(q) - 0.3 + 0.1 * np.sin(5 * q) + 0.02 * v
    inner = np.abs(v) > 0.1
    inner[:50] = inner[-50:] = False
    np.testing.assert_allclose(effort[inner, 0], (smooth + 0.05 * np.sign(v))[inner], rtol=0, atol=2e-3)


TORQUE = 0.05


def friction_along_a_swing(**shape: float) -> tuple[Array, Array, Array]:
    """Positions and velocities of a swing, and the share of dry friction of a shape that it takes. Shapes (t,)."""
    plant, time = arm(), np.arange(0.0, 3.0, 0.002)
    rubbing = place(plant, [EffectSpec(effect="coulomb_friction", target="hinge", torque=TORQUE, **shape)])
    q, v, _ = swing(time)
    plant.drive["coulomb"] = plant.drive["static"] = 0.0
    effort, without = (followed(p, time, q[:, None]).effort for p in (rubbing, plant))
    assert effort is not None
    assert without is not None
    return q, v, (effort - without)[:, 0] / TORQUE


@pytest.mark.parametrize("onset", [0.02, 0.5])
def test_friction_that_grows_from_rest_is_a_hyperbolic_tangent_of_the_speed(onset: float) -> None:
    _, v, share = friction_along_a_swing(onset=onset)
    inner = slice(50, -50)
    np.testing.assert_allclose(TORQUE * share[inner], TORQUE * np.tanh(v[inner] / onset), rtol=0, atol=5e-4)


@pytest.mark.parametrize("over", [1e-3, 0.05])
def test_friction_that_builds_up_follows_from_the_positions(over: float) -> None:
    """After each reversal, at q₀, s = ±(1 − 2·exp(−|q − q₀|/over)) as long as the swing is far wider than that."""
    q, v, share = friction_along_a_swing(presliding=over)
    turned = np.flatnonzero(np.sign(v[1:]) != np.sign(v[:-1])) + 1
    for first, last in zip(turned, [*turned[1:], len(q) - 50], strict=True):
        here = slice(first + 2, last - 2)
        expected = np.sign(v[here]) * (1.0 - 2.0 * np.exp(-np.abs(q[here] - q[first]) / over))
        np.testing.assert_allclose(share[here], expected, rtol=0, atol=0.02)


def off(plant: Plant) -> list[Array]:
    """What a driven motion's effort is off while it moves, followed with its own plant and with the plain one."""
    trace = driven(plant)
    assert trace.position is not None
    assert trace.effort is not None
    assert trace.velocity is not None
    moving = (np.abs(trace.velocity[:, 0]) > 0.2) & (trace.time > 0.05) & (trace.time < 1.45)
    out = []
    for candidate in (plant, arm()):
        found = followed(candidate, trace.time, trace.position).effort
        assert found is not None
        out.append((found - trace.effort)[moving])
    return out


@pytest.mark.parametrize("name", [e.name for e in MEANT])
def test_what_is_planted_in_a_driven_motion_is_the_effort_of_the_followed_one(name: str) -> None:
    """Followed, the motion that a servo drove takes the effort that its motor gave, with the effect and only so."""
    plant = planted(EFFECTS[name])
    gap = [float(np.sqrt(np.mean(rest**2))) for rest in off(plant)]
    assert gap[0] < 0.01, "N·m, of efforts of 1 N·m"
    assert gap[1] > 2 * gap[0]


MAPS: dict[tuple[str, ...], dict[str, Any]] = {
    ("angle",): {"knots": [[-0.8, 0.0, 0.8]], "values": [0.3, -0.2, 0.3]},
    ("speed",): {"knots": [[-4.0, 4.0]], "values": [0.4, -0.4]},
    ("load",): {"knots": [[-1.0, 1.0]], "values": [-0.3, 0.3]},
    ("reversal",): {"knots": [[0.0, 0.3]], "values": [0.3, 0.0]},
    ("angle", "speed"): {"knots": [[-0.8, 0.8], [-4.0, 4.0]], "values": [[0.4, -0.4], [-0.4, 0.4]]},
}


@pytest.mark.parametrize("variables", MAPS)
def test_an_effort_by_table_is_the_same_driven_and_followed(variables: tuple[str, ...]) -> None:
    told = {"effect": "effort_map", "target": "hinge", "variables": [*variables], **MAPS[variables]}
    plant = place(arm(), [EffectSpec.model_validate(told)])
    gap = [float(np.median(np.abs(rest))) for rest in off(plant)]
    assert gap[0] < 0.01, "N·m, of a table of some tenths"
    assert gap[1] > 5 * gap[0]


@pytest.mark.parametrize("variable", ["error", "supply"])
def test_an_effort_by_table_needs_what_a_followed_motion_does_not_have(variable: str) -> None:
    spec = {"effect": "effort_map", "variables": [variable], "knots": [[0.0, 1.0]], "values": [0.0, 1.0]}
    armature = {"effect": "rotor_inertia", "target": "*", "armature": 0.004}
    with pytest.raises(InputError, match=f"over the {variable} where the motion is followed"):
        experiments(load_scenario(FOLLOWED).override({"effects": [armature, spec]}))


def test_friction_is_not_claimed_where_nothing_moves() -> None:
    plant, time = arm(), np.arange(0.0, 2.0, 0.01)
    resting = 0.5 + 1e-5 * np.random.default_rng(0).normal(size=(len(time), 1))
    effort = followed(plant, time, resting).effort
    assert effort is not None
    held = 0.5 * GRAVITY * 0.15 * math.sin(0.5)
    assert abs(float(np.mean(effort)) - held) < 0.01
    assert np.abs(effort - held).max() <= 0.05 + 0.02


@pytest.mark.parametrize(("effect", "field"), [("torque_constant", "torque_constant"), ("motor_heating", "heating")])
def test_an_effort_told_from_a_current_shows_the_torque_constant(effect: str, field: str) -> None:
    """current = effort/constant, and the scenario's factor makes an effort of it as if the constant were the factor."""
    plant, time = arm(), np.arange(0.0, 3.0, 0.005)
    plant.drive["kind"], plant.drive["current_factor"], plant.drive["torque_constant"] = 0, 2.0, 2.0
    plain = followed(plant, time, swing(time)[0][:, None]).effort
    value = {"torque_constant": 2.5, "heating": 0.1}[field]
    name = EFFECTS[effect].parameters[0].name
    changed = place(plant, [EffectSpec(effect=effect, target="hinge", **{name: value})])
    found = followed(changed, time, swing(time)[0][:, None]).effort
    assert plain is not None
    assert found is not None
    expected = plain * (2.0 / 2.5 if effect == "torque_constant" else 1 / (1 - 0.1 * time[:, None]))
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_load_dependent_friction_solves_for_the_effort_that_it_is_part_of() -> None:
    plant, time = arm(), np.arange(0.0, 2.0, 0.01)
    plant.drive["load"] = 0.4
    q, v, _ = swing(time)
    effort, base = (followed(p, time, q[:, None]).effort for p in (plant, arm()))
    assert effort is not None
    assert base is not None
    inner = slice(10, -10)
    side = np.sign(v)[inner]
    frictionless = arm()
    frictionless.drive["coulomb"] = frictionless.drive["static"] = frictionless.drive["viscous"] = 0.0
    frictionless.drive["armature"] = 0.0
    transmitted = followed(frictionless, time, q[:, None]).effort
    assert transmitted is not None
    extra = side * 0.4 * 0.5 * np.abs(effort + transmitted)[inner, 0]
    moving = np.abs(v)[inner] > 0.1
    np.testing.assert_allclose((effort - base)[inner, 0][moving], extra[moving], rtol=0, atol=1e-6)


@pytest.mark.parametrize(("rate", "quantum"), [(100, 3e-3), (500, 1.5e-3), (100, 1e-4)])
def test_an_effort_is_off_by_its_standard_error(rate: int, quantum: float) -> None:
    """A sine of a pendulum, read by a coarse encoder: how far the effort is from the exact one, away from the ends."""
    plant, time = arm(), np.arange(0.0, 6.0, 1.0 / rate)
    plant.drive["coulomb"] = 0.0
    exact = swing(time)[0][:, None]
    read = np.round(exact / quantum) * quantum
    found, above = (followed(plant, time, read, off=off).effort for off in (False, True))
    plain = followed(plant, np.arange(0.0, 6.0, 1e-3), swing(np.arange(0.0, 6.0, 1e-3))[0][:, None]).effort
    assert found is not None
    assert above is not None
    assert plain is not None
    inner = slice(rate // 2, -rate // 2)
    made = np.sqrt(np.mean((found - plain[:: 1000 // rate])[inner] ** 2))
    told = np.sqrt(np.mean((above - found)[inner] ** 2))
    assert 0.5 * made < told < 4 * made


@pytest.mark.parametrize(("rate", "quantum"), [(100, 1e-3), (500, 1e-4)])
def test_where_a_motion_stops_its_effort_is_off_by_more(rate: int, quantum: float) -> None:
    """Moves of constant acceleration between rests, where dry friction holds as it did last: jerk is not white."""
    plant, time = arm(), np.arange(0.0, 12.0, 1.0 / rate)
    plant.drive["coulomb"] = plant.drive["static"] = 0.5
    phase, way = time % 2.0, np.where(time % 4.0 < 2.0, 1.0, -1.0)
    a = 6.0 * way * np.select([phase < 0.5, phase < 1.0], [1.0, -1.0], 0.0)
    v = 6.0 * way * np.maximum(np.minimum(phase, 1.0 - phase), 0.0)
    q = cumulative_trapezoid(v, time, initial=0)
    exact = (0.5 * 0.15**2 + 1e-3 + 0.0266) * a + 0.5 * GRAVITY * 0.15 * np.sin(q) + 0.02 * v + 0.5 * way
    read = np.round(q[:, None] / quantum) * quantum
    found, above = (followed(plant, time, read, off=off).effort for off in (False, True))
    assert found is not None
    assert above is not None
    off = (found[:, 0] - exact)[rate // 2 : -rate // 2] / (above - found)[rate // 2 : -rate // 2, 0]
    assert 0.3 < np.sqrt(np.mean(off**2)) < 1.5
    assert np.mean(np.abs(off) < 3.0) > 0.97


INERTIA = '<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/>'
URDF = f"""<robot name="arm">
<link name="base"><inertial><mass value="1"/>{INERTIA}</inertial></link>
<link name="arm"><inertial><origin xyz="0 0 -0.15"/><mass value="0.5"/>{INERTIA}</inertial>
<collision><origin xyz="0 0 -0.15"/><geometry><sphere radius="0.02"/></geometry></collision></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.1"/>
<axis xyz="0 1 0"/></joint></robot>"""
SCENARIO = """
name: followed
robot: {urdf: arm.urdf, base: fixed}
motion: {followed: true}
recordings: {effort: motor, runs: [{path: run.csv, use: train}]}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    time = np.cumsum(np.random.default_rng(0).uniform(0.008, 0.012, 400))
    q = swing(time)[0]
    effort = 0.5 * GRAVITY * 0.15 * np.sin(q)
    rows = "\n".join(f"{t},{x},{e}" for t, x, e in zip(time, q, effort, strict=True))
    (tmp_path / "run.csv").write_text("time,position,effort\n" + rows)
    (tmp_path / "arm.urdf").write_text(URDF)
    return tmp_path


def written(folder: Path, text: str = SCENARIO) -> Path:
    path = folder / "scenario.yaml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("engine", ENGINES)
def test_a_scenario_gives_a_trace_at_the_measured_stamps(folder: Path, engine: str) -> None:
    (found,) = experiments(load_scenario(written(folder)))
    assert found.recording is not None
    measured = found.recording.trace
    trace = simulate(found, engine).trace
    assert measured.position is not None
    assert trace.position is not None
    assert trace.effort is not None
    np.testing.assert_array_equal(trace.time, measured.time)
    assert np.abs(trace.position - measured.position).max() < 1e-4
    assert trace.velocity is not None
    assert any("smoothing spline" in note for note in found.notes)
    finer = simulate(found, engine, step_rate=2 * found.scenario.physics.step_rate).trace
    assert finer.effort is not None
    assert 0 < np.abs(finer.effort - trace.effort).mean() < 0.05


def test_the_gap_of_a_followed_motion_is_that_of_its_effort_alone(folder: Path) -> None:
    """Its positions and velocities are the readings, smoothed: what they differ by is no gap of the model."""
    (motion,) = motions_of(load_scenario(written(folder)))
    assert [(r.joint, r.signal) for r in compare(motion, "mujoco").rows] == [("hinge", "effort")]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("robot:", "servos: [{joints: '*', kind: pid, kp: 1.0}]\nrobot:"), "no servo drives"),
        (("base: fixed", "base: floating"), "expected fixed"),
        (("effort: motor, ", ""), "recordings.effort: found none"),
        (("robot:", "effects: [{effect: backlash, target: hinge, angle: 0.1}]\nrobot:"), "rotor"),
        (("robot:", "ground: flat\nrobot:"), "touches it at"),
        (("{followed: true}", "{followed: true, recorded: position}"), "one of recorded, keyframes and followed"),
    ],
)
def test_what_has_no_place_beside_a_followed_motion_is_told(folder: Path, change: tuple[str, str], told: str) -> None:
    with pytest.raises(InputError, match=told) as error:
        experiments(load_scenario(written(folder, SCENARIO.replace(*change))))
    assert "scenario.yaml" in str(error.value)
    assert "\n" not in str(error.value)


def test_an_effect_on_what_drives_is_not_suspected(folder: Path) -> None:
    file = load_scenario(written(folder))
    (found,) = experiments(file)
    model = found.plant.model
    suspected = {e.name for e in EFFECTS.values() if may_be_suspected(file.scenario, model, e.name, _target(e))}
    assert not suspected & {"command_delay", "controller_gain", "backlash", "supply_voltage", "soft_ground"}
    assert suspected >= {"coulomb_friction", "viscous_friction", "payload", "link_mass", "torque_constant", "base_tilt"}


def _target(effect: Effect) -> str:
    return {"joint": "hinge", "link": "arm"}.get(effect.sits_at, effect.sits_at)


def test_a_factor_may_differ_by_joint(tmp_path: Path) -> None:
    joints, here = ("shoulder_pan", "shoulder_lift", "wrist"), tmp_path / "s.yaml"
    stream = EffortStream(factor={"shoulder_*": 12.0, "*": 10.0})
    np.testing.assert_array_equal(effort_factors(stream, joints, here), [12, 12, 10])
    np.testing.assert_array_equal(effort_factors(EffortStream(factor=2.0), joints, here), [2, 2, 2])
    for factor, told in (({"elbow": 1.0, "*": 2.0}, "elbow matches no joint"), ({"wrist": 1.0}, "shoulder_pan")):
        with pytest.raises(InputError, match=told):
            effort_factors(EffortStream(factor=factor), joints, here)


def test_the_schema_knows_it() -> None:
    scenario = Scenario.model_validate({"name": "x", "robot": {"urdf": "x.urdf"}, "motion": {"followed": True}})
    assert scenario.follows
    assert scenario.effort_measures == "none"
