"""What a servo's firmware makes of its command and its error."""

import math

from realitygap.robot.effects.effect import Effect, Page, Parameter, Values, reads, writes
from realitygap.robot.effects.joint import follows_position, speed_scale
from realitygap.robot.plant import Plant


def _own_band(plant: Plant, index: int) -> dict[str, float]:
    return {"width": 2.0 * float(plant.drive["dead_band"][index])}


def _band(plant: Plant, indices: list[int], values: Values) -> None:
    plant.drive["dead_band"][indices] = 0.5 * values["width"]


def _small_band(plant: Plant, index: int) -> dict[str, float]:
    return {"width": 1e-3 if plant.model.joints[index].prismatic else 0.02}


DEAD_BAND = Effect(
    name="dead_band",
    changes="torque",
    sits_at="joint",
    parameters=(Parameter("width", "rad", 0.0, 1.0, 0.02, absent=0.0),),
    signals=("position", "effort"),
    own=_own_band,
    apply=_band,
    possible=follows_position,
    scaled=_small_band,
    page=Page(
        physics="A controller that ignores small position errors, so that a servo at its goal does not hum: the "
        "compliance margin or dead zone of its firmware. Within the band it asks for nothing; outside, the error "
        "counts from the band's edge, so that the torque begins at zero there. The width is the whole of it, from "
        "one edge to the other.",
        equation="e = command − q; the controller takes sign(e)·max(|e| − width/2, 0)",
        signature="The joint stops short of its goal by up to half of the width, from either side, with no effort; "
        "under load it sags by so much more, whatever the gain.",
        confused_with="coulomb_friction (holds without effort too, but stops short by less the higher the gain), "
        "backlash (lets the link move, not the servo's reading), joint_offset (one side only), controller_gain.",
        source="Dynamixel e-manual, AX-12: compliance margin; Feetech STS memory table: clockwise and "
        "counter-clockwise insensitive zone.",
    ),
    unseen_when_followed="no servo answers a command",
)


def _slow_profile(plant: Plant, index: int) -> dict[str, float]:
    speed = 0.4 * speed_scale(plant, index)
    return {"speed": speed, "acceleration": speed / 0.02}


QUICKEST_PROFILE = 50.3
"""The largest speed a profile can be set to [rad/s]: 32767 steps of 4096 in a turn (Feetech STS, running speed); 2047
times 0.229 rev/min is as much (Dynamixel e-manual, XL330, velocity limit). What would need more is no profile: it acts
within a sample."""
FASTEST_PROFILE = 1.23e4
"""The largest acceleration a profile can be set to: 32767 times 214.577 rev/min², in rad/s² (Dynamixel e-manual, X
series, profile acceleration); a Feetech STS reaches 254 times 100 steps/s², which is less. What would need more is no
profile: it acts within a sample."""

COMMAND_PROFILE = Effect(
    name="command_profile",
    changes="command",
    sits_at="joint",
    parameters=(
        Parameter("speed", "rad/s", 1e-3, QUICKEST_PROFILE, 3.0, absent=math.inf, default=math.inf, logarithmic=True),
        Parameter(
            "acceleration", "rad/s²", 1e-2, FASTEST_PROFILE, 150.0, absent=math.inf, default=math.inf, logarithmic=True
        ),
    ),
    signals=("position", "velocity"),
    own=reads(speed="profile_speed", acceleration="profile_acceleration"),
    apply=writes(speed="profile_speed", acceleration="profile_acceleration"),
    possible=follows_position,
    scaled=_slow_profile,
    page=Page(
        physics="Firmware does not hand a goal to its controller at once: a profile moves to it with a bounded speed "
        "and acceleration, so as to come to rest there, and every new goal is a new plan from where the profile is. "
        "The profile begins at the first command, and at the next command where a servo was off. A bound that is "
        "left out is not there. It happens before the command's delay.",
        equation="the servo follows p(t): |dp/dt| ≤ speed, |d²p/dt²| ≤ acceleration, as fast as both allow to the "
        "last command",
        signature="After a jump of the command the position climbs a straight line of the same slope whatever the "
        "gain and the load; slow motions are as before. With a bound of the acceleration both ends of the line are "
        "rounded.",
        confused_with="torque_speed_limit (its ceiling falls with load and voltage), command_delay (shifts slow "
        "motions too), effort_limit and rotor_inertia (slow the start, not the way).",
        source="Dynamixel e-manual, X series: profile velocity and profile acceleration (trapezoidal profile); "
        "Feetech STS memory table: running speed and acceleration.",
    ),
    unseen_when_followed="no command is followed",
)

GAIN_LAW = Effect(
    name="gain_law",
    changes="torque",
    sits_at="joint",
    law="drive",
    parameters=(Parameter("exponent", "", 0.2, 3.0, 0.8, absent=1.0),),
    signals=("position", "effort"),
    own=reads(exponent="gain_exponent"),
    apply=writes(exponent="gain_exponent"),
    possible=follows_position,
    page=Page(
        physics="A gain that changes with the error: firmware that answers large errors with less than in proportion "
        "(an exponent below 1), or small ones (above 1), and drivers that are not linear. The servo's gain is that "
        "at an error of 0.1 rad (0.1 m), amid the errors of servos in motion.",
        equation="the controller takes 0.1·(|e|/0.1)^exponent·sign(e) for the error e = command − q",
        signature="Lag and sag that do not grow in proportion to speed and load: with an exponent below 1 small "
        "errors are held firmly and large ones softly.",
        confused_with="controller_gain (in proportion at every error), dead_band (soft below an edge only), "
        "effort_limit (soft beyond an edge only), coulomb_friction (holds small errors).",
        source="kscalelabs/sysid: measured gain of a Feetech STS3215 against its position error; Shinskey: Process "
        "Control Systems, 1996, nonlinear controllers.",
    ),
    unseen_when_followed="no servo answers a command",
)

SERVO_RATE = Effect(
    name="servo_rate",
    changes="torque",
    sits_at="joint",
    parameters=(Parameter("rate", "Hz", 1.0, 1e4, 50.0, absent=math.inf, logarithmic=True),),
    signals=("position", "velocity"),
    own=reads(rate="servo_rate"),
    apply=writes(rate="servo_rate"),
    possible=follows_position,
    page=Page(
        physics="A servo looks at its position error so many times a second and holds it in between: its answer is "
        "half a period late in the mean. Damping by the velocity and back-EMF stay continuous. The first sample is "
        "at the start of the simulation. A rate above the step rate does nothing.",
        equation="the controller takes e(t_k) for t_k ≤ t < t_k + 1/rate, t_k = k/rate",
        signature="A lag of half a period in what the servo does about an error, which takes damping away: fast, "
        "stiff joints overshoot and ring.",
        confused_with="command_delay (late for the command alone, which takes no damping away), current_lag "
        "(smooth), joint_compliance and backlash (rattle too, whatever the gain).",
        source="Franklin, Powell, Workman: Digital Control of Dynamic Systems, 1998, sample and hold; XYZrobot A1-16 "
        "data sheet: a position loop with a period of 10 ms.",
    ),
    unseen_when_followed="no servo answers a command",
)
