"""The servos of a scenario: what turns a command into a torque, by kind."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from realitygap.scenario.section import Finite, Fraction, NotNegative, Patterns, Positive, Section

Volts = Annotated[Finite, Field(gt=0, le=1000)]
"""No joint's bus has more: a larger number is in mV."""


class Friction(Section):
    """Joint friction; given with a servo, it replaces the URDF's `<dynamics>`."""

    coulomb: NotNegative = Field(default=0.0, description="dry friction [N·m or N]")
    viscous: NotNegative = Field(default=0.0, description="viscous friction [N·m·s/rad or N·s/m]")


class RecordedSupply(Section):
    """A supply voltage that was recorded."""

    recorded: str = Field(description="the topic (BatteryState) or column of the supply voltage")


class Servo(Section):
    """What all servos have."""

    name: str | None = Field(default=None, description="addresses this servo in `with: {servos.NAME.gain: 2.5}`")
    joints: Patterns = Field(description="patterns over joint names; the first servo that matches wins")
    armature: NotNegative = Field(
        default=0.0, description="rotor inertia at the output shaft [kg·m² or kg] (default: what the robot's file says)"
    )
    friction: Friction | None = Field(default=None, description="replaces the URDF's `<dynamics>`")


class DcServo(Servo):
    """A position-controlled DC motor: duty = gain·(command − q), volts = duty·supply, back-EMF."""

    kind: Literal["dc"] = Field(description="this kind of servo")
    gain: NotNegative = Field(description="duty per position error [1/rad]")
    duty_limit: Fraction = Field(default=1.0, description="largest duty, either way")
    supply: Volts | RecordedSupply = Field(description="supply voltage [V]")
    torque_constant: Positive = Field(
        description="torque per current at the output shaft [N·m/A]; also volts per speed [V·s/rad]"
    )
    resistance: Positive = Field(description="resistance of the winding [Ω]")


class PidServo(Servo):
    """torque = kp·e + ki·∫e + kd·de/dt, within the URDF's effort and velocity limits.

    At the effort limit the integral stands still; over the last 5 % of the velocity limit, torque that drives on falls
    to zero. A held command that jumps gives an impulse of kd times the jump, half of it in the step that ends with the
    jump and half in the one that begins with it (the rate is a central difference).
    """

    kind: Literal["pid"] = Field(description="this kind of servo")
    kp: NotNegative = Field(description="torque per error [N·m/rad]")
    ki: NotNegative = Field(default=0.0, description="torque per error and time [N·m/(rad·s)]")
    kd: NotNegative = Field(default=0.0, description="torque per rate of the error [N·m·s/rad]")


class CascadeServo(Servo):
    """force = gain·(kv·(kp·(command − q) − q̇)), within the URDF's effort limit."""

    kind: Literal["cascade"] = Field(description="this kind of servo")
    gain: NotNegative = Field(description="effort per output of the velocity loop [N·m or N]")
    kv: NotNegative = Field(description="gain of the velocity loop [s/rad or s/m]")
    kp: NotNegative = Field(description="gain of the position loop [1/s]")


class EffortServo(Servo):
    """effort = gain·command, within the URDF's effort limit; the commands are efforts (`motion: {as: effort}`)."""

    kind: Literal["effort"] = Field(description="this kind of servo")
    gain: Positive = Field(default=1.0, description="effort per commanded effort")


class VelocityServo(Servo):
    """effort = gain·(command − q̇), within the URDF's effort limit; the commands are velocities (`as: velocity`)."""

    kind: Literal["velocity"] = Field(description="this kind of servo")
    gain: NotNegative = Field(description="effort per error of the velocity [N·m·s/rad or N·s/m]")


SERVOS: dict[str, type[Servo]] = {
    "dc": DcServo,
    "pid": PidServo,
    "cascade": CascadeServo,
    "effort": EffortServo,
    "velocity": VelocityServo,
}
AnyServo = Annotated[DcServo | PidServo | CascadeServo | EffortServo | VelocityServo, Field(discriminator="kind")]
