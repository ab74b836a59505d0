"""How a command becomes duty or torque."""

import numpy as np

from realitygap.robot.drive import PID
from realitygap.robot.effects.effect import Effect, Page, Parameter, Values, reads, writes
from realitygap.robot.effects.joint import answers_rate, has_pid, has_servo
from realitygap.robot.plant import Plant


def _own_delay(plant: Plant, index: int) -> dict[str, float]:
    return {"time": float(plant.delay[index])}


def _delay(plant: Plant, indices: list[int], values: Values) -> None:
    plant.delay[indices] = values["time"]


COMMAND_DELAY = Effect(
    name="command_delay",
    changes="command",
    sits_at="joint",
    parameters=(Parameter("time", "s", 0.0, 0.5, 0.01, absent=0.0),),
    signals=("position", "velocity"),
    own=_own_delay,
    apply=_delay,
    possible=has_servo,
    page=Page(
        physics="Time between the recorded command and the duty that answers it: bus, drivers, filters and the "
        "servo's own loop. It is continuous: a part of a step delays by a part of a step.",
        equation="the servo follows command(t − time)",
        signature="The whole response is shifted in time, whatever the speed and the load.",
        confused_with="viscous_friction and controller_gain (a lag that ends in a sag, and depends on the load), "
        "rotor_inertia (lag only where it accelerates), clocks that are not aligned.",
        source="Dynamixel e-manual, return delay time and communication; Flemming 2019, chapter 4.",
    ),
    unseen_when_followed="no command is followed",
)


def _field(plant: Plant, index: int) -> str:
    return "kp" if plant.drive["kind"][index] == PID else "gain"


def _own_gain(plant: Plant, index: int) -> dict[str, float]:
    return {"gain": float(plant.drive[_field(plant, index)][index])}


def _gain(plant: Plant, indices: list[int], values: Values) -> None:
    pid = plant.drive["kind"] == PID
    chosen = np.isin(np.arange(len(pid)), indices)
    plant.drive["kp"][chosen & pid] = values["gain"]
    plant.drive["gain"][chosen & ~pid] = values["gain"]


def _softer(plant: Plant, index: int) -> dict[str, float]:
    return {"gain": 0.8 * _own_gain(plant, index)["gain"]}


CONTROLLER_GAIN = Effect(
    name="controller_gain",
    changes="torque",
    sits_at="joint",
    law="drive",
    parameters=(Parameter("gain", "duty/rad or N·m/rad", 1e-4, 1e6, 5.0, logarithmic=True),),
    signals=("position", "effort"),
    own=_own_gain,
    apply=_gain,
    possible=has_servo,
    scaled=_softer,
    page=Page(
        physics="The servo's answer to a position error: firmware units are easily misread, and a robot may run with "
        "other gains than its notes say. The unit follows the servo: `gain` in duty/rad of a dc servo, `kp` in "
        "N·m/rad of a pid servo, and the drive's `gain` of a cascade, which scales both of its loops, of a velocity "
        "servo in N·m·s/rad, and of an effort servo, which has no unit.",
        equation="dc: duty = gain·(command − q); pid: τ = gain·(command − q) + …; velocity: τ = gain·(command − ω); "
        "effort: τ = gain·command",
        signature="Sag under load and lag in motion in proportion to 1/gain, with the same effort at rest.",
        confused_with="supply_voltage (the same until the duty is at its limit), torque_constant, "
        "load_dependent_friction.",
        source="Dynamixel e-manual, position control: duty = P/128·error/885 per encoder unit.",
    ),
    unseen_when_followed="no servo answers a command",
)


def _damped(plant: Plant, index: int) -> dict[str, float]:
    """What a lead of 5 ms is of the servo's `kp`, as of one that nobody tuned."""
    return {"gain": float(plant.drive["kd"][index] + 0.005 * plant.drive["kp"][index])}


DERIVATIVE_GAIN = Effect(
    name="derivative_gain",
    changes="torque",
    sits_at="joint",
    law="drive",
    parameters=(Parameter("gain", "N·m·s/rad", 0.0, 1e6, 0.1),),
    signals=("velocity", "effort"),
    own=reads(gain="kd"),
    apply=writes(gain="kd"),
    possible=has_pid,
    scaled=_damped,
    page=Page(
        physics="A pid servo's answer to the rate of the position error. It is rarely written down, and a scenario "
        "that was begun from a URDF holds a guess.",
        equation="τ = … + gain·d/dt (command − q)",
        signature="Ringing and overshoot where it is too low; in effort a kick where the command changes its speed. "
        "Nothing at rest, and little where the joint follows.",
        confused_with="viscous_friction (drags in steady motion, too), rotor_inertia (slower to ring as well), "
        "controller_gain (sags at rest).",
        source="Åström & Hägglund, PID Controllers, 1995, chapter 3.",
    ),
    unseen_when_followed="no servo answers a command",
)

DERIVATIVE_LAG = Effect(
    name="derivative_lag",
    changes="torque",
    sits_at="joint",
    parameters=(Parameter("time", "s", 0.0, 0.2, 0.005, absent=0.0),),
    signals=("position", "effort"),
    own=reads(time="derivative_lag"),
    apply=writes(time="derivative_lag"),
    possible=answers_rate,
    page=Page(
        physics="A servo takes its speed from encoder readings: a difference over two samples is late by one of them, "
        "and the low-pass that calms it by its own time. What a cascade, a velocity or a pid servo answers to a speed "
        "comes that much late.",
        equation="time·dv/dt + v = ω, and the controller answers v; of a pid servo the whole rate of its error",
        signature="Stiff joints lose damping and ring. Where it accelerates, a joint seems lighter, by time times what "
        "the servo answers to a speed: 1 ms of a linear drive that answers 8560 N·s/m is a mass of 8.6 kg. Nothing at "
        "rest or at constant speed.",
        confused_with="rotor_inertia and link_mass (as heavy for a disturbance as for a command), current_lag (the "
        "answer to a position is late, too), derivative_gain, command_delay, velocity_filter (of what is reported).",
        source="Åström & Hägglund, PID Controllers, 1995, chapter 3.3, filtering of the derivative; Belanger et al., "
        "Estimation of angular velocity and acceleration from shaft-encoder measurements, 1998.",
    ),
    unseen_when_followed="no servo answers a speed",
)
