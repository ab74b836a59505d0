"""The voltage of every servo, after the drop that all on its supply cause together."""

import numpy as np
from realitygap_engines.law.compiled import compiled

from realitygap.robot.drive import DC, EFFORT
from realitygap.robot.law.controller import duty


@compiled
def sag(drive, state, command, t, log):  # type: ignore[no-untyped-def]
    """Lower `bus` of every state from the supply to what is left of it; arguments as in `drive_effort`.

    A servo is a lossless chopper: what it draws from the bus is volts·current/bus = duty·current, with volts = duty·bus
    and current = (volts - k·ω)/R. So bus = supply - R_s·Σ duty·current is linear in the bus:

        bus·(1 + R_s·Σ duty²/R) = supply + R_s·Σ duty·k·ω/R

    What a braking servo feeds back raises it, above the supply too.
    """
    for j in range(drive.size):
        d, supply = drive[j], state[j].bus
        if d.sag_resistance <= 0.0 or d.kind != DC or supply <= 0.0:
            continue
        first = j
        for i in range(j):
            if shared(drive[i], d):
                first = i
                break
        if first < j:
            state[j].bus = state[first].bus
            continue
        load, fed = 0.0, 0.0
        for i in range(j, drive.size):
            o = drive[i]
            if not shared(o, d) or o.meaning == EFFORT or np.isnan(command[i]):
                continue
            part = duty(o, state[i].error, command[i])
            load += part * part / o.resistance
            fed += part * o.torque_constant * max(1.0 - o.heating * t, 0.0) * log[i].rotor / o.resistance
        state[j].bus = max((supply + d.sag_resistance * fed) / (1.0 + d.sag_resistance * load), 0.0)


@compiled
def shared(a, b):  # type: ignore[no-untyped-def]
    """Whether two servos share a supply."""
    same = a.sag_group == b.sag_group and a.sag_resistance == b.sag_resistance and a.kind == DC
    return same and a.supply == b.supply and a.recorded_supply == b.recorded_supply
