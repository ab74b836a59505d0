"""The blind suite itself: its foreign plant against closed forms, its generator, its judge."""

import filecmp
import os
import sys
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

import cases
import friction
import judge
import matching
import planted
import robots
import run
import summary
from chain import GRAVITY, Chain
from drivetrain import drives
from foreign import Foreign, simulate
from imperfections import imperfect
from recorder import Sensing

INERTIA, MASS, LENGTH, ARMATURE = 0.004, 0.5, 0.2, 0.01
SWING = INERTIA + MASS * LENGTH**2


def pendulum(gravity: float = GRAVITY, **drive: float) -> Foreign:
    """A point on a rod; q = 0 hangs down."""
    chain = Chain(
        np.array([False]),
        np.array([[0.0, 1.0, 0.0]]),
        np.zeros((1, 3)),
        np.eye(3)[None],
        np.array([MASS]),
        np.array([[0.0, 0.0, -LENGTH]]),
        np.diag([INERTIA] * 3)[None],
        np.array([0.0, 0.0, -gravity]),
    )
    out = drives(1)
    out["armature"] = ARMATURE
    for key, value in drive.items():
        out[key] = value
    out["static"] = np.maximum(out["static"], out["coulomb"])
    out["bristle"] = out["static"] / 3e-4
    out["bristle_damping"] = np.sqrt(out["bristle"] * ARMATURE)
    return Foreign(chain, out)


def free(plant: Foreign, start: float, duration: float):
    """The servo is off from the beginning."""
    n = plant.n()
    return simulate(plant, np.zeros(1), np.zeros((1, n)), np.zeros(1), np.full(n, start), duration, settle=0.0)


def crossings(time: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Times at which x passes zero upwards."""
    k = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
    return time[k] - x[k] * (time[k + 1] - time[k]) / (x[k + 1] - x[k])


def test_small_swing_has_the_period_of_a_compound_pendulum() -> None:
    motion = free(pendulum(), 0.02, 6.0)
    period = np.diff(crossings(motion.time, motion.link[:, 0])).mean()
    assert period == pytest.approx(2 * np.pi * np.sqrt((SWING + ARMATURE) / (MASS * GRAVITY * LENGTH)), rel=2e-4)


def test_dry_friction_takes_the_same_angle_from_every_half_swing() -> None:
    torque = 0.02
    motion = free(pendulum(coulomb=torque), 0.2, 4.0)
    q = motion.link[:, 0]
    turn = np.flatnonzero(np.diff(np.sign(motion.velocity[1:, 0])) != 0)
    peaks = np.abs(q[turn + 1])[:4]
    assert -np.diff(peaks) == pytest.approx(2 * torque / (MASS * GRAVITY * LENGTH), rel=0.03)


def test_a_stuck_joint_stays_within_a_fraction_of_the_encoder_quantum() -> None:
    motion = free(pendulum(coulomb=0.5), 0.3, 3.0)
    assert np.ptp(motion.link[:, 0]) < 0.2 * robots.QUANTUM


def test_beyond_its_friction_a_joint_speeds_up_as_a_free_body() -> None:
    push, torque, time = 0.3, 0.1, 0.5
    motion = free(pendulum(gravity=0.0, coulomb=torque, constant=push), 0.0, time)
    assert motion.link[-1, 0] == pytest.approx(0.5 * (push - torque) / (SWING + ARMATURE) * time**2, rel=5e-3)


def test_load_dependent_friction_takes_its_share_of_what_the_motor_gives() -> None:
    """A motor at its stall limit against a bound of c·τ_t, τ_t = ½·(τ_m + what reaches the link)."""
    motor, share, time = 1.0, 0.2, 0.3
    plant = pendulum(gravity=0.0, kind=1, kp=1e4, effort_limit=motor, load=share)
    plant.drive["bristle"] = motor * share / 3e-4
    motion = simulate(plant, np.zeros(1), np.full((1, 1), 50.0), np.ones(1), np.zeros(1), time, settle=0.0)
    # J_l·a = τ_m − c·τ_t − J_a·a and τ_t = ½·(τ_m + J_l·a)
    total = SWING + ARMATURE + 0.5 * share * SWING
    expected = motor * (1 - 0.5 * share) / total
    assert motion.link[-1, 0] == pytest.approx(0.5 * expected * time**2, rel=5e-3)


def test_compliance_rings_at_the_frequency_of_two_masses() -> None:
    stiffness = 30.0
    motion = free(pendulum(gravity=0.0, stiffness=stiffness, constant=0.2), 0.0, 1.5)
    between = motion.reading[:, 0] - motion.link[:, 0]
    period = np.diff(crossings(motion.time, between - between.mean())).mean()
    assert 2 * np.pi / period == pytest.approx(np.sqrt(stiffness * (1 / ARMATURE + 1 / SWING)), rel=5e-3)


def test_backlash_lets_the_output_fall_by_half_its_width() -> None:
    # friction that even the impact does not overcome: the rotor stays
    plant = pendulum(coulomb=50.0, output_share=0.0, backlash=0.04)
    motion = free(plant, 0.5, 3.0)
    assert 0.5 - motion.link[-1, 0] == pytest.approx(0.02, abs=5e-4)


def test_delay_shifts_the_motion_and_nothing_else() -> None:
    delay, at = 0.01, np.array([0.0, 0.1])
    command = np.array([[0.0], [0.4]])
    quick, late = (
        simulate(pendulum(gain=5.0, delay=d), at, command, np.ones(2), np.zeros(1), 0.6, settle=0.0)
        for d in (0.0, delay)
    )
    shift = round(delay / (quick.time[1] - quick.time[0]))
    assert late.reading[shift:] == pytest.approx(quick.reading[:-shift], abs=1e-9)


def test_the_servo_regulates_what_the_encoder_reads() -> None:
    plant = pendulum(gravity=0.0, gain=5.0, offset=0.1)
    motion = simulate(plant, np.zeros(1), np.full((1, 1), 0.3), np.ones(1), np.full(1, 0.3), 3.0, settle=0.0)
    assert motion.reading[-1, 0] == pytest.approx(0.3, abs=1e-4)
    assert motion.link[-1, 0] == pytest.approx(0.4, abs=1e-4)


@pytest.mark.parametrize("kind", robots.TWO_LINKS)
def test_two_links_without_friction_keep_their_energy(kind: str) -> None:
    robot = robots.BUILDERS[kind](np.random.default_rng(5))
    plant = robot.plant()
    for name in ("coulomb", "static", "viscous", "armature"):
        plant.drive[name] = 0.0
    motion = free(plant, 0.6, 2.0)

    def energy(k: int) -> float:
        q, w, still = motion.link[k], motion.velocity[k], np.zeros(2)
        calm = replace(plant.chain, gravity=np.zeros(3))
        kinetic = 0.5 * w @ np.array([calm.torque(q, still, e) for e in np.eye(2)]) @ w
        # potential energy: the integral of the gravity torque along a straight path from zero
        steps = np.linspace(0, 1, 401)
        work = [plant.chain.torque(s * q, still, still) @ q for s in steps]
        return float(kinetic + np.trapezoid(work, steps))

    values = [energy(k) for k in range(0, len(motion.time), 1000)]
    assert values == pytest.approx([values[0]] * len(values), abs=1e-3 * abs(values[0]))


@pytest.mark.parametrize("effect", planted.EVERY)
def test_every_effect_is_planted_as_it_is_told(effect: str) -> None:
    kind = "skew"
    robot = robots.BUILDERS[kind](np.random.default_rng(2))
    robot.torque = robot.speed = robot.peak = robot.fastest = np.ones(2)
    plant = robot.plant()
    told = planted.plant(effect, plant, robot, 1, 1.0, np.random.default_rng(3))
    assert told.effect in planted.TABLE
    assert all(np.isfinite(v) for v in told.parameters.values())
    model = robot.plant()
    changed = (
        any(not np.array_equal(plant.drive[n], model.drive[n]) for n in plant.drive.dtype.names)
        or plant.sag > 0
        or any(not np.array_equal(a, b) for a, b in zip(plant.chain.arrays(), model.chain.arrays(), strict=True))
        or plant.velocity_time.any()
    )
    assert changed


@pytest.mark.parametrize(("kind", "robot"), [("single", "pendulum"), ("nothing", "skew"), ("nearly_several", "planar")])
def test_a_case_is_written_alike_twice_and_reads_as_a_scenario(kind: str, robot: str, tmp_path: Path) -> None:
    case = next(c for c in cases.catalogue(kind) if c.robot == robot)
    truths = [cases.generate(case, tmp_path / name) for name in ("a", "b")]
    assert truths[0] == truths[1]
    folder = tmp_path / "a" / "cases" / case.name
    for path in sorted(p for p in folder.rglob("*") if p.is_file()):
        assert filecmp.cmp(path, tmp_path / "b" / path.relative_to(tmp_path / "a"), shallow=False), path.name
        assert not any(t["effect"].encode() in path.read_bytes() for t in truths[0]["truth"]), path.name
    runs = load_scenario(folder / "scenario.yaml").cases()
    assert {r.run.use for r in runs} == {"train", "held_out"}
    assert all(t["visibility"] > 1.0 for t in truths[0]["truth"])


@pytest.mark.parametrize("kind", [*robots.ONE_JOINT, *robots.TWO_LINKS])
def test_nearly_right_laws_are_a_few_per_cent_of_what_acts(kind: str) -> None:
    """Along one motion, no law's imperfection takes or gives more than its stated share of what the law gives."""
    robot = robots.BUILDERS[kind](np.random.default_rng(4))
    n = len(robot.joints)
    robot.torque = robot.peak = robot.speed = robot.fastest = np.ones(n)
    plant = robot.plant()
    imperfect(plant, robot, 7)
    drive = plant.drive
    uneven = np.abs(drive["uneven_direction"]) + drive["uneven_angle"]
    assert np.all((uneven >= 0.0399) & (uneven <= 0.1001))
    droop = drive["saturation"] + drive["fading"]
    assert np.all((droop >= 0.0199) & (droop <= 0.0501))
    assert np.all((drive["cable"] >= 0.005 * robot.torque) & (drive["cable"] <= 0.0151 * robot.torque))
    assert np.linalg.norm(plant.chain.gravity) == pytest.approx(9.80665)
    again = robot.plant()
    imperfect(again, robot, 7)
    assert np.array_equal(drive, again.drive)


@pytest.mark.parametrize("drive", [{"coulomb": 0.1, "uneven_direction": 0.08}, {"coulomb": 0.1, "lean": 0.008}])
def test_friction_that_differs_by_direction(drive: dict[str, float]) -> None:
    """Pushed by the same effort either way, a joint gains speed by what friction leaves of it."""
    push, time = 0.3, 0.4
    for side in (1.0, -1.0):
        motion = free(pendulum(gravity=0.0, constant=side * push, **drive), 0.0, time)
        expected = 0.5 * side * (push - 0.1 * (1 + side * 0.08)) / (SWING + ARMATURE) * time**2
        assert motion.link[-1, 0] == pytest.approx(expected, rel=5e-3)


HELD = {"gravity": 0.0, "coulomb": 50.0, "gain": 1.0, "torque_constant": 2.0, "resistance": 4.0, "supply": 10.0}
"""A joint that does not move, with 5 N·m at full duty."""


def held(error: float, duration: float = 0.1, **drive: float):
    """The effort of a servo against a stuck joint, at a constant error. Shape (t,)."""
    plant = pendulum(**{**HELD, **drive})
    motion = simulate(plant, np.zeros(1), np.full((1, 1), error), np.ones(1), np.zeros(1), duration, settle=0.0)
    return motion.time, motion.effort[:, 0]


@pytest.mark.parametrize(
    ("drive", "error", "torque"),
    [
        ({"dead_band": 0.06}, 0.1, 5.0 * 0.07),
        ({"dead_band": 0.06}, -0.02, 0.0),
        ({"gain_exponent": 0.7}, 0.3, 5.0 * 0.1 * 3.0**0.7),
        ({"gain_exponent": 0.7}, -0.1, -0.5),
        ({"protection": 0.2, "protection_share": 0.3}, 0.1, 0.5),
        ({"protection": 0.2, "protection_share": 0.3}, 0.3, 5.0 * 0.3 * 0.3),
        ({"real_limit": 0.7}, 0.3, 0.7),
        ({"real_limit": 0.7}, -0.1, -0.5),
    ],
)
def test_what_firmware_makes_of_an_error(drive: dict[str, float], error: float, torque: float) -> None:
    assert held(error, **drive)[1][-1] == pytest.approx(torque, rel=2e-3, abs=1e-9)


def test_torque_lags_behind_its_voltage() -> None:
    time, effort = held(0.2, lag=0.02)
    assert effort == pytest.approx(1.0 - np.exp(-(time + 2e-5) / 0.02), rel=5e-3)


def test_a_servo_of_its_own_rate_answers_at_that_rate() -> None:
    plant = pendulum(**HELD, rate=40.0)
    time = np.arange(0.0, 1.0, 0.005)
    motion = simulate(plant, time, 0.1 * time[:, None], np.ones(len(time)), np.zeros(1), 1.0, settle=0.0)
    changes = motion.time[1:][np.abs(np.diff(motion.effort[:, 0])) > 1e-3]
    assert changes == pytest.approx(np.arange(1, len(changes) + 1) / 40.0, abs=3e-4)
    assert len(changes) == 40


@pytest.mark.parametrize("acceleration", [0.0, 8.0])
def test_a_profile_takes_its_time_to_a_goal(acceleration: float) -> None:
    """way/speed, and speed/acceleration more where it starts and brakes gently."""
    plant = pendulum(**HELD, profile_speed=2.0, profile_acceleration=acceleration)
    at, goals = np.array([0.0, 0.1]), np.array([[0.0], [1.0]])
    motion = simulate(plant, at, goals, np.ones(2), np.zeros(1), 1.2, settle=0.0)
    there = motion.time[np.flatnonzero(motion.effort[:, 0] > 5.0 * 0.9999)[0]]
    assert there - 0.1 == pytest.approx(0.5 + (2.0 / acceleration if acceleration else 0.0), abs=6e-3)
    assert motion.effort[:, 0].max() <= 5.0 * 1.001


def test_a_short_circuit_brakes_by_its_back_emf() -> None:
    push, time = 0.3, 0.05
    plant = pendulum(gravity=0.0, constant=push, torque_constant=2.0, resistance=4.0, braking=0.5)
    damping = 0.5 * 2.0**2 / 4.0
    motion = free(plant, 0.0, time)
    expected = push / damping * (1 - np.exp(-damping * motion.time[-1] / (SWING + ARMATURE)))
    assert motion.velocity[-1, 0] == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize(
    ("drive", "rest"),
    [
        ({"spring": 2.0, "spring_rest": 0.3, "constant": 0.2}, 0.3 + 0.1),
        ({"stop_upper": 0.1, "stop_stiffness": 4.0, "constant": 0.2}, 0.1 + 0.05),
        ({"stop_lower": -0.1, "stop_stiffness": 4.0, "constant": -0.2}, -0.1 - 0.05),
    ],
)
def test_a_link_rests_where_what_pulls_beside_its_drive_balances(drive: dict[str, float], rest: float) -> None:
    motion = free(pendulum(gravity=0.0, viscous=0.4, **drive), 0.0, 4.0)
    assert motion.link[-1, 0] == pytest.approx(rest, abs=1e-3)


def test_a_payload_is_carried_at_its_place() -> None:
    robot = robots.BUILDERS["pendulum"](np.random.default_rng(2))
    chain, loaded = robot.plant().chain, robot.plant()
    told = planted.plant("payload", loaded, robot, 0, 1.0, np.random.default_rng(3)).parameters
    q, still = np.array([0.7]), np.zeros(1)
    lever = told["x"] * np.cos(0.7) + told["z"] * np.sin(0.7)  # along x, of a link that is turned about y
    more = loaded.chain.torque(q, still, still) - chain.torque(q, still, still)
    assert more[0] == pytest.approx(-told["mass"] * GRAVITY * lever)
    swing = loaded.chain.torque(q, still, np.ones(1)) - loaded.chain.torque(q, still, still)
    swing -= chain.torque(q, still, np.ones(1)) - chain.torque(q, still, still)
    assert swing[0] == pytest.approx(told["mass"] * (told["x"] ** 2 + told["z"] ** 2))


def test_friction_ripples_with_the_angle() -> None:
    drive = pendulum(coulomb=0.2, friction_ripple=0.5, friction_periods=3.0, friction_phase=0.2).drive[0]
    for q in (-0.4, 0.1, 0.8):
        bound = friction.bound_of(drive, 1.0, 1.0, q, 0.0)
        assert bound == pytest.approx(0.2 * (1 + 0.5 * np.sin(3.0 * q + 0.2)))


def test_a_supply_gives_what_its_chopper_draws() -> None:
    """At rest bus·(1 + R·duty²/resistance) = supply: power in is power out."""
    plant = pendulum(**HELD)
    plant.sag = 0.5
    motion = simulate(plant, np.zeros(1), np.full((1, 1), 0.8), np.ones(1), np.zeros(1), 0.1, settle=0.0)
    bus = 10.0 / (1 + 0.5 * 0.8**2 / 4.0)
    assert motion.effort[-1, 0] == pytest.approx(2.0 / 4.0 * 0.8 * bus, rel=1e-3)


def test_a_saturating_motor_holds_less_by_its_share() -> None:
    """A motor at its duty limit, held at rest: torque = (1 - share)·kt/R·volts at the reference torque."""
    share = 0.04
    assert held(9.0, saturation=share, saturation_torque=5.0)[1][-1] == pytest.approx(5.0 * (1 - share), rel=1e-3)


def test_the_catalogue_is_as_large_as_promised() -> None:
    assert {k: len(cases.catalogue(k)) for k in cases.COUNTS} == cases.COUNTS
    singles = cases.catalogue("single")
    assert len({c.name for c in singles}) == len(singles) >= 60
    assert {c.effects[0][0] for c in singles} == set(planted.EVERY)
    assert all(
        planted.fits(e, robots.BUILDERS[c.robot](np.random.default_rng(0))) for c in singles for e, _ in c.effects
    )
    half = cases.catalogue("half")
    assert {(c.sensing.rate, c.sensing.effort) for c in half} == {(100.0, False)}


@pytest.mark.skipif("REALITYGAP_DATA" not in os.environ, reason="REALITYGAP_DATA is not set: no humanoid here")
def test_the_humanoid_stands_and_sinks_into_soft_ground() -> None:
    import humanoid
    import standing

    robot = humanoid._robot()
    command = humanoid.command("squat", robot, 100.0, 0.1, 1)
    heights = []
    for ground in (standing.Ground(), standing.Ground(stiffness=3000.0, damping=100.0)):
        body = replace(humanoid._humanoid(robot), ground=ground)
        robot.peak = np.ones(len(robot.joints))
        robot.bristles(body.plant)
        _, height = standing.simulate(body, command, 0.05)
        heights.append(height[0])
    weight = 7.779 * GRAVITY
    assert heights[0] - heights[1] == pytest.approx(weight / 8 * (1 / 3000 - 1 / standing.RIGID[0]), rel=0.3)


TRUTH = {
    "case": "c",
    "kind": "single",
    "robot": "planar",
    "truth": [{"effect": "coulomb_friction", "target": "elbow", "parameters": {"torque": 0.2}, "twins": []}],
    "outside": None,
    "tolerated": [],
    "sensing": asdict(Sensing()),
    "joints": ["shoulder", "elbow"],
}
NOTHING = {**TRUTH, "kind": "nothing", "truth": []}
TILT = {
    **TRUTH,
    "truth": [
        {
            "effect": "base_tilt",
            "target": "base",
            "parameters": {"roll": 0.0, "pitch": 0.1},
            "twins": [["joint_offset", "shoulder"]],
        }
    ],
}
BUS = {**TRUTH, "truth": [{"effect": "command_delay", "target": "*", "parameters": {"time": 0.01}, "twins": []}]}


def found(effect: str, target: object, *others: tuple[str, str], **parameters: float) -> dict:
    return {
        "effect": effect,
        "target": target,
        "parameters": {k: {"value": v, "low": v, "high": v, "unit": ""} for k, v in parameters.items()},
        "cannot_tell_from": [{"effect": e, "target": t, "why": ""} for e, t in others],
    }


def diagnosis(*findings: dict, before: float = 5.0, after: float = 1.2) -> dict:
    return {"verdict": "explained", "findings": list(findings), "gap": {"held_out": {"before": before, "after": after}}}


FRICTION = found("coulomb_friction", "elbow", torque=0.21)
ELSE = [("viscous_friction", "elbow"), ("backlash", "elbow"), ("torque_ripple", "elbow")]


@pytest.mark.parametrize(
    ("truth", "findings", "first", "exact", "wrong", "missed"),
    [
        (TRUTH, [FRICTION], True, True, 0, 0),
        (TRUTH, [], False, False, 0, 1),
        (TRUTH, [found("coulomb_friction", "shoulder")], False, False, 1, 1),
        (TRUTH, [found("coulomb_friction", ["elb*"])], True, True, 0, 0),
        (TRUTH, [found("coulomb_friction", "*")], False, False, 1, 1),
        (TRUTH, [found("stribeck_friction", "elbow", ("coulomb_friction", "elbow"))], True, True, 0, 0),
        (TRUTH, [found("stribeck_friction", "elbow", *ELSE, ("coulomb_friction", "elbow"))], False, False, 1, 1),
        (TRUTH, [FRICTION, found("rotor_inertia", "elbow")], True, False, 1, 0),
        (TRUTH, [found("rotor_inertia", "elbow"), FRICTION], False, False, 1, 0),
        (TRUTH, [FRICTION, FRICTION], True, False, 1, 0),
        (TILT, [found("joint_offset", "shoulder")], True, True, 0, 0),
        (TILT, [found("joint_offset", "elbow")], False, False, 1, 1),
        (BUS, [found("command_delay", ["shoulder", "elbow"])], True, True, 0, 0),
        (NOTHING, [], None, True, 0, 0),
        (NOTHING, [FRICTION], None, False, 1, 0),
        ({**NOTHING, "tolerated": [["coulomb_friction", "elbow"]]}, [FRICTION], None, True, 0, 0),
    ],
)
def test_the_judge(truth: dict, findings: list[dict], first: bool | None, exact: bool, wrong: int, missed: int) -> None:
    score = judge.judge(truth, diagnosis(*findings))
    assert (score.first_right, score.exact, score.wrong, score.missed) == (first, exact, wrong, missed)


LEANS = {
    **TRUTH,
    "truth": [
        {
            "effect": "direction_friction",
            "target": "elbow",
            "parameters": {"forward": 0.1, "backward": 0.3},
            "twins": [],
        }
    ],
}
LEANS_IN_TWO = {
    **TRUTH,
    "truth": [
        {"effect": "coulomb_friction", "target": "elbow", "parameters": {"torque": 0.2}, "twins": []},
        {"effect": "constant_effort", "target": "elbow", "parameters": {"effort": 0.1}, "twins": []},
    ],
}


def test_friction_that_leans_is_one_law_in_two_wordings() -> None:
    two = [found("coulomb_friction", "elbow", torque=0.2), found("constant_effort", "elbow", effort=0.1)]
    one = found("direction_friction", "elbow", forward=0.1, backward=0.3)
    for truth, findings in ((LEANS, two), (LEANS_IN_TWO, [one])):
        score = judge.judge(truth, diagnosis(*findings))
        assert score.exact
        assert score.parameter_error == pytest.approx(0.0, abs=1e-9)
    assert not judge.judge(LEANS, diagnosis(two[0])).exact


def spread_truth(shared: bool) -> dict:
    one = {"effect": "coulomb_friction", "parameters": {"torque": 0.2}, "twins": []}
    places = ["*"] if shared else TRUTH["joints"]
    return {**TRUTH, "kind": "several", "truth": [{**one, "target": t} for t in places]}


@pytest.mark.parametrize("shared", [True, False])
def test_several_effects_are_counted_at_each_joint(shared: bool) -> None:
    truth = spread_truth(shared)
    whole = judge.judge(truth, diagnosis(found("coulomb_friction", "*", torque=0.2)))
    apart = judge.judge(truth, diagnosis(*(found("coulomb_friction", j, torque=0.2) for j in truth["joints"])))
    assert (whole.exact, apart.exact) == (True, True)
    part = judge.judge(truth, diagnosis(FRICTION, found("backlash", "elbow")))
    assert (part.truths, part.names, part.names_right, part.wrong, part.missed) == (2, 2, 1, 1, 1)
    told = found("stribeck_friction", "*", ("coulomb_friction", "*"))
    assert judge.judge(truth, diagnosis(told)).names_right == 2


def test_the_judge_counts_intervals_that_hold_the_truth() -> None:
    wide, narrow = found("coulomb_friction", "elbow", torque=0.21), found("coulomb_friction", "elbow", torque=0.21)
    wide["parameters"]["torque"] |= {"low": 0.19, "high": 0.23}
    narrow["parameters"]["torque"] |= {"low": 0.205, "high": 0.215}
    scores = [judge.judge(TRUTH, diagnosis(f)) for f in (wide, narrow)]
    assert [(s.fitted, s.covered) for s in scores] == [(1, 1), (1, 0)]


def test_a_phase_is_the_same_one_turn_on() -> None:
    planted_ripple = {"amplitude": 0.1, "periods": 8.0, "phase": -3.1}
    truth = {"effect": "torque_ripple", "target": "elbow", "parameters": planted_ripple, "twins": []}
    ripple = found("torque_ripple", "elbow", **planted_ripple)
    ripple["parameters"]["phase"] |= {"low": 3.1, "high": 3.3}
    assert judge.coverage(ripple, truth) == (2, 2)  # periods are held


def test_an_unnamed_effort_is_right_outside_the_list_alone() -> None:
    shape = found("effort_map", "elbow") | {"variables": ["angle"]}
    outside = {**NOTHING, "kind": "outside", "outside": {"what": "an effort", "variables": ["position"]}}
    score = judge.judge(outside, diagnosis(shape))
    assert (score.silent, score.variables_right) == (True, True)
    speed = judge.judge(outside, diagnosis({**shape, "variables": ["speed"]}))
    assert (speed.silent, speed.variables_right) == (True, False)
    assert not judge.judge(NOTHING, diagnosis(shape)).silent


def test_what_keeps_laws_nearly_right_is_a_wrong_name_and_known_as_such() -> None:
    truth = {**NOTHING, "kind": "nearly_nothing", "besides": [["friction_ripple", "elbow"]]}
    score = judge.judge(truth, diagnosis(found("friction_ripple", "elbow"), FRICTION))
    assert (score.exact, score.wrong, score.besides) == (False, 2, 1)


def test_of_sealed_seeds_only_totals_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    score = judge.judge({**TRUTH, "case": "6/single_000"}, diagnosis(FRICTION))
    run.report([score], {}, tmp_path, "blind_sealed", run.sealed(6))
    assert [p.name for p in tmp_path.iterdir()] == ["blind_sealed_kinds.csv"]
    told = capsys.readouterr().out + (tmp_path / "blind_sealed_kinds.csv").read_text()
    assert "100 % (1/1)" in told
    assert "single_000" not in told
    assert not run.sealed(1)


def test_a_truth_is_used_once_and_plain_names_go_first() -> None:
    truths = [dict(TRUTH["truth"][0]), {**TRUTH["truth"][0], "effect": "stribeck_friction"}]
    both = [found("stribeck_friction", "elbow", ("coulomb_friction", "elbow")), FRICTION]
    assert matching.match(both, truths, TRUTH["joints"]) == [1, 0]


def test_the_judge_measures_parameters_and_gap() -> None:
    score = judge.judge(TRUTH, diagnosis(FRICTION))
    assert score.parameter_error == pytest.approx(0.05)
    assert score.gap_removed == pytest.approx(3.8 / 4.0)
    tilted = found("base_tilt", "base", roll=0.01, pitch=0.1)
    assert judge.judge(TILT, diagnosis(tilted)).parameter_error == pytest.approx(0.1)


def test_a_diagnosis_that_was_not_written_is_right_nowhere() -> None:
    score = judge.judge(NOTHING, None)
    assert (score.exact, score.silent, score.verdict) == (False, False, "failed")


def test_the_tables_count_what_was_judged(tmp_path: Path) -> None:
    wrong = judge.judge({**TRUTH, "case": "d"}, diagnosis(found("backlash", "elbow")))
    scores = [judge.judge(TRUTH, diagnosis(FRICTION)), wrong, judge.judge(NOTHING, diagnosis())]
    counts = summary.confusion(scores)
    assert counts["coulomb_friction", "coulomb_friction"] == 1
    assert counts["coulomb_friction", "backlash"] == 1
    assert counts["nothing", "nothing"] == 1
    rows = {what: reached for what, _, reached in summary.goals(scores, {"c": 12.0})}
    assert rows["single effects: first name right"] == "50 % (1/2)"
    assert rows["nothing missing: nothing named"] == "100 % (1/1)"
    summary.write_scores(scores, tmp_path / "blind.csv")
    summary.write_confusion(scores, tmp_path, "blind")
    assert len((tmp_path / "blind.csv").read_text().splitlines()) == 4
    assert (tmp_path / "blind_confusion.png").stat().st_size > 0
