"""What the drive of a joint is made of: one record per joint holds every parameter of servo, friction and transmission.

An effect is an edit of these numbers; the law itself is in `robot.drive_law`. Units: rad, N·m (m, N for prismatic
joints), V, Ω, A, s.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NONE, DC, PID, CASCADE, TORQUE, SPEED = 0, 1, 2, 3, 4, 5
POSITION, DUTY, EFFORT, VELOCITY = 0, 1, 2, 3
MEANINGS = {"position": POSITION, "duty": DUTY, "effort": EFFORT, "velocity": VELOCITY}

DRIVE = np.dtype(
    [
        ("kind", np.int64),
        ("meaning", np.int64),  # of the command: position, duty or effort
        ("gain", np.float64),
        ("duty_limit", np.float64),
        ("supply", np.float64),
        ("recorded_supply", np.int64),  # 1: the recorded voltage is used instead of `supply`
        ("torque_constant", np.float64),
        ("resistance", np.float64),
        ("current_factor", np.float64),  # N·m per ampere with which a current was told as an effort; 0: it was not
        ("kp", np.float64),
        ("ki", np.float64),
        ("kd", np.float64),
        ("kv", np.float64),
        ("effort_limit", np.float64),
        ("velocity_limit", np.float64),
        ("stall_torque", np.float64),
        ("no_load_speed", np.float64),
        ("sag_resistance", np.float64),
        ("sag_group", np.int64),  # servos of one group, with the same supply, share it
        ("heating", np.float64),
        ("saturation", np.float64),  # share of a small torque that is lost, per N·m of it
        ("offset", np.float64),
        ("dead_band", np.float64),  # of the position error: half width
        ("servo_rate", np.float64),  # at which the position error is sampled and held [Hz]; infinite: continuously
        ("gain_exponent", np.float64),  # of the position error; 1: a gain that does not change with it
        ("derivative_lag", np.float64),  # of the encoder's rate as the controller has it
        ("protection", np.float64),  # position error beyond which the servo cuts it to a share
        ("protection_share", np.float64),
        ("profile_speed", np.float64),  # at which a position command is followed at most; infinite: at once
        ("profile_acceleration", np.float64),
        ("real_limit", np.float64),  # of the motor's torque, beside `effort_limit`
        ("lag", np.float64),  # of the torque behind what the controller and the speed ask for
        ("braking", np.float64),  # share of a short circuit while the servo is off
        ("armature", np.float64),
        ("coulomb", np.float64),
        ("static", np.float64),
        ("onset", np.float64),  # speed over which dry friction grows from rest; 0: it is all there at once
        ("presliding", np.float64),  # angle over which dry friction builds up; 0: it is all there at once
        ("stribeck_velocity", np.float64),
        ("stribeck_exponent", np.float64),
        ("load", np.float64),
        ("load_static", np.float64),
        ("load_velocity", np.float64),
        ("load_exponent", np.float64),
        ("lean", np.float64),  # half of how much more dry friction there is backward than forward
        ("friction_ripple", np.float64),  # share by which dry friction changes with the angle
        ("friction_periods", np.float64),
        ("friction_phase", np.float64),
        ("viscous", np.float64),
        ("viscous_asymmetry", np.float64),  # share by which it is more forward, and less backward
        ("ripple", np.float64),
        ("ripple_periods", np.float64),
        ("ripple_phase", np.float64),
        ("constant", np.float64),
        ("backlash", np.float64),  # full width; 0: none
        ("stiffness", np.float64),  # of the spring between encoder and link; 0: rigid
        ("give_damping", np.float64),  # between rotor and link, in that spring or in the backlash
        ("cable_stiffness", np.float64),
        ("cable_rest", np.float64),
        ("stop_lower", np.float64),
        ("stop_upper", np.float64),
        ("stop_stiffness", np.float64),
        ("hysteresis", np.float64),  # of the effort's reading: half of what it differs by between both ways
        ("hysteresis_onset", np.float64),  # speed over which that grows from rest
    ]
)
"""The parameters of one joint's drive."""

DIRECTION_KNOWN = 0.05
"""Speed above which a drive knows the direction of its motion [rad/s or m/s]: what is likeliest on an MX-106, whose
encoder tells 1.5 mrad."""

STATE = np.dtype(
    [
        ("begun", np.int64),  # 1 in the first step, 2 after it
        ("started", np.int64),  # whether the servo was on in the previous step
        ("error", np.float64),  # of the position, as the controller takes it
        ("held", np.float64),  # the last sample of the position error
        ("integral", np.float64),
        ("slope", np.float64),  # rate of the position error as a lag has it, at the beginning of the step
        ("rising", np.float64),  # rate of the command over the previous step, where the controller takes it
        ("rate", np.float64),  # of the encoder, at the beginning of the previous step
        ("current", np.float64),  # the motor's torque as a lag has it, at the beginning of the step
        ("aim", np.float64),  # what it follows is aim - aim_back·speed
        ("aim_back", np.float64),
        ("aim_speed", np.float64),
        ("goal", np.float64),  # the previous command
        ("bus", np.float64),  # supply voltage after sag
        ("heading", np.float64),  # sign of the last speed that was one, and when that changed: for effort maps
        ("reversed", np.float64),
        ("bent", np.float64),  # share of dry friction that has built up, with its sign
        ("mapped", np.float64),  # effort of all maps over the previous step
        ("velocity", np.float64),  # of the link, at the previous step
        ("effort", np.float64),  # of the joint law over the previous step, without the constant effort
        ("damping", np.float64),
        ("driven", np.float64),  # torque on the rotor, without friction, at the previous step
        ("transmitted", np.float64),  # torque from the rotor to the link over the previous step
        ("rotor", np.float64),  # angle and speed, at the output, where the rotor is not rigid to the link
        ("rotor_velocity", np.float64),
        ("side", np.int64),  # -1, 1: the rotor is at that end of its backlash
        ("closing", np.float64),  # the speed, relative to the link, at which it lands there
        ("momentum", np.float64),  # what the rotor would have after the step without friction and link
        ("mass", np.float64),  # its inertia and implicit damping
        ("bound", np.float64),  # of its dry friction
    ]
)
"""What the drive of one joint remembers from step to step."""

LOG = np.dtype(
    [
        ("motor", np.float64),  # the motor's effort over the step is motor - emf·ω, with ω the rotor's mean velocity
        ("emf", np.float64),
        ("lean", np.float64),  # beside what is dry, friction over the step is lean - drag·ω
        ("drag", np.float64),
        ("encoder", np.float64),  # true angle of the encoder's shaft
        ("rotor", np.float64),  # speed of the rotor, at the output
        ("transmitted", np.float64),  # torque from the rotor to the link over the step before
    ]
)
"""What is worth recording of one joint on every step."""


def neutral_drive(n: int) -> NDArray[np.void]:
    """Drives without servo and without friction. Shape (n,) of `DRIVE`."""
    drive = np.zeros(n, DRIVE)
    drive["stop_lower"] = -np.inf
    for name in ("effort_limit", "velocity_limit", "stall_torque", "no_load_speed", "real_limit", "stop_upper"):
        drive[name] = np.inf
    for name in ("servo_rate", "protection", "profile_speed", "profile_acceleration"):
        drive[name] = np.inf
    for name in ("duty_limit", "resistance", "gain_exponent", "protection_share"):
        drive[name] = 1.0
    for name in ("stribeck_velocity", "load_velocity", "ripple_periods", "friction_periods"):
        drive[name] = 1.0
    for name in ("stribeck_exponent", "load_exponent"):
        drive[name] = 2.0
    drive["hysteresis_onset"] = DIRECTION_KNOWN
    return drive
