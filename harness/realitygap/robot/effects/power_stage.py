"""What lies between the torque that a servo asks for and the torque that its motor gives."""

import math

from realitygap.robot.effects.effect import Effect, Page, Parameter, reads, writes
from realitygap.robot.effects.joint import effort_scale, has_dc_motor, has_servo
from realitygap.robot.plant import Plant

SOON = 0.2
"""A first guess of where protection begins, in the largest position error that was recorded: what begins beyond that
error does nothing. One that began at 0.29 rad was tried from 1 rad on, and a supply and a gain were named for it."""


def _low_limit(plant: Plant, index: int) -> dict[str, float]:
    lagged = 0.0 if plant.lagged is None else float(plant.lagged[index])
    beyond = {"beyond": SOON * lagged} if lagged > 0.0 else {}
    return {"effort": 0.1 * effort_scale(plant, index), **beyond}


EFFORT_LIMIT = Effect(
    name="effort_limit",
    changes="torque",
    sits_at="joint",
    law="drive",
    special_of=("torque_speed_limit",),
    parameters=(
        Parameter("effort", "N·m", 1e-4, 1e5, 2.0, absent=math.inf, default=math.inf, logarithmic=True),
        Parameter("beyond", "rad", 1e-3, 10.0, 1.0, absent=math.inf, default=math.inf, shape=True),
        Parameter("share", "", 0.0, 1.0, 0.25, absent=1.0, default=1.0, shape=True),
    ),
    signals=("position", "effort"),
    own=reads(effort="real_limit", beyond="protection", share="protection_share"),
    apply=writes(effort="real_limit", beyond="protection", share="protection_share"),
    possible=has_servo,
    scaled=_low_limit,
    page=Page(
        physics="The torque that a servo really gives at most: firmware limits the current, whatever the data sheet "
        "says. It acts beside the limits of the model, and the smaller one counts. Protection is something else that "
        "firmware does: beyond a position error (`beyond`) it gives a `share` of what it would. An STS3215 falls "
        "from a duty of 0.165·P·error to 0.04·P·error: a share of 0.24.",
        equation="|τ_m| ≤ effort; where |e| > beyond, the controller takes share·e for the error e",
        signature="The effort has a ceiling that does not depend on the speed; heavy loads sag, and fast starts are "
        "delayed. With protection, a joint that falls far behind becomes soft at once, and hard again when it has "
        "come near.",
        confused_with="torque_speed_limit (its ceiling falls with speed), controller_gain (softer at small errors "
        "too), gain_law (softer bit by bit), voltage_sag, command_profile.",
        source="Dynamixel e-manual, current limit; Feetech STS memory table: maximum and protective torque; "
        "kscalelabs/sysid: measured gain of an STS3215 against its position error.",
    ),
    unseen_when_followed="the effort is what the motion takes, not what a servo can give",
)

MOTOR_BRAKING = Effect(
    name="motor_braking",
    changes="torque",
    sits_at="joint",
    law="drive",
    parameters=(Parameter("share", "", 0.0, 1.0, 1.0),),
    signals=("position", "velocity"),
    own=reads(share="braking"),
    apply=writes(share="braking"),
    possible=has_dc_motor,
    page=Page(
        physics="What a servo does when it is switched off. Bridges that are left open let the motor coast (0); "
        "bridges that are all closed to ground short-circuit it (1), and the current that its own voltage drives "
        "brakes it. In between, it is shorted for a part of the time. It acts where a recording has no command, or "
        "torque_enabled is 0.",
        equation="off: τ = −share·torque_constant²/resistance·ω",
        signature="A joint that is let go falls slowly, at a speed in proportion to its load; nothing changes while "
        "the servo is on.",
        confused_with="viscous_friction (slows the joint while the servo is on, too), coulomb_friction (a limit "
        "below which nothing falls).",
        source="Hughes, Drury: Electric Motors and Drives, chapter 3, dynamic braking; data sheets of H-bridges such "
        "as TI DRV8871, coast and brake.",
    ),
    unseen_when_followed="no servo drives the motion, or lets go of it",
)

CURRENT_LAG = Effect(
    name="current_lag",
    changes="torque",
    sits_at="joint",
    parameters=(Parameter("time", "s", 0.0, 0.5, 0.01, absent=0.0),),
    signals=("position", "effort"),
    own=reads(time="lag"),
    apply=writes(time="lag"),
    possible=has_servo,
    page=Page(
        physics="A winding's inductance lets the current, and with it the torque, follow the voltage with a lag of "
        "inductance/resistance (0.1 to 2 ms in small motors); filters and current loops of the driver add to it. The "
        "torque of back-EMF lags alike. A simulation begins in the steady state; a servo that is switched off has no "
        "current left.",
        equation="time·dτ/dt + τ = torque_constant/resistance·(volts − torque_constant·ω), or what another servo "
        "asks for",
        signature="Torque comes late and smooth, also against a disturbance, so that stiff joints lose damping and "
        "ring; nothing at rest or in steady motion.",
        confused_with="command_delay (shifts the command alone, and takes no damping away), servo_rate (late by "
        "jumps), rotor_inertia (slow, but the effort is not late).",
        source="Hughes, Drury: Electric Motors and Drives, chapter 3, electrical time constant.",
    ),
    unseen_when_followed="the effort is what the motion takes, not what a servo asks for",
)
