"""The effects: physics that a model may lack. Adding one is one definition and one line in `EFFECTS`."""

from realitygap.robot.effects.body import BASE_TILT, CENTER_OF_MASS, LINK_INERTIA, LINK_MASS
from realitygap.robot.effects.control import COMMAND_DELAY, CONTROLLER_GAIN, DERIVATIVE_GAIN, DERIVATIVE_LAG
from realitygap.robot.effects.effect import Effect, Page, Parameter, Values
from realitygap.robot.effects.effort_map import EFFORT_MAP
from realitygap.robot.effects.firmware import COMMAND_PROFILE, DEAD_BAND, GAIN_LAW, SERVO_RATE
from realitygap.robot.effects.friction import (
    COULOMB_FRICTION,
    LOAD_DEPENDENT_FRICTION,
    STRIBECK_FRICTION,
    VISCOUS_FRICTION,
)
from realitygap.robot.effects.friction_shape import DIRECTION_FRICTION, FRICTION_RIPPLE
from realitygap.robot.effects.ground import GROUND_FRICTION, SOFT_GROUND
from realitygap.robot.effects.motor import (
    CONSTANT_EFFORT,
    MOTOR_HEATING,
    MOTOR_SATURATION,
    SUPPLY_VOLTAGE,
    TORQUE_CONSTANT,
    TORQUE_RIPPLE,
    TORQUE_SPEED_LIMIT,
    VOLTAGE_SAG,
)
from realitygap.robot.effects.payload import PAYLOAD
from realitygap.robot.effects.power_stage import CURRENT_LAG, EFFORT_LIMIT, MOTOR_BRAKING
from realitygap.robot.effects.sensor import EFFORT_HYSTERESIS, JOINT_OFFSET, VELOCITY_FILTER
from realitygap.robot.effects.springs import CABLE_SPRING, JOINT_STOP
from realitygap.robot.effects.transmission import BACKLASH, JOINT_COMPLIANCE, ROTOR_INERTIA

__all__ = ["EFFECTS", "EFFORT_MAP", "WRITABLE", "Effect", "Page", "Parameter", "Values"]

EFFECTS: dict[str, Effect] = {
    effect.name: effect
    for effect in (
        COULOMB_FRICTION,
        VISCOUS_FRICTION,
        STRIBECK_FRICTION,
        LOAD_DEPENDENT_FRICTION,
        BACKLASH,
        JOINT_COMPLIANCE,
        ROTOR_INERTIA,
        TORQUE_CONSTANT,
        TORQUE_SPEED_LIMIT,
        SUPPLY_VOLTAGE,
        VOLTAGE_SAG,
        COMMAND_DELAY,
        CONTROLLER_GAIN,
        JOINT_OFFSET,
        TORQUE_RIPPLE,
        MOTOR_HEATING,
        CONSTANT_EFFORT,
        LINK_MASS,
        CENTER_OF_MASS,
        LINK_INERTIA,
        BASE_TILT,
        GROUND_FRICTION,
        SOFT_GROUND,
        VELOCITY_FILTER,
        PAYLOAD,
        DEAD_BAND,
        JOINT_STOP,
        COMMAND_PROFILE,
        EFFORT_LIMIT,
        DIRECTION_FRICTION,
        FRICTION_RIPPLE,
        CABLE_SPRING,
        MOTOR_BRAKING,
        CURRENT_LAG,
        GAIN_LAW,
        SERVO_RATE,
        DERIVATIVE_GAIN,
        DERIVATIVE_LAG,
        MOTOR_SATURATION,
        EFFORT_HYSTERESIS,
    )
}
"""In the order in which the simpler of two explanations is preferred."""
WRITABLE: dict[str, Effect] = {**EFFECTS, EFFORT_MAP.name: EFFORT_MAP}
"""What a scenario can have: the effects, which have a law and a name to give, and an effort that has neither."""
