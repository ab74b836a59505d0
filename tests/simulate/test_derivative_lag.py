"""A servo whose own speed is late, against closed forms in every engine."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from one_joint import ARMATURE, LINK, everywhere, run, wheel
from realitygap.robot.drive import CASCADE, EFFORT, PID, POSITION, SPEED, VELOCITY
from realitygap.robot.effects import EFFECTS
from realitygap.robot.plant import Plant
from realitygap_engines.model.robot import Array

INERTIA = LINK + ARMATURE
STIFF, DAMPED, GOAL = 2.0, 0.12, 0.3
KINDS = {"pid": PID, "cascade": CASCADE, "velocity": SPEED}


def servo(kind: str, lag: float) -> Plant:
    """A wheel whose servo answers an error by `STIFF` and a speed by `DAMPED`; a velocity servo by `DAMPED` alone."""
    plant = wheel()
    d = plant.drive
    d["kind"], d["meaning"] = KINDS[kind], VELOCITY if kind == "velocity" else POSITION
    if kind == "pid":
        d["kp"], d["kd"] = STIFF, DAMPED
    else:
        d["kp"], d["kv"], d["gain"] = STIFF / DAMPED, DAMPED, 1.0
    if kind == "velocity":
        d["gain"] = DAMPED
    d["effort_limit"] = np.inf
    EFFECTS["derivative_lag"].apply(plant, [0], {"time": lag})
    return plant


def exact(polynomial: list[float], start: list[float], time: Array) -> Array:
    """What solves a linear equation with these coefficients, from a value and its rates."""
    roots = np.roots(polynomial).astype(complex)
    weights = np.linalg.solve(np.vander(roots, increasing=True).T, np.array(start, dtype=complex))
    return np.asarray((weights[:, None] * np.exp(roots[:, None] * time)).sum(axis=0).real)


@everywhere
@pytest.mark.parametrize("lag", [1e-3, 20e-3])
@pytest.mark.parametrize("kind", ["pid", "cascade"])
def test_a_late_speed_makes_a_stiff_joint_ring(kind: str, lag: float, engine: str) -> None:
    """lag·v' + v = q', J·q'' = k·(goal − q) − d·v: an oscillator of third order."""
    out = run(servo(kind, lag), GOAL, engine=engine)
    lacking = exact(
        [INERTIA * lag, INERTIA, STIFF * lag + DAMPED, STIFF], [-GOAL, 0.0, STIFF * GOAL / INERTIA], out.time
    )
    assert_allclose(out.position[:, 0], GOAL + lacking, atol=2e-3)


@everywhere
def test_a_velocity_servo_whose_speed_is_late_overshoots(engine: str) -> None:
    """lag·v' + v = ω, J·ω' = d·(goal − v)."""
    lag = 0.2
    out = run(servo("velocity", lag), 1.0, 2.0, engine=engine)
    lacking = exact([INERTIA * lag, INERTIA, DAMPED], [-1.0, DAMPED / INERTIA], out.time)
    assert_allclose(out.velocity[:, 0], 1.0 + lacking, atol=5e-3)
    assert (1.0 + lacking).max() > 1.1


def test_the_whole_derivative_of_a_pid_servo_is_late() -> None:
    """Of a joint that nothing moves: d·rate·(1 − exp(−t/lag)) once the command rises."""
    lag, rate = 20e-3, 0.5
    plant = servo("pid", lag)
    plant.drive["armature"] = 1e9
    begin, time = 0.1, 1e-3 * np.arange(400)
    out = run(plant, rate * np.maximum(time - begin, 0.0), 0.39)
    rising = out.time > begin + 1e-3
    given = out.effort[rising, 0] - STIFF * out.command[rising, 0]
    since = out.time[rising] - begin
    assert_allclose(given, DAMPED * rate * (1.0 - np.exp(-since / lag)), atol=2e-3)


def test_a_lag_seems_to_take_mass_away() -> None:
    """Slow against its lag a cascade that answers d to a speed seems lighter by d·lag (series of the lag)."""
    lag = 5e-3
    late, light, bare = servo("cascade", lag), servo("cascade", 0.0), servo("cascade", 0.0)
    light.drive["armature"] = ARMATURE - DAMPED * lag
    moved = [run(plant, GOAL).position for plant in (late, light, bare)]
    assert np.abs(moved[0] - moved[1]).max() < 0.1 * np.abs(moved[0] - moved[2]).max()


@pytest.mark.parametrize("kind", KINDS)
def test_a_lag_of_a_hundredth_of_a_step_is_none(kind: str) -> None:
    late, bare = (run(servo(kind, lag), GOAL) for lag in (1e-5, 0.0))
    assert_allclose(late.position, bare.position, atol=1e-5)


def test_what_answers_no_speed_has_no_such_lag() -> None:
    possible = EFFECTS["derivative_lag"].possible
    dc, undamped, told = wheel(), servo("pid", 0.0), servo("cascade", 0.0)
    undamped.drive["kd"] = 0.0
    told.drive["meaning"] = EFFORT
    for plant in (dc, undamped, told):
        assert "expected one of kind pid with a kd, cascade or velocity" in str(possible(plant, 0))
    assert all(possible(servo(kind, 0.0), 0) is None for kind in KINDS)
