"""Laws of a drive know no side but those that say one: a motion that is turned about is the same motion."""

import numpy as np
import pytest
import realitygap_engines as engines
from numpy.testing import assert_allclose
from realitygap.robot.drive import CASCADE, PID, SPEED, VELOCITY
from realitygap.robot.plant import Plant
from realitygap.simulate.commands import Commands
from realitygap.simulate.effect_bench import arm
from realitygap.simulate.rollout import rollout
from realitygap_engines import Physics, State
from realitygap_engines.model.robot import Array
from signals import Signals

TIME = np.arange(0.0, 1.2, 1e-3)
COMMAND = np.where(TIME < 0.6, 1.5 * np.sin(8.0 * TIME), 0.9)
DRIVES: dict[str, dict[str, float]] = {
    "dc": {},
    "pid": {"kind": PID, "kp": 30.0, "ki": 10.0, "kd": 0.8},
    "cascade": {"kind": CASCADE, "gain": 0.05, "kv": 20.0, "kp": 30.0, "derivative_lag": 2e-3},
    "velocity": {"kind": SPEED, "meaning": VELOCITY, "gain": 0.8},
    "speed limit": {"kind": PID, "kp": 80.0, "kd": 0.2, "velocity_limit": 2.0},
    "effort limit": {"kind": PID, "kp": 80.0, "kd": 0.2, "ki": 5.0, "effort_limit": 1.5},
    "protection": {"protection": 0.3, "protection_share": 0.2},
    "firmware": {"dead_band": 0.05, "gain_exponent": 0.7, "servo_rate": 90.0},
    "profile": {"profile_speed": 3.0, "profile_acceleration": 60.0},
    "power": {"saturation": 0.1, "real_limit": 3.0, "lag": 0.01, "heating": 0.1},
    "line": {"stall_torque": 3.0, "no_load_speed": 4.0, "sag_resistance": 0.5},
    "friction": {"coulomb": 0.1, "static": 0.2, "load": 0.2, "load_static": 0.2, "viscous": 0.1},
    "friction that builds up": {"coulomb": 0.1, "static": 0.1, "presliding": 0.01, "lean": 0.05},
    "creeping friction": {"coulomb": 0.1, "static": 0.1, "onset": 0.5, "lean": 0.05},
    "friction by side": {"coulomb": 0.2, "static": 0.2, "lean": 0.1, "viscous": 0.1, "viscous_asymmetry": 0.5},
    "uneven friction": {"coulomb": 0.2, "static": 0.2, "friction_ripple": 0.6, "friction_phase": 0.4},
    "ripple": {"ripple": 0.3, "ripple_periods": 5.0, "ripple_phase": 0.7},
    "play": {"backlash": 0.1, "give_damping": 0.02, "coulomb": 0.05, "static": 0.05},
    "compliance": {"stiffness": 40.0, "give_damping": 0.05, "coulomb": 0.05, "static": 0.05},
    "stop": {"stop_lower": -0.4, "stop_upper": 0.7, "stop_stiffness": 200.0},
    "pulls": {"cable_stiffness": 2.0, "cable_rest": 0.6, "constant": 0.4, "offset": 0.1},
}
TURNED = ("lean", "viscous_asymmetry", "ripple_phase", "cable_rest", "constant", "offset")
"""What has the other sign on the other side."""


def turned(drive: dict[str, float]) -> dict[str, float]:
    """The same drive on the other side."""
    out = {name: -value if name in TURNED else value for name, value in drive.items()}
    if "friction_phase" in drive:
        out["friction_phase"] = np.pi - drive["friction_phase"]
    if "stop_lower" in drive:
        out["stop_lower"], out["stop_upper"] = -drive["stop_upper"], -drive["stop_lower"]
    return out


def moved(drive: dict[str, float], command: Array) -> Signals:
    plant: Plant = arm()
    for name, value in drive.items():
        plant.drive[name] = value
    with engines.load("mujoco").open(plant.machine(), Physics(1e-3, gravity=(0.0, 0.0, 0.0))) as simulation:
        commands = Commands(TIME, command[:, None], held=False)
        return Signals(rollout(simulation, plant, commands, State(np.zeros(1), np.zeros(1)), TIME[-1]).trace)


@pytest.mark.parametrize("drive", DRIVES.values(), ids=list(DRIVES))
def test_a_motion_that_is_turned_about_is_the_same(drive: dict[str, float]) -> None:
    there, back = moved(drive, COMMAND), moved(turned(drive), -COMMAND)
    assert np.ptp(there.position) > 0.1
    for signal in ("position", "velocity", "effort"):
        size = np.abs(getattr(there, signal)).max()
        assert_allclose(getattr(back, signal), -getattr(there, signal), rtol=0, atol=1e-7 * size, err_msg=signal)
