"""Effects of firmware, power stages and fittings, planted on a foreign plant: what they mean is DESIGN.md's.

Parameters are totals, as in DESIGN.md. `size` scales the departure from the model: 1 is plain, 0.5 is half of it.
"""

import numpy as np
from draws import Plant, Rng, Values, sign
from foreign import Foreign
from robots import Robot, _rounded


def payload(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    """A point mass on the link's far half, a little aside."""
    mass, length = _rounded(size * rng.uniform(0.18, 0.30) * p.chain.mass[j]), r.links[j].length
    place = _rounded(np.array([sign(rng) * rng.uniform(0.05, 0.2) * length, 0.0, -rng.uniform(0.5, 1.0) * length]))
    before, com = p.chain.mass[j], p.chain.com[j].copy()
    arm = place - com
    p.chain.mass[j] = before + mass
    p.chain.com[j] = com + mass / (before + mass) * arm
    p.chain.inertia[j] += before * mass / (before + mass) * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return {"mass": mass, **dict(zip("xyz", map(float, place), strict=True))}


def dead_band(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    width = _rounded(size * rng.uniform(0.03, 0.06) * r.reach)
    p.drive["dead_band"][j] = width
    return {"width": width}


def joint_stop(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    """A bracket on one side, within the reach of the motions."""
    side = sign(rng)
    angle = _rounded(side * max(0.15, 0.5 - 0.2 * size * rng.uniform(0.3, 1.0)) * r.reach)
    stiffness = _rounded(rng.uniform(10.0, 30.0) * r.peak[j] / r.reach)
    p.drive["stop_upper" if side > 0 else "stop_lower"][j], p.drive["stop_stiffness"][j] = angle, stiffness
    return {"upper" if side > 0 else "lower": angle, "stiffness": stiffness}


def command_profile(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    speed = _rounded(max(0.15, 1.0 - size * rng.uniform(0.4, 0.6)) * r.fastest[j])
    p.drive["profile_speed"][j] = speed
    if rng.random() < 0.5:
        return {"speed": speed}
    acceleration = _rounded(speed / rng.uniform(0.05, 0.15))
    p.drive["profile_acceleration"][j] = acceleration
    return {"speed": speed, "acceleration": acceleration}


def effort_limit(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    """The motor's limit, in a third of the cases with protection that gives way to large errors."""
    effort = _rounded(max(0.25, 1.0 - size * rng.uniform(0.35, 0.5)) * r.peak[j])
    p.drive["real_limit"][j] = effort
    if rng.random() > 1 / 3:
        return {"effort": effort}
    beyond, share = _rounded(rng.uniform(0.2, 0.4) * r.reach), _rounded(rng.uniform(0.3, 0.6))
    p.drive["protection"][j], p.drive["protection_share"][j] = beyond, share
    return {"effort": effort, "beyond": beyond, "share": share}


def direction_friction(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    own = p.drive["coulomb"][j]
    sides = [own + size * rng.uniform(0.03, 0.08) * r.torque[j], own + size * rng.uniform(0.15, 0.28) * r.torque[j]]
    forward, backward = (_rounded(x) for x in (sides if rng.random() < 0.5 else sides[::-1]))
    p.drive["coulomb"][j] = p.drive["static"][j] = 0.5 * (forward + backward)
    p.drive["lean"][j] = 0.5 * (forward - backward)
    return {"forward": forward, "backward": backward}


def friction_ripple(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    """Of the friction that the model knows: `cases` draws a robot that has some."""
    share = _rounded(min(0.95, size * rng.uniform(0.4, 0.7)))
    turns, phase = _rounded(rng.uniform(2.0, 9.0) / r.reach), _rounded(rng.uniform(-np.pi, np.pi))
    d = p.drive
    d["friction_ripple"][j], d["friction_periods"][j], d["friction_phase"][j] = share, turns, phase
    return {"share": share, "periods": turns, "phase": phase}


def cable_spring(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    stiffness = _rounded(size * rng.uniform(0.15, 0.30) * r.torque[j] / r.reach)
    rest = _rounded(rng.uniform(-0.6, 0.6) * r.reach)
    p.drive["spring"][j], p.drive["spring_rest"][j] = stiffness, rest
    return {"stiffness": stiffness, "rest": rest}


def motor_braking(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    share = _rounded(min(1.0, size * rng.uniform(0.3, 1.0)))
    p.drive["braking"][j] = share
    return {"share": share}


def current_lag(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    time = _rounded(size * rng.uniform(0.006, 0.015))
    p.drive["lag"][j] = time
    return {"time": time}


def gain_law(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    exponent = _rounded(1.0 - size * rng.uniform(0.15, 0.25) * sign(rng))
    p.drive["gain_exponent"][j] = exponent
    return {"exponent": exponent}


def servo_rate(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    rate = _rounded(rng.uniform(45.0, 90.0) / size)
    p.drive["rate"][j] = rate
    return {"rate": rate}


def derivative_lag(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    """Some samples of a drive's own clock. Only a cascade servo answers a rate enough for that to show.

    A pid servo's own derivative gain is not planted: the kick that it gives where a command is stepped hangs on the
    period of its loop, and how much of it the effort's limit cuts off does, too, which no recording tells.
    """
    time = _rounded(size * rng.uniform(0.0015, 0.003))
    p.drive["derivative_lag"][j] = time
    return {"time": time}


def motor_saturation(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    """A quarter and more of the largest torque is lost, of small ones little."""
    lost = size * rng.uniform(0.25, 0.40)
    saturation = _rounded(lost / (1.0 - lost) / r.peak[j])
    p.drive["saturating"][j] = saturation
    return {"saturation": saturation}


def effort_hysteresis(p: Foreign, r: Robot, j: int, size: float, rng: Rng) -> Values:
    """The motor's current is told less, or more, the way it turns."""
    effort, onset = _rounded(size * rng.uniform(0.1, 0.25) * r.torque[j] * (1 if rng.random() < 0.7 else -1)), 0.05
    p.drive["hysteresis"][j], p.drive["hysteresis_speed"][j] = effort, onset
    return {"effort": effort, "onset": onset}


EFFECTS: dict[str, Plant] = {
    "payload": payload,
    "dead_band": dead_band,
    "joint_stop": joint_stop,
    "command_profile": command_profile,
    "effort_limit": effort_limit,
    "direction_friction": direction_friction,
    "friction_ripple": friction_ripple,
    "cable_spring": cable_spring,
    "motor_braking": motor_braking,
    "current_lag": current_lag,
    "gain_law": gain_law,
    "servo_rate": servo_rate,
}
LATER: dict[str, Plant] = {
    "derivative_lag": derivative_lag,
    "motor_saturation": motor_saturation,
    "effort_hysteresis": effort_hysteresis,
}
"""Behind the others in the suite, whose cases stay as they are."""
