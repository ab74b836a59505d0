"""Friction of the foreign plant: bristles (elasto-plastic, Dupont et al. 2002), and drag.

A stuck joint is a stiff spring, not a constraint.
"""

import numba
import numpy as np


@numba.njit(cache=True)
def bound_of(d, speed, side, q, through):  # type: ignore[no-untyped-def]
    """The largest dry friction on the side to which the bristles are bent: 1 forward, -1 backward, 0 neither."""
    bound = d.coulomb
    if d.static != d.coulomb:
        bound += (d.static - d.coulomb) * np.exp(-((speed / d.stribeck_velocity) ** d.stribeck_exponent))
    bound += d.lean * side
    if d.load != 0.0 or d.load_static != 0.0:
        share = d.load
        if d.load_static != 0.0:
            share += d.load_static * np.exp(-((speed / d.load_velocity) ** d.load_exponent))
        bound += share * through
    if d.friction_ripple != 0.0:
        bound *= 1.0 + d.friction_ripple * np.sin(d.friction_periods * q + d.friction_phase)
    if d.uneven_direction != 0.0 or d.uneven_angle != 0.0:
        bound *= 1.0 + d.uneven_direction * side + d.uneven_angle * np.sin(d.uneven_periods * q + d.uneven_phase)
    return bound


@numba.njit(cache=True)
def bristle(d, s, v, q, h):  # type: ignore[no-untyped-def]
    """Bristle force at sliding speed v and angle q; moves the deflection (backward Euler: stiff at high speed)."""
    side = np.sign(s.bristle) if s.bristle != 0.0 else np.sign(v)
    bound = bound_of(d, abs(v), side, q, s.through)
    if bound <= 0.0 or d.bristle <= 0.0:
        s.bristle = 0.0
        return 0.0
    edge, z = bound / d.bristle, s.bristle
    plastic = 0.0
    if z * v > 0.0:  # elasto-plastic: no creep below 70 % of break-away
        x = (abs(z) / edge - 0.7) / 0.3
        plastic = 0.0 if x <= 0.0 else (1.0 if x >= 1.0 else x * x * (3.0 - 2.0 * x))
    s.bristle = (z + h * v) / (1.0 + h * plastic * abs(v) / edge)
    if abs(s.bristle) > edge and z * v <= 0.0:  # the bound fell while the joint came back
        s.bristle = edge if s.bristle > 0.0 else -edge
    return d.bristle * s.bristle + d.bristle_damping * (s.bristle - z) / h


@numba.njit(cache=True)
def drag(d, w):  # type: ignore[no-untyped-def]
    """Viscous friction, which thins with speed where the law is only nearly right."""
    if d.thinning == 0.0:
        return d.viscous * w
    return d.viscous * w * max(0.5, 1.0 - d.thinning * abs(w))
