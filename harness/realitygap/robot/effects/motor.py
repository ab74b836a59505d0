"""The motor and its supply."""

import math

from realitygap.robot.effects.effect import Effect, Page, Parameter, Values, reads, writes
from realitygap.robot.effects.joint import (
    SUPPLY,
    anywhere,
    effort_scale,
    has_dc_motor,
    has_servo,
    has_torque_constant,
    seen_periods,
    speed_scale,
    wave_turned,
    wave_unseen,
)
from realitygap.robot.plant import Plant


def _weaker_motor(plant: Plant, index: int) -> dict[str, float]:
    return {"torque_constant": 0.85 * float(plant.drive["torque_constant"][index])}


TORQUE_CONSTANT = Effect(
    name="torque_constant",
    changes="torque",
    sits_at="joint",
    law="drive",
    parameters=(Parameter("torque_constant", "N·m/A", 1e-3, 1000.0, 1.0, logarithmic=True),),
    signals=("effort", "position", "velocity"),
    own=reads(torque_constant="torque_constant"),
    apply=writes(torque_constant="torque_constant"),
    possible=has_torque_constant,
    scaled=_weaker_motor,
    page=Page(
        physics="What a motor gives per ampere, times the gear ratio; the same constant makes the voltage that it "
        "induces per rad/s (back-EMF). Magnets scatter by some per cent and gear ratios are misread.",
        equation="τ = torque_constant/resistance·(volts − torque_constant·ω)",
        signature="Torque at rest and at speed change in opposite directions: a smaller constant is weaker at rest "
        "and has a higher top speed.",
        confused_with="supply_voltage and controller_gain (the same at rest, no back-EMF), viscous_friction (at "
        "speed), motor_heating (comes with time).",
        source="Hughes, Drury: Electric Motors and Drives, chapter 3; Flemming 2019, tables 4.4 to 4.6.",
    ),
)


def _own_line(plant: Plant, index: int) -> dict[str, float]:
    d = plant.drive[index]
    return {name: float(d[name]) if math.isfinite(d[name]) else 0.0 for name in ("stall_torque", "no_load_speed")}


def _line(plant: Plant, indices: list[int], values: Values) -> None:
    for name in ("stall_torque", "no_load_speed"):
        plant.drive[name][indices] = values[name] or math.inf


def _low_line(plant: Plant, index: int) -> dict[str, float]:
    return {"stall_torque": 0.4 * effort_scale(plant, index), "no_load_speed": 0.8 * speed_scale(plant, index)}


TORQUE_SPEED_LIMIT = Effect(
    name="torque_speed_limit",
    changes="torque",
    sits_at="joint",
    law="drive",
    parameters=(
        Parameter("stall_torque", "N·m", 1e-3, 1000.0, 5.0, absent=0.0, logarithmic=True),
        Parameter("no_load_speed", "rad/s", 1e-3, 1000.0, 6.0, absent=0.0, logarithmic=True),
    ),
    signals=("effort", "position", "velocity"),
    own=_own_line,
    apply=_line,
    possible=has_servo,
    scaled=_low_line,
    page=Page(
        physics="The torque that a motor can give falls with speed, from the stall torque to zero at the speed "
        "without load, because the induced voltage uses up the supply; against the motion it can give more. Both ends "
        "grow with the voltage. 0 stands for no limit.",
        equation="|τ| ≤ stall_torque·(1 − ω·sign τ/no_load_speed), not below 0",
        signature="Fast moves are clipped: velocity reaches a ceiling and the position falls behind, while slow moves "
        "are as before.",
        confused_with="supply_voltage and voltage_sag (a dc servo's line), viscous_friction (lags at every speed).",
        source="Dynamixel e-manual, performance graphs; Flemming 2019, tables 4.4 to 4.6.",
    ),
    unseen_when_followed="the effort is what the motion takes, not what a servo can give",
)


def _own_supply(plant: Plant, index: int) -> dict[str, float]:
    return {"supply": float(plant.drive["supply"][index])}


def _supply(plant: Plant, indices: list[int], values: Values) -> None:
    plant.drive["supply"][indices] = values["supply"]


def _has_stated_supply(plant: Plant, index: int) -> str | None:
    if plant.drive[index]["kind"] and plant.drive[index]["recorded_supply"]:
        name = plant.model.joint_names[index]
        return f"the supply of joint {name} was recorded; expected a servo whose `supply` is a number"
    return has_dc_motor(plant, index)


def _lower_supply(plant: Plant, index: int) -> dict[str, float]:
    return {"supply": 0.85 * float(plant.drive["supply"][index])}


SUPPLY_VOLTAGE = Effect(
    name="supply_voltage",
    changes="torque",
    sits_at="joint",
    law="drive",
    parameters=(Parameter("supply", "V", 0.5, 500.0, SUPPLY, logarithmic=True),),
    signals=("effort", "position", "velocity"),
    own=_own_supply,
    apply=_supply,
    possible=_has_stated_supply,
    scaled=_lower_supply,
    page=Page(
        physics="A servo sets a duty, a part of its supply: batteries are rarely at their nominal voltage, and a "
        "servo at less voltage is softer, weaker and slower.",
        equation="volts = duty·supply; stall torque and no-load speed grow in proportion to it",
        signature="More sag and lag everywhere, and a lower top speed.",
        confused_with="controller_gain (the same until the duty is at its limit), torque_constant, voltage_sag (only "
        "while much current is drawn).",
        source="Dynamixel e-manual, PWM and present input voltage; Flemming 2019, tables 4.4 to 4.6.",
    ),
    unseen_when_followed="no voltage drives the motion",
)


def _sag(plant: Plant, indices: list[int], values: Values) -> None:
    plant.drive["sag_resistance"][indices] = values["resistance"]
    plant.drive["sag_group"][indices] = min(indices)


def _weak_supply(plant: Plant, index: int) -> dict[str, float]:
    return {"resistance": 0.15 * float(plant.drive["resistance"][index])}


VOLTAGE_SAG = Effect(
    name="voltage_sag",
    changes="torque",
    sits_at="joint",
    law="drive",
    parameters=(Parameter("resistance", "Ω", 0.0, 50.0, 0.2, absent=0.0),),
    signals=("effort", "position", "velocity"),
    own=reads(resistance="sag_resistance"),
    apply=_sag,
    possible=has_dc_motor,
    scaled=_weak_supply,
    page=Page(
        physics="Batteries, cables and connectors have a resistance: the more current the servos draw together, the "
        "less voltage is left for each. Servos that one target names share one supply, if they have the same voltage. "
        "What a servo draws from the bus is its power, and one that brakes feeds back and lifts the voltage. On a "
        "recorded supply it is a resistance behind the point of measurement.",
        equation="bus = supply − resistance·Σ volts·current/bus, volts = duty·bus",
        signature="Joints lose speed and torque while others work hard; single joints alone are as before.",
        confused_with="supply_voltage (always), torque_speed_limit (each joint on its own), motor_heating (stays).",
        source="Erickson, Maksimović: Fundamentals of Power Electronics, chapter 3 (a chopper is a transformer); "
        "Linden's Handbook of Batteries, internal resistance.",
    ),
    unseen_when_followed="no voltage drives the motion",
)

MOTOR_HEATING = Effect(
    name="motor_heating",
    changes="torque",
    sits_at="joint",
    law="drive",
    parameters=(Parameter("loss", "1/s", 0.0, 0.5, 0.03, absent=0.0),),
    signals=("effort", "position", "velocity"),
    own=reads(loss="heating"),
    apply=writes(loss="heating"),
    possible=has_torque_constant,
    page=Page(
        physics="Windings that warm up have more resistance and magnets less field: the same duty gives less torque "
        "as time goes on. A linear fall is the beginning of the exponential one.",
        equation="torque_constant(t) = torque_constant·(1 − loss·t), not below 0",
        signature="Sag and lag grow from repetition to repetition of the same motion.",
        confused_with="torque_constant or supply_voltage (from the start), voltage_sag (recovers at once).",
        source="Hughes, Drury: Electric Motors and Drives, chapter 3; Dynamixel e-manual, present temperature.",
    ),
)


def _visible_saturation(plant: Plant, index: int) -> dict[str, float]:
    return {"saturation": 0.15 / effort_scale(plant, index)}


MOTOR_SATURATION = Effect(
    name="motor_saturation",
    changes="torque",
    sits_at="joint",
    law="drive",
    parameters=(Parameter("saturation", "1/(N·m)", 0.0, 1000.0, 0.1, absent=0.0),),
    signals=("effort", "position", "velocity"),
    own=reads(saturation="saturation"),
    apply=writes(saturation="saturation"),
    possible=has_servo,
    scaled=_visible_saturation,
    everywhere=True,
    page=Page(
        physics="A motor gives less torque per ampere the more current it has: its iron saturates, and what the gears "
        "lose grows with the load that drives them. Of a torque constant that is 4 % smaller at 2 N·m the saturation "
        "is 0.02 1/(N·m).",
        equation="τ = asked/(1 + saturation·|asked|), of what the current gives where nothing saturates",
        signature="Large loads sag more than in proportion and fast starts lag, while small and slow moves are as "
        "before.",
        confused_with="voltage_sag (falls with power, not with torque), torque_constant (at every load alike), "
        "torque_speed_limit and effort_limit (a ceiling), link_mass (against gravity).",
        source="Fröhlich 1881: magnetisation = current/(a + b·current), in Fitzgerald, Kingsley, Umans: Electric "
        "Machinery, chapter 1; Hollerbach, Hunter, Ballantyne: A comparative analysis of actuator technologies, 1992.",
    ),
    unseen_when_followed="the effort is what the motion takes, not what a servo gives",
)


def _visible_ripple(plant: Plant, index: int) -> dict[str, float]:
    return {"amplitude": 0.02 * effort_scale(plant, index), "periods": seen_periods(plant, index, 20.0)}


TORQUE_RIPPLE = Effect(
    name="torque_ripple",
    changes="torque",
    sits_at="joint",
    law="drive",
    parameters=(
        Parameter("amplitude", "N·m", 0.0, 200.0, 0.1, absent=0.0),
        Parameter("periods", "per 2π", 0.5, 2000.0, 20.0, shape=True),
        Parameter("phase", "rad", -2 * math.pi, 2 * math.pi, 0.0, default=0.0, shape=True, typical=1.0),
    ),
    signals=("position", "velocity"),
    own=reads(amplitude="ripple", periods="ripple_periods", phase="ripple_phase"),
    apply=writes(amplitude="ripple", periods="ripple_periods", phase="ripple_phase"),
    turned=wave_turned,
    absurd=wave_unseen,
    possible=anywhere,
    scaled=_visible_ripple,
    page=Page(
        physics="Magnets that prefer some angles (cogging) and gear teeth give a torque that depends on the angle and "
        "repeats over a turn. It is a potential: it holds the joint near its valleys. It acts on the rotor: where "
        "backlash or a spring lies behind it, the angle is the rotor's.",
        equation="τ += −amplitude·sin(periods·q + phase), on the rotor and with its angle as seen at the joint "
        "[rad, of a slide m]",
        signature="Jerks at fixed angles, in both directions of motion; a frequency in the velocity that is "
        "proportional to speed.",
        confused_with="stribeck_friction (jerks at any angle), joint_compliance (one frequency whatever the speed).",
        source="Holtz, Springob: Identification and compensation of torque ripple, IEEE Trans. Ind. Electron. 43(2), "
        "1996.",
    ),
)


def _visible_push(plant: Plant, index: int) -> dict[str, float]:
    return {"effort": 0.03 * effort_scale(plant, index)}


CONSTANT_EFFORT = Effect(
    name="constant_effort",
    changes="torque",
    sits_at="joint",
    law="load",
    parameters=(Parameter("effort", "N·m", -1000.0, 1000.0, 0.1, absent=0.0),),
    signals=("position",),
    own=reads(effort="constant"),
    apply=writes(effort="constant"),
    possible=anywhere,
    scaled=_visible_push,
    page=Page(
        physics="A torque that is always there: the bias of a current sensor or amplifier, a preloaded spring, a "
        "cable.",
        equation="τ += effort",
        signature="An offset of position and effort that is the same in every pose and in both directions.",
        confused_with="joint_offset (an offset of position without effort), center_of_mass and base_tilt (depend on "
        "the pose), coulomb_friction (changes its sign with the direction).",
        source="Janot, Gautier, Brunot: Data set and reference models of EMPS, 2019 (offset force).",
    ),
)
