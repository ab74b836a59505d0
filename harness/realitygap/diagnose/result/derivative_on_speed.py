"""What a delay may be where a servo damps its own speed alone: it lags behind one whose D acts on the error by kd/kp.

kp·(r - q) - kd·q̇ = kp·(r - kd/kp·ṙ - q) + kd·(ṙ - q̇): to first order in kd/kp, that of the error and a command that is
late by as much.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.problem import Problem
from realitygap.page.style import number, quantity
from realitygap.robot.drive import PID

Interval = Callable[[Change, str], tuple[float, float]]


def derivative_on_speed(problem: Problem, changes: Iterable[Change], interval: Interval) -> list[str]:
    """A sentence on every delay whose 95 % interval holds kd/kp of all of its servos, which have a D and no I.

    Args:
        problem: of the diagnosis.
        changes: what was found.
        interval: the 95 % interval of a parameter of a change.
    """
    drive, said = problem.plant.drive, []
    for change in (c for c in changes if c.suspect.effect == "command_delay"):
        low, high = interval(change, "time")
        own = drive[list(change.suspect.indices)]
        damped = (own["kind"] == PID) & (own["kp"] > 0.0) & (own["kd"] > 0.0) & (own["ki"] == 0.0)
        if not damped.all():
            continue
        late = own["kd"] / own["kp"]
        if low <= late.min() and late.max() <= high:
            said.append(
                f"{change.suspect} is kd/kp, {quantity(float(late[0]), 's')}: a servo whose D acts on the measured "
                f"speed alone is late by that, without a delay; try `kind: cascade` with gain {number(own['kd'][0])}, "
                f"kv 1 and kp {number(own['kp'][0] / own['kd'][0])} in the place of `kind: pid`, and diagnose again"
            )
    return said
