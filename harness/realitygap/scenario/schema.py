"""The scenario file: one specification of what happens, for every engine. `scenarios/README.md` is made from this."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from realitygap.scenario.propose import ProposeSpec
from realitygap.scenario.section import Finite, Positive, Section
from realitygap.scenario.servos import AnyServo
from realitygap.scenario.world import GROUNDS, GroundSpec, PhysicsSpec


class Robot(Section):
    """The robot and how it stands at the start."""

    urdf: str = Field(description="the robot's file: URDF, xacro, MJCF or SDF")
    packages: dict[str, str] = Field(default={}, description="where `package://NAME/` lies, by NAME")
    base: Literal["floating", "fixed", "free"] = Field(
        default="floating", description="floating, fixed to the world, or a free body without joints"
    )
    start: Literal["recording", "keyframe", "zero"] | dict[str, Finite] = Field(
        default="recording",
        description="joint angles at the start: measured, the first keyframe's, zero, or by joint [rad]",
    )
    stand_on: str | None = Field(default=None, description="this link is level on the ground at the start")
    hold: dict[str, Finite] = Field(
        default={},
        description="joints that do not move, as a gripper that was not recorded: welded at this position [rad or m], "
        "by patterns over joint names (the first that matches)",
    )
    contact_links: list[str] | None = Field(
        default=None, description="links that touch the ground (default: the base and the last links of the tree)"
    )


class Motion(Section):
    """What the servos are told (a recorded stream of commands, or keyframes), or a measured motion that is followed."""

    recorded: str | Annotated[dict[str, str], Field(min_length=1)] | None = Field(
        default=None,
        description="topic or column of the recorded commands; or, where every joint has a topic of its own "
        "(std_msgs/Float64), the topics by patterns over joint names (the first that matches), `*` in one being the "
        'joint\'s own name: `{"*": "/*_position_controller/command"}`',
    )
    keyframes: str | None = Field(default=None, description="animation file with goals in degrees, duration and pause")
    followed: bool = Field(
        default=False,
        description="the joints follow the measured motion, and the effort that this takes is compared with the "
        "measured one: no servos, no commands",
    )
    meaning: Literal["position", "velocity", "duty", "effort"] = Field(
        default="position",
        alias="as",
        description="what a recorded command is; a measured effort can be the command, too: `{recorded: /joint_states, "
        "as: effort}`, with the `factor` of `recordings.effort`",
    )
    joints: list[str] | None = Field(
        default=None, description="the joints of a command's values, in order, where messages name none (MultiArray)"
    )
    held: bool = Field(
        default=True,
        description="recorded commands hold until the next one, as on a bus; false: they are samples of a trajectory, "
        "linear in between",
    )

    @model_validator(mode="after")
    def _one_source(self) -> Motion:
        if (self.recorded is not None) + (self.keyframes is not None) + self.followed != 1:
            raise ValueError("expected one of recorded, keyframes and followed")
        if isinstance(self.recorded, dict) and self.joints is not None:
            raise ValueError("found joints beside a topic for each of them; expected joints for one topic of all")
        return self


class EffectSpec(BaseModel):
    """One effect: its name, where it sits, and its parameters by name (`realitygap effects NAME`)."""

    model_config = ConfigDict(extra="allow", frozen=True)
    effect: str = Field(description="name of the effect")
    target: str | list[str] = Field(default="*", description="joint, link, `ground`, `base`, or joint patterns")

    @property
    def parameters(self) -> dict[str, Any]:
        """The remaining keys: parameter values in SI units."""
        return dict(self.model_extra or {})


class Stream(Section):
    """A stream of messages other than JointState that hold arrays."""

    topic: str = Field(description="the topic")
    names: str | None = Field(default=None, description="field with the joint names")
    joints: list[str] | None = Field(default=None, description="or the names themselves, where messages have none")
    position: str | None = Field(default=None, description="field with the positions")
    velocity: str | None = Field(default=None, description="field with the velocities")
    effort: str | None = Field(default=None, description="field with the efforts")


class EffortStream(Section):
    """A measured effort and its unit."""

    topic: str | None = Field(default=None, description="topic or column, where it is not part of the state")
    joints: list[str] | None = Field(default=None, description="the joints of its values, where messages name none")
    measures: Literal["motor", "joint"] = Field(default="motor", description="torque of the motor, or on the joint")
    factor: Finite | Literal["fit"] | dict[str, Finite | Literal["fit"]] = Field(
        default=1.0,
        description="effort per recorded unit [N·m or N], for all joints or by patterns over joint names (the first "
        "that matches); of a motor's current this is its drive gain, and `fit` leaves it to the followed motions: a "
        "payload that only some of them carry fixes it, or else the robot's own weight",
    )


Length = Literal["rad", "mrad", "deg", "mdeg", "rev", "m", "cm", "mm"]
Lengths = Length | dict[str, Length]
Rate = Literal[Length, "rpm"]
Rates = Rate | dict[str, Rate]


LEFT_OUT = "none"
"""In place of a column: that signal is not taken."""


class Units(Section):
    """The units of a table's columns or a bag's joints, for all joints or by joint pattern; velocities are per s."""

    time: Literal["s", "ms", "us", "ns"] = Field(default="s", description="of a table's time")
    command: Rates = Field(
        default="rad", description="of a command that is a position, or a velocity, per s or in revolutions per minute"
    )
    position: Lengths = Field(default="rad", description="of the measured position (rad and m are the same here)")
    velocity: Rates = Field(default="rad", description="of the measured velocity, per s, or revolutions per minute")


class Columns(Section):
    """Column names of a table. A joint signal is one column, a name from which those of the joints are made
    (`position_elbow`, `elbow_position`, `position.elbow` or `position/elbow`), or a mapping from joint to column.
    """

    units: Units = Field(
        default=Units(), description="of these columns, or of a bag's joints; an effort's is said by `effort`"
    )
    time: str | list[str] = Field(
        default="time", description="time [s]; or the two columns of a stamp, its seconds and its nanoseconds"
    )
    command: str | dict[str, str] = Field(
        default="command", description="the command [rad or m, or what `motion.as` says]"
    )
    position: str | dict[str, str] = Field(default="position", description="measured position [rad or m]")
    velocity: str | dict[str, str] = Field(
        default="velocity", description="measured velocity [rad/s or m/s]; `none` leaves one out that is wrong"
    )
    effort: str | dict[str, str] = Field(
        default="effort", description="measured effort, in the unit that `effort` states"
    )
    torque_enabled: str | dict[str, str] = Field(
        default="torque_enabled", description="0: the servo is off; one for all or by joint"
    )
    supply: str = Field(default="supply_voltage", description="supply voltage [V]")
    temperature: str | dict[str, str] = Field(
        default="temperature", description="temperature of the motors, one for all or by joint [°C]"
    )
    base_position: list[str] = Field(default=["x", "y", "z"], description="of the base [m]")
    base_quaternion: list[str] = Field(default=["qw", "qx", "qy", "qz"], description="orientation of the base, w x y z")
    base_linear: list[str] = Field(default=["vx", "vy", "vz"], description="velocity of the base in world axes [m/s]")
    base_angular: list[str] = Field(default=["wx", "wy", "wz"], description="angular velocity of the base [rad/s]")
    base_angular_axes: Literal["body", "world"] = Field(default="body", description="axes of the angular velocity")


Unit = Literal["degrees", "radians", "normalized", "percent"]
Episode = Annotated[int, Field(strict=True, ge=0)] | str


def _ordered(span: tuple[float, float]) -> tuple[float, float]:
    start, end = span
    if not start < end:
        swapped = f", as [{end:g}, {start:g}]" if end < start else ""
        raise ValueError(f"expected a start before its end, [start, end] in s{swapped}")
    return span


Span = Annotated[tuple[Finite, Finite], AfterValidator(_ordered)]


class DataSet(Section):
    """What a LeRobot data set does not say of its positions. By default `observation.state` is the position, `action`
    the command and `observation.velocity` the velocity; `columns` and `motion.recorded` name other features.
    """

    units: Unit | dict[str, Unit] = Field(
        default="degrees",
        description="of positions, for all or by joint pattern: degrees, radians, normalized (-100 to 100, and 0 to "
        "100 for what is called gripper) or percent (0 to 100); velocities per s",
    )
    calibration: str | None = Field(
        default=None, description="LeRobot's calibration file of the arm (JSON): what normalized units are in angles"
    )
    range: dict[str, tuple[Finite, Finite]] = Field(
        default={}, description="or the positions at both ends of normalized units, by joint pattern [rad or m]"
    )
    joints: dict[str, str] = Field(default={}, description="the data set's name of a joint, where it is another")


class Run(Section):
    """One recording."""

    path: str = Field(
        description="a bag, a bag folder, a table or the folder of a LeRobot data set; `*` and `?` stand for several"
    )
    episode: Episode | None = Field(default=None, description="of a data set: its number, or the name of its task")
    part: Span | None = Field(
        default=None, description="[start, end]: only this much is read and simulated [s from the first message]"
    )
    use: Literal["train", "held_out"] | None = Field(default=None, description="for fitting, or kept back to judge on")
    window: Span | None = Field(default=None, description="[start, end]: what is judged [s from the first message]")
    overrides: dict[str, Any] = Field(default={}, alias="with", description="scenario keys that differ for this run")

    @property
    def judged(self) -> tuple[float, float]:
        """What is judged [s from the first message]: the window, else the part, else all."""
        return self.window or self.part or (-math.inf, math.inf)


class Recordings(Section):
    """What was measured, and where it lies."""

    state: str | Stream | None = Field(default=None, description="topic of the measured joint states")
    effort: Literal["none", "motor", "joint"] | EffortStream = Field(
        default="none", description="whether the state's effort was measured, and what it measures"
    )
    joints: dict[str, str] = Field(
        default={},
        description="the names that bags and tables have for joints, where they are others, by patterns over joint "
        'names (the first that matches); `*` in a name is the joint\'s own: `{"*": "left_arm/*"}`',
    )
    columns: Columns = Field(default=Columns(), description="for tables; `units` for bags, too")
    dataset: DataSet = Field(default=DataSet(), description="for LeRobot data sets")
    episode: Episode | None = Field(default=None, description="of a data set, where a run does not say its own")
    part: Span | None = Field(
        default=None, description="[start, end]: what is read and simulated, where a run does not say its own"
    )
    pose: str | None = Field(default=None, description="topic of the base pose (PoseStamped, Odometry)")
    imu: str | None = Field(default=None, description="topic of an Imu on the base")
    battery: str | None = Field(default=None, description="topic of the supply (BatteryState)")
    temperature: str | None = Field(default=None, description="topic of a sensor_msgs/Temperature, of all motors [°C]")
    exclude: list[str] = Field(default=[], description="joints left out of the means")
    ground: str | None = Field(default=None, description="what the real robot stood on, if known")
    virtual: bool = Field(default=False, description="the recordings come from a simulation, not from a robot")
    runs: list[Run] = Field(default=[], description="the recordings")


class Budget(Section):
    """Largest mean gap of moving joints that is accepted."""

    position: Positive | None = Field(default=None, description="mean gap in position [°, or mm for prismatic joints]")
    velocity: Positive | None = Field(default=None, description="mean gap in velocity [°/s or mm/s]")
    effort: Positive | None = Field(default=None, description="mean gap in effort [N·m or N]")


class Scenario(Section):
    """What happens: robot, servos, motion, ground, physics, recordings."""

    name: str = Field(description="name of the scenario")
    robot: Robot = Field(description="the robot and how it starts")
    revisions: dict[str, str] = Field(default={}, description="named URDF files for the matrix axis `revision`")
    servos: list[AnyServo] = Field(
        default=[], description="what turns a command into torque (default: the actuators of a MJCF file)"
    )
    motion: Motion | None = Field(default=None, description="what the servos are told")
    ground: Literal["none", "flat", "grass"] | GroundSpec | None = Field(
        default=None, description="what it stands on (default: flat, or none where the base is fixed)"
    )
    physics: PhysicsSpec = Field(default=PhysicsSpec(), description="how to simulate")
    effects: list[EffectSpec] = Field(default=[], description="physics that is added to the model")
    recordings: Recordings | None = Field(default=None, description="what was measured")
    budget: Budget | None = Field(default=None, description="what `run` and tests accept")
    propose: ProposeSpec | None = Field(default=None, description="what may be proposed to record")
    accept: list[str] = Field(
        default=[],
        description="what `check` finds and that is no mistake here: `KIND` or `KIND@JOINT`, with patterns "
        "over joint names",
    )
    certain: list[str] = Field(
        default=[],
        description="quantities that a diagnosis must not suspect, as `servos.*.gain`, `servos.legs.friction`, "
        "`robot.mass`, `robot.mass@forearm` or `ground`, and effects, as `command_delay` or `joint_offset@elbow`",
    )
    suspects: list[str] | None = Field(
        default=None,
        min_length=1,
        description="the only effects that a diagnosis may suspect (default: all): `EFFECT` or `EFFECT@TARGET`, with "
        "patterns over joint and link names",
    )

    def __repr__(self) -> str:
        return f"<Scenario {self.name}: {self.robot.urdf}, {self.robot.base} base, ground {self.ground_name}>"

    __str__ = __repr__

    @property
    def virtual(self) -> bool:
        """Whether the recordings come from a simulation."""
        return self.recordings is not None and self.recordings.virtual

    @property
    def follows(self) -> bool:
        """Whether the joints follow the measured motion."""
        return self.motion is not None and self.motion.followed

    @property
    def effort_measures(self) -> str:
        """What the measured effort is of: `none`, `motor` or `joint`."""
        effort = self.recordings.effort if self.recordings is not None else "none"
        return effort if isinstance(effort, str) else effort.measures

    @property
    def effort_is_fitted(self) -> bool:
        """Whether a factor of the measured effort is left to be fitted."""
        effort = self.recordings.effort if self.recordings is not None else None
        factor = effort.factor if isinstance(effort, EffortStream) else 1.0
        return "fit" in (factor.values() if isinstance(factor, dict) else [factor])

    @property
    def ground_spec(self) -> GroundSpec | None:
        """The ground by its numbers; None for no ground."""
        return self.ground if isinstance(self.ground, GroundSpec) else GROUNDS[self.ground_name]

    @property
    def ground_name(self) -> str:
        """The ground's name in tables."""
        if isinstance(self.ground, GroundSpec):
            parts = [f"{k} {v:g}" for k, v in self.ground.model_dump(exclude_none=True).items()]
            return ", ".join(parts)
        return self.ground or ("none" if self.robot.base == "fixed" else "flat")

    @property
    def timestep(self) -> float:
        """Length of one step [s]."""
        step = 1.0 / self.physics.step_rate
        assert math.isfinite(step)
        return step
