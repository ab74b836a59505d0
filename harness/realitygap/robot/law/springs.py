"""Springs that pull the link itself, beside its drive: a cable, and stops."""

from realitygap_engines.law.compiled import compiled


@compiled
def springs(d, q, w, inertia, h):  # type: ignore[no-untyped-def]
    """Their torque as effort - damping·w', with w' the speed after the step and `inertia` about what the joint moves.

    A spring's angle is averaged over the three times around the step with weights (1 - l)², 2·l·(1 - l) and l². With
    l = 1/2 that is the trapezoidal rule, of second order, stable and without numerical damping. A stop that is left and
    reached within a step or two would throw the joint back faster than it came, so l grows to 1 for x = h²·stiffness
    over inertia above about 1.5, where no rebound is faster than 1.01 times the arrival (scanned over x and the depth).
    """
    stiffness = d.cable_stiffness
    pull = -stiffness * (q - d.cable_rest) if stiffness > 0.0 else 0.0
    past = min(q - d.stop_lower, 0.0) + max(q - d.stop_upper, 0.0)
    if past != 0.0 and d.stop_stiffness > 0.0:
        pull -= d.stop_stiffness * past
        stiffness += d.stop_stiffness
    x = h * h * stiffness / inertia / 1.5
    late = 1.0 - 0.5 / (1.0 + x * x)
    return pull + h * stiffness * (1.0 - late) * (1.0 - late) * w, h * stiffness * late * late
