"""The drive train of the foreign plant: servo, friction, transmission and what pulls beside them, of all joints.

Backlash and compliance are two masses with a contact stiffness and damping of their own.
"""

import numba
import numpy as np
from friction import bristle, drag
from numpy.typing import NDArray
from servo import motor_effort, position_error, supply_voltage

_NUMBERS = {
    # servo
    "gain": 0.0,
    "duty_limit": 1.0,
    "supply": 12.0,
    "torque_constant": 1.0,
    "resistance": 1.0,
    "kp": 0.0,
    "ki": 0.0,
    "kd": 0.0,
    "kv": 0.0,
    "derivative_lag": 0.0,  # of the rate that the controller answers [s]
    "effort_limit": np.inf,
    "velocity_limit": np.inf,
    "stall_torque": np.inf,
    "no_load_speed": np.inf,
    "heating": 0.0,
    "saturating": 0.0,  # share of a torque that is lost, per N·m of it, where it is small
    # firmware and power stage
    "dead_band": 0.0,  # full width
    "gain_exponent": 1.0,
    "protection": 0.0,  # error beyond which only `protection_share` of it counts; 0: none
    "protection_share": 1.0,
    "rate": 0.0,  # of the servo's own sample and hold [Hz]; 0: none
    "rate_phase": 0.0,  # of its samples, in periods
    "profile_speed": 0.0,  # 0: no bound
    "profile_acceleration": 0.0,
    "real_limit": np.inf,
    "lag": 0.0,
    "braking": 0.0,
    # sensor
    "offset": 0.0,
    "delay": 0.0,
    "hysteresis": 0.0,  # what the effort is told less by in the direction of motion
    "hysteresis_speed": 1.0,
    # friction: total bound = coulomb + (static - coulomb)·exp(…) ± lean + load terms, times the ripple
    "coulomb": 0.0,
    "static": 0.0,
    "stribeck_velocity": 1.0,
    "stribeck_exponent": 2.0,
    "lean": 0.0,  # more forward than backward
    "load": 0.0,
    "load_static": 0.0,
    "load_velocity": 1.0,
    "load_exponent": 2.0,
    "friction_ripple": 0.0,
    "friction_periods": 0.0,
    "friction_phase": 0.0,
    "viscous": 0.0,
    "bristle": 0.0,  # stiffness of the bristles [N·m/rad]
    "bristle_damping": 0.0,
    # extra torque
    "ripple": 0.0,
    "ripple_periods": 0.0,
    "ripple_phase": 0.0,
    "constant": 0.0,
    "spring": 0.0,  # of a cable or spring on the link [N·m/rad]
    "spring_rest": 0.0,
    "stop_lower": -np.inf,
    "stop_upper": np.inf,
    "stop_stiffness": 0.0,
    "bump": 0.0,  # outside the list: an effort around one angle
    "bump_at": 0.0,
    "bump_width": 1.0,
    "peak_drag": 0.0,  # outside the list: drag around one speed
    "peak_at": 0.0,
    "peak_width": 1.0,
    # transmission
    "armature": 0.0,
    "backlash": 0.0,
    "stiffness": 0.0,  # 0: none
    "output_share": 0.2,  # of the friction that sits behind the backlash
    # what keeps the laws nearly right: see `imperfections`
    "uneven_direction": 0.0,
    "uneven_angle": 0.0,
    "uneven_periods": 0.0,
    "uneven_phase": 0.0,
    "thinning": 0.0,  # of viscous friction with speed [s/rad]
    "saturation": 0.0,  # of the torque, at `saturation_torque`
    "saturation_torque": 1.0,
    "fading": 0.0,  # of the torque, long after `fading_time` [s]
    "fading_time": 1.0,
    "cable": 0.0,  # largest pull [N·m]
    "cable_rest": 0.0,
    "cable_width": 1.0,
    "stiffening": 0.0,  # of the compliance with the square of its twist [1/rad²]
}
DRIVE = np.dtype([("kind", np.int64), *((name, np.float64) for name in _NUMBERS)])
_REMEMBERED = (
    *("rotor", "rotor_w"),  # of joints with two masses
    *("bristle", "through", "link"),  # deflection; effort that passes, for friction; what the transmission gives
    *("held", "feed", "fresh"),  # the command in force, its rate, and when it came
    *("error", "seen", "count"),  # sampled error; error as the controller takes it; periods of its own rate
    *("integral", "rate", "current", "motor", "applied"),
)
STATE = np.dtype([("pointer", np.int64), ("live", np.int64), ("looks", np.int64), *((x, float) for x in _REMEMBERED)])


def drives(n: int) -> NDArray[np.void]:
    """n drives without friction and without effects. Shape (n,) of `DRIVE`."""
    out = np.zeros(n, DRIVE)
    for name, value in _NUMBERS.items():
        out[name] = value
    return out


def at_rest(q: NDArray[np.float64], command: NDArray[np.float64]) -> NDArray[np.void]:
    """What drive trains remember at rest at q with a first command. Shape (n,) of `STATE`."""
    out = np.zeros(len(q), STATE)
    out["rotor"], out["held"], out["live"] = q, command, 1
    out["fresh"] = out["count"] = -1.0
    return out


@numba.njit(cache=True)
def joint_efforts(drive, state, sag, law, bus, noise, t, h, q, w):  # type: ignore[no-untyped-def]
    """The effort that each link gets from its joint (`applied`) over one step of length h at time t; returns the
    supply.

    Joints with two masses move their rotor here.
    """
    n = drive.size
    speed = np.zeros(n)
    for j in range(n):
        d, s = drive[j], state[j]
        speed[j] = s.rotor_w if d.backlash > 0.0 or d.stiffness > 0.0 else w[j]
        s.seen = position_error(d, s, (s.rotor if d.stiffness > 0.0 else q[j]) - d.offset)
    if sag > 0.0:
        bus = supply_voltage(drive, state, speed, sag, law, bus, t, h)
    for j in range(n):
        d, s = drive[j], state[j]
        loose, soft = d.backlash > 0.0, d.stiffness > 0.0
        s.motor = motor_effort(d, s, speed[j], bus if sag > 0.0 else d.supply, t, h)
        turn = s.rotor if loose or soft else q[j]
        s.through += h / 2e-4 * (0.5 * abs(s.motor + s.link) - s.through)
        inner = s.motor - d.ripple * np.sin(d.ripple_periods * turn + d.ripple_phase) - drag(d, speed[j])
        rubbing = bristle(d, s, speed[j], turn, h)
        outer = _beside(d, q[j], w[j]) + noise[j]
        if loose:
            # a share of the friction sits at the output's bearing, where a smooth law will do
            behind = max(d.static, d.coulomb) + (d.load + d.load_static) * s.through
            s.link = _touch(d, s, q[j], w[j])
            s.applied = s.link + d.constant + outer - d.output_share * behind * np.tanh(w[j] / 2e-3)
            s.rotor_w += h * (inner - (1.0 - d.output_share) * rubbing - s.link) / d.armature
            s.rotor += h * s.rotor_w
        elif soft:
            twist = s.rotor - q[j]
            s.link = d.stiffness * twist * (1.0 + d.stiffening * twist * twist)
            s.link += 0.02 * np.sqrt(d.stiffness * d.armature) * (s.rotor_w - w[j])
            s.applied = s.link + outer
            s.rotor_w += h * (inner + d.constant - rubbing - s.link) / d.armature
            s.rotor += h * s.rotor_w
        else:
            s.applied = inner + d.constant + outer - rubbing
    return bus


@numba.njit(cache=True)
def _beside(d, q, w):  # type: ignore[no-untyped-def]
    """What pulls a link beside its drive."""
    out = -d.spring * (q - d.spring_rest)
    if q > d.stop_upper:
        out -= d.stop_stiffness * (q - d.stop_upper)
    if q < d.stop_lower:
        out -= d.stop_stiffness * (q - d.stop_lower)
    if d.cable != 0.0:
        out -= d.cable * np.tanh((q - d.cable_rest) / d.cable_width)
    if d.bump != 0.0:
        out += d.bump * np.exp(-(((q - d.bump_at) / d.bump_width) ** 2))
    if d.peak_drag != 0.0:
        out -= d.peak_drag * np.tanh(20.0 * w / d.peak_at) * np.exp(-(((abs(w) - d.peak_at) / d.peak_width) ** 2))
    return out


@numba.njit(cache=True)
def _touch(d, s, q, w):  # type: ignore[no-untyped-def]
    """What a rotor with play gives to its link."""
    gap = s.rotor - q
    over = gap - min(max(gap, -0.5 * d.backlash), 0.5 * d.backlash)
    if over == 0.0:
        return 0.0
    stiff = 4e5 * d.armature  # ω ≈ 630 rad/s at the rotor
    touch = stiff * over + 2.0 * 0.3 * np.sqrt(stiff * d.armature) * (s.rotor_w - w)
    return max(touch, 0.0) if over > 0.0 else min(touch, 0.0)
