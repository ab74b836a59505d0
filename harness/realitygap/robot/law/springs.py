"""Springs that pull the link itself, beside its drive: a cable, and stops."""

from realitygap_engines.law.compiled import compiled


@compiled
def springs(d, q, w, h):  # type: ignore[no-untyped-def]
    """Their torque as effort - damping·w', with w' the speed after the step.

    A spring's angle is averaged with weights 1/4, 1/2, 1/4 over the three times around the step: q + h·(w' - w)/4. This
    is the trapezoidal rule, of second order, stable for any stiffness and without numerical damping.
    """
    pull, stiffness = -d.cable_stiffness * (q - d.cable_rest), d.cable_stiffness
    if d.stop_stiffness > 0.0:
        if q < d.stop_lower:
            pull, stiffness = pull - d.stop_stiffness * (q - d.stop_lower), stiffness + d.stop_stiffness
        elif q > d.stop_upper:
            pull, stiffness = pull - d.stop_stiffness * (q - d.stop_upper), stiffness + d.stop_stiffness
    give = 0.25 * h * stiffness
    return pull + give * w, give
