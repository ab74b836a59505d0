"""The drive of a servo comes back from its motions: a planted one, and the recorded MX 106."""

import os
from pathlib import Path

import numpy as np
import pytest
from realitygap.bench import servo
from realitygap.bench.drive_fit import fit_current, fit_duty, fit_rotor, solve_drive
from realitygap.bench.motion import BenchMotion, Pendulum
from realitygap.files.errors import InputError
from thesis_servo import BENCH


def planted_motion(
    pendulum: Pendulum, *, fast: bool, armature: float, coulomb: float, coefficient: float
) -> BenchMotion:
    """A motor with torque constant 2.0 N·m/A that follows a sine or a chirp exactly."""
    time = np.arange(0, 12.0 if not fast else 5.0, 1 / 300)
    phase = time**2 if fast else np.pi * time / 2
    rate, growth = (2 * time, 2.0) if fast else (np.pi / 2 + 0 * time, 0.0)
    position = np.pi / 3 * np.sin(phase)
    velocity = np.pi / 3 * np.cos(phase) * rate
    acceleration = np.pi / 3 * (np.cos(phase) * growth - np.sin(phase) * rate**2)
    load = pendulum.torque(position, acceleration)
    way = np.sign(velocity)
    rotor = armature * acceleration
    # with the rotor on the motor's side, the transmitted torque is half of motor and load torque together
    motor = load + rotor
    for _ in range(60):
        motor = load + rotor + way * (coulomb + coefficient * np.abs(motor + load) / 2)
    return BenchMotion("planted", time, position, velocity, acceleration, motor / 2.0, None, pendulum)


LOADED = [Pendulum(0.01 + 0.0075 * i, 0.58 + 0.44 * i) for i in range(5)]


def test_torque_per_ampere_and_load_dependent_friction_come_back() -> None:
    motions = [planted_motion(p, fast=False, armature=0.0, coulomb=0.0, coefficient=0.3) for p in LOADED]
    found = fit_current(motions, 0.0)
    assert found.torque_constant.value == pytest.approx(2.0, rel=1e-3)
    assert found.load_dependent.value == pytest.approx(0.3, abs=3e-3)
    assert found.coulomb.value == pytest.approx(0.0, abs=3e-3)
    assert found.residual < 0.1 * found.residual_without


def test_slow_and_fast_motion_together_tell_torque_per_ampere_from_rotor_inertia() -> None:
    """A slow sine's acceleration has the shape of the load: alone it takes rotor inertia for torque per ampere."""
    planted = {"armature": 0.027, "coulomb": 0.05, "coefficient": 0.2}
    sines = [planted_motion(p, fast=False, **planted) for p in LOADED]
    chirps = [planted_motion(p, fast=True, **planted) for p in (LOADED[0], LOADED[2])]
    constant, _, armature = solve_drive(sines, chirps)
    assert constant == pytest.approx(2.0, rel=5e-3)
    assert armature == pytest.approx(0.027, rel=0.01)
    alone, _, _ = solve_drive(sines, [])
    assert alone > 2.05


def test_coulomb_friction_alone_is_no_load_dependence() -> None:
    motions = [planted_motion(p, fast=False, armature=0.0, coulomb=0.2, coefficient=0.0) for p in LOADED]
    found = fit_current(motions, 0.0)
    assert found.coulomb.value == pytest.approx(0.2, abs=1e-3)
    assert found.load_dependent.value == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("armature", [0.01, 0.03])
def test_the_rotor_inertia_comes_back(armature: float) -> None:
    motion = planted_motion(LOADED[0], fast=True, armature=armature, coulomb=0.1, coefficient=0.2)
    found, unexplained = fit_rotor(motion, 2.0)
    assert found.value == pytest.approx(armature, rel=1e-3)
    assert unexplained < 1e-3


def test_speed_per_duty_comes_back() -> None:
    time = np.arange(0, 10, 1 / 300)
    duty = np.round(np.sin(time * 1.7), 1).astype(np.float64)
    position = 0.5 * np.sin(time)
    velocity = 5.2 * (duty - 0.02 * np.sign(duty) - 0.05 * position)
    keep = np.abs(duty) > 0.15  # where the friction does not decide the direction
    motion = BenchMotion("planted", time, position, velocity, 0 * time, 0 * time, duty, None).rows(keep)
    found = fit_duty([motion])
    assert found.no_load_speed.value == pytest.approx(5.2, rel=1e-6)
    assert found.coulomb.value == pytest.approx(0.02, rel=1e-4)
    assert found.restoring.value == pytest.approx(0.05, rel=1e-4)


@pytest.mark.skipif("REALITYGAP_DATA" not in os.environ, reason="REALITYGAP_DATA (the recordings) is not set")
def test_the_recorded_mx106(tmp_path: Path) -> None:
    """Near the published identification of another unit (Rhoban/bam: 2.19 N·m/A, armature 0.0266 kg·m²), not at it.

    The torque constant here is per reported ampere. The bounds are a tenth and, for the armature, the spread that the
    smoothing makes; a rotor inertia left out of the slow motion would still pass them, which the planted test sees.
    """
    bench = BENCH.parent.parent / "bench_mx106_recordings" / "bench.yaml"
    text = "\n".join(servo.run(bench, tmp_path).lines)
    constant = float(text.split("torque per ampere")[1].split()[0])
    armature = float(text.split("\narmature: ")[1].split()[0])
    assert constant == pytest.approx(2.19, rel=0.1)
    assert 0.017 < armature < 0.033
    assert "The hysteresis grows with the load: load-dependent friction is there." in text
    assert "cannot be read from this current" in text
    assert "by the choice of smoothing" in text


def test_sines_under_two_loads_are_too_few(tmp_path: Path) -> None:
    arm = "inertia: 0.01 kg·m², gravity_torque: 0.5 N·m"
    (tmp_path / "bench.yaml").write_text(
        "recordings:\n"
        "  position: {topic: /joint_states, field: position, unit: rad}\n"
        "  current: {topic: /joint_currents, field: effort, unit: A}\n"
        f"  arms: [{{name: a, {arm}}}, {{name: b, {arm}}}]\n"
        "  sines: [{path: a.bag, arm: a}, {path: b.bag, arm: b}]\n",
        encoding="utf-8",
    )
    with pytest.raises(InputError, match="found 2 arms, expected at least 3 loads"):
        servo.run(tmp_path / "bench.yaml", tmp_path / "out")
