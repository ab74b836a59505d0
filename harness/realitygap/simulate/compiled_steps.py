"""Steps of a simulation in compiled code: the same as the loop of `rollout`, where an engine's step is a C function.

Threads run several simulations side by side: Python is not held while steps are taken.
"""

from functools import partial

from realitygap_engines.law.compiled import compiled

from realitygap.robot.drive_law import drive_effort
from realitygap.robot.law.effort_map import add_mapped


@partial(compiled, nogil=True)
def stepped(  # type: ignore[no-untyped-def]
    functions, model, data, effort, damping, friction, position, velocity, pose, twist, forces,
    drive, state, inertia, maps, numbers, command, volts, given, wants_dry, first, h, q, w, base, dry, log,
):  # fmt: skip
    """Take as many steps as there are volts, from time first·h on.

    The first eleven arguments are those of `realitygap_engines.engine.Native`; `drive`, `state`, `inertia`, `maps` and
    `numbers` are as in `drive_effort` and `add_mapped`. Rows that are given or written: `command` (t + 1, n), `volts`
    (t,), further efforts `given` (t, n), `log` (t, n), and from the state on from which they start `q`, `w`, `dry` (t +
    1, n), which stays as it is unless it is wanted, and `base` (t + 1, 13), which gets pose and velocity as the engine
    has them.
    """
    step, copy = functions
    p, v = pose.size, pose.size + twist.size
    for k in range(volts.size):
        now, upcoming, t = command[k], command[k + 1], (first + k) * h
        drive_effort(
            drive, state, now, upcoming, q[k], w[k], dry[k], inertia, volts[k], t, h, effort, damping, friction, log[k]
        )
        if maps.size:
            add_mapped(maps, numbers, drive, state, now, w[k], inertia, volts[k], t, h, effort, damping, log[k])
        for j in range(effort.size):
            effort[j] += given[k, j]
        step(model, data)
        q[k + 1] = position
        w[k + 1] = velocity
        base[k + 1, :p] = pose
        base[k + 1, p:v] = twist
        if wants_dry:
            rubbing = 0
            for j in range(friction.size):
                rubbing += friction[j] > 0.0
            copy(dry[k + 1].ctypes.data, forces[0], rubbing)
            for j in range(friction.size - 1, -1, -1):  # from the end, as joints without friction lie between
                rubbing -= friction[j] > 0.0
                dry[k + 1, j] = dry[k + 1, rubbing] if friction[j] > 0.0 else 0.0
