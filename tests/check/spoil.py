"""Mistakes that people make, put into a team's folder: what is done, and what a check must call it."""

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from signals import there
from teams import Team

DEGREES = 180 / np.pi
Spoil = Callable[[Team, int], None]


@dataclass(frozen=True)
class Planted:
    """A mistake: its name, the kind that a check must call it, whether it sits at one joint, and what it does."""

    name: str
    kind: str
    spoil: Spoil
    where: str = "joint"  # "joint", "pair" (the joint and the next) or "all"
    joints: tuple[int, ...] = (1, 2, 6)  # robots that it can happen to
    slides: bool = True
    with_effort: bool = False


def scaled(signal: str, factor: float, everywhere: bool = False) -> Spoil:
    def spoil(team: Team, j: int) -> None:
        for table in team.tables.values():
            columns = slice(None) if everywhere else j
            getattr(table, signal)[:, columns] *= factor

    return spoil


def counted(*signals: str, noise: float = 0.0) -> Spoil:
    """As a servo's register holds it; noise of a filter [counts] leaves no whole numbers."""

    def spoil(team: Team, j: int) -> None:
        for number, table in enumerate(team.tables.values()):
            rng = np.random.default_rng(number)
            for signal in signals:
                value = getattr(table, signal)
                value[:, j] = np.round(2048 + value[:, j] * 4096 / (2 * np.pi)) + noise * rng.standard_normal(
                    len(value)
                )

    return spoil


def both(*spoils: Spoil) -> Spoil:
    def spoil(team: Team, j: int) -> None:
        for each in spoils:
            each(team, j)

    return spoil


def swapped(*signals: str) -> Spoil:
    def spoil(team: Team, j: int) -> None:
        other = (j + 1) % len(team.joints)
        for table in team.tables.values():
            for signal in signals:
                value = getattr(table, signal)
                value[:, [j, other]] = value[:, [other, j]]

    return spoil


def times(factor: float) -> Spoil:
    def spoil(team: Team, _: int) -> None:
        for table in team.tables.values():
            table.time = table.time * factor

    return spoil


def apart(team: Team, _: int) -> None:
    for table in team.tables.values():
        table.command_time = table.time + table.time[-1] + 3.0


def offset(seconds: float) -> Spoil:
    def spoil(team: Team, _: int) -> None:
        for table in team.tables.values():
            table.command_time = table.time + seconds

    return spoil


def effort_commanded(team: Team, j: int) -> None:
    for table in team.tables.values():
        assert table.effort is not None
        table.command[:, j] = np.where(np.isfinite(table.command[:, j]), table.effort[:, j], np.nan)


def another(team: Team, _: int) -> None:
    """The measurements of the first two recordings change places."""
    first, second = list(team.tables.values())[:2]
    k = min(len(first.time), len(second.time))
    for table in (first, second):
        for signal in ("time", "command", "position", "velocity", "effort"):
            setattr(table, signal, getattr(table, signal)[:k])
    for signal in ("position", "velocity", "effort"):
        a, b = getattr(first, signal), getattr(second, signal)
        setattr(first, signal, b)
        setattr(second, signal, a)


def column_of_another(team: Team, j: int) -> None:
    """One joint's measurement is of another motion in every recording."""
    tables = list(team.tables.values())
    k = min(len(t.time) for t in tables)
    for signal in ("position", "velocity", "effort"):
        first = [getattr(t, signal)[:k, j].copy() for t in tables]
        for t, value in zip(tables, [*first[1:], first[0]], strict=True):
            getattr(t, signal)[:k, j] = value
    for t in tables:
        for signal in ("time", "command", "position", "velocity", "effort"):
            setattr(t, signal, getattr(t, signal)[:k])


def velocity_of_nothing(team: Team, j: int) -> None:
    for table in team.tables.values():
        table.velocity[:, j] = np.roll(table.velocity[:, j], len(table.time) // 3)


def velocity_zero(team: Team, j: int) -> None:
    for table in team.tables.values():
        table.velocity[:, j] = 0.0


def effort_magnitude(team: Team, j: int) -> None:
    for table in team.tables.values():
        effort = there(table.effort)
        effort[:, j] = np.abs(effort[:, j])


def without_servo(team: Team, j: int) -> None:
    names = [x for i, x in enumerate(team.joints) if i != j]
    servo = team.scenario["servos"][0]
    if len(team.scenario["servos"]) > 1:
        del team.scenario["servos"][j]
    else:
        servo["joints"] = names


def never_commanded(team: Team, j: int) -> None:
    for table in team.tables.values():
        table.command[:, j] = np.nan


def stuck_command(team: Team, j: int) -> None:
    for table in team.tables.values():
        table.command[:, j] = table.command[0, j]


def far(team: Team, j: int) -> None:
    """The robot is brought to its first command while the recording runs."""
    for table in team.tables.values():
        decay = 0.9 * np.exp(-table.time / 0.15)
        table.position[:, j] += decay
        table.velocity[:, j] -= decay / 0.15


def stuck_encoder(team: Team, j: int) -> None:
    for table in team.tables.values():
        table.position[:, j] = table.position[0, j]


def lost_readings(team: Team, j: int) -> None:
    """A driver writes a number of its own while the bus is silent."""
    for table in team.tables.values():
        lost = (table.time > 2.0) & (table.time < 3.0)
        table.position[lost, j] = table.position[:, j].max() + (0.05 if team.joints[j].startswith("slide") else 0.5)


def other_zero(team: Team, j: int) -> None:
    for table in team.tables.values():
        table.position[:, j] -= 1.2


def start_elsewhere(team: Team, j: int) -> None:
    team.scenario["robot"]["start"] = {team.joints[j]: 1.4}


def pattern(team: Team, j: int) -> None:
    servo = team.scenario["servos"][min(j, len(team.scenario["servos"]) - 1)]
    joints = servo["joints"]
    servo["joints"] = [*([joints] if isinstance(joints, str) else joints), "knee_*"]


def no_servos(team: Team, _: int) -> None:
    team.scenario["servos"] = []


def no_motion(team: Team, _: int) -> None:
    team.scenario["no motion"] = True


def masses(factor: float, everywhere: bool, inertia: float = 1.0) -> Spoil:
    def spoil(team: Team, j: int) -> None:
        for name, text in team.files.items():
            count = -1

            def heavier(match: re.Match[str]) -> str:
                nonlocal count
                count += 1
                return f'<mass value="{float(match[1]) * factor:.9g}"' if everywhere or count == j else match[0]

            text = re.sub(r'<mass value="([^"]*)"', heavier, text)
            count = -1

            def wider(match: re.Match[str]) -> str:
                nonlocal count
                count += 1
                if not (everywhere or count == j):
                    return match[0]
                return re.sub(r'(i[xyz][xyz])="([^"]*)"', lambda m: f'{m[1]}="{float(m[2]) * inertia:.9g}"', match[0])

            team.files[name] = re.sub(r"<inertia [^>]*>", wider, text)

    return spoil


def lengths(factor: float) -> Spoil:
    """The origins of all joints beyond the first."""

    def spoil(team: Team, _: int) -> None:
        def longer(match: re.Match[str]) -> str:
            xyz = " ".join(f"{float(x) * factor:g}" for x in match[2].split())
            return f'{match[1]}"{xyz}"'

        for name, text in team.files.items():
            head, *joints = re.split(r"(?=<joint )", text)
            joints = [re.sub(r'(<origin xyz=)"([^"]*)"', longer, joint, count=1) for joint in joints]
            team.files[name] = head + "".join(joints)

    return spoil


def limits(factor: float) -> Spoil:
    def spoil(team: Team, j: int) -> None:
        for name, text in team.files.items():
            parts = re.split(r"(<limit[^>]*>)", text)
            parts[2 * j + 1] = re.sub(
                r'(lower|upper)="([^"]*)"', lambda m: f'{m[1]}="{round(float(m[2]) * factor, 3):g}"', parts[2 * j + 1]
            )
            team.files[name] = "".join(parts)

    return spoil


state = ("position", "velocity", "effort")
MISTAKES = (
    Planted("position in degrees", "degrees", scaled("position", DEGREES), slides=False),
    Planted("all positions in degrees", "degrees", scaled("position", DEGREES, True), "all", slides=False),
    Planted("command in degrees", "degrees", scaled("command", DEGREES), slides=False),
    Planted("position in turned degrees", "degrees", scaled("position", 1 / DEGREES), slides=False),
    Planted("command in turned degrees", "degrees", scaled("command", 1 / DEGREES), slides=False),
    Planted(
        "everything in degrees",
        "degrees",
        both(*(scaled(s, DEGREES, True) for s in ("position", "velocity", "command"))),
        "all",
        slides=False,
    ),
    Planted("velocity in degrees", "degrees", scaled("velocity", DEGREES), slides=False),
    Planted("velocity in turned degrees", "degrees", scaled("velocity", 1 / DEGREES), slides=False),
    Planted("limits in degrees", "degrees", limits(DEGREES), slides=False),
    Planted("position in mm or mrad", "thousandths", scaled("position", 1000.0)),
    Planted("command in mm or mrad", "thousandths", scaled("command", 1000.0)),
    Planted("velocity in mm/s or mrad/s", "thousandths", scaled("velocity", 1000.0)),
    Planted("times in ms", "milliseconds", times(1e3), "all"),
    Planted("times in µs", "milliseconds", times(1e6), "all"),
    Planted("times divided by 1000", "milliseconds", times(1e-3), "all"),
    Planted("effort in mA", "milliamperes", scaled("effort", 1000.0), with_effort=True),
    Planted("effort divided by 1000", "milliamperes", scaled("effort", 1e-3), with_effort=True),
    Planted("all masses in g", "grams", masses(1e3, True), "any"),
    Planted("all masses and inertias in g", "grams", masses(1e3, True, 1e3), "any"),
    Planted("all masses and inertias divided by 1000", "grams", masses(1e-3, True, 1e-3), "any"),
    Planted("a mass in g", "grams", masses(1e3, False)),
    Planted("inertia in kg·mm²", "impossible_link", masses(1.0, False, 1e6), slides=False),
    Planted("command flipped", "flipped_sign", scaled("command", -1.0)),
    Planted("position flipped", "flipped_sign", scaled("position", -1.0)),
    Planted("state flipped", "flipped_sign", both(*(scaled(s, -1.0) for s in state))),
    Planted("velocity flipped", "flipped_sign", scaled("velocity", -1.0)),
    Planted("effort flipped", "flipped_sign", scaled("effort", -1.0), with_effort=True),
    Planted("commands swapped", "swapped_joints", swapped("command"), "pair", (2, 6)),
    Planted("positions swapped", "swapped_joints", swapped("position"), "pair", (2, 6)),
    Planted("states swapped", "swapped_joints", swapped(*state), "pair", (2, 6)),
    Planted("velocities swapped", "swapped_joints", swapped("velocity"), "pair", (2, 6)),
    Planted("efforts swapped", "swapped_joints", swapped("effort"), "pair", (2, 6), with_effort=True),
    Planted("measurement of another motion", "another_motion", another, "all"),
    Planted("a joint of another motion", "another_motion", column_of_another, joints=(2, 6)),
    Planted("streams apart", "no_overlap", apart, "all"),
    Planted("states 1.5 s late", "clock_offset", offset(-1.5), "all"),
    Planted("states 0.6 s late", "clock_offset", offset(-0.6), "all"),
    Planted("states 0.4 s early", "clock_offset", offset(0.4), "all"),
    Planted("velocity at another time", "velocity", velocity_of_nothing),
    Planted("velocity of zero", "velocity", velocity_zero),
    Planted("effort 30 times too large", "effort_size", scaled("effort", 30.0), with_effort=True),
    Planted("effort without sign", "effort_direction", effort_magnitude, with_effort=True),
    Planted("an effort taken for a position command", "asked_effort", effort_commanded, with_effort=True),
    Planted("a joint without servo", "undriven_joint", without_servo, joints=(2, 6)),
    Planted("a joint never commanded", "undriven_joint", never_commanded, joints=(2, 6)),
    Planted("a command that never changes", "constant_command", stuck_command),
    Planted("a first command far away", "far_start", far, slides=False),
    Planted("a stated start far away", "far_start", start_elsewhere, slides=False),
    Planted("a pattern that matches nothing", "servo_pattern", pattern, "none"),
    Planted("no servos", "drives_nothing", no_servos, "all"),
    Planted("no motion", "drives_nothing", no_motion, "all"),
    Planted("an encoder that is stuck", "stuck_position", stuck_encoder),
    Planted("another zero", "far_zero", other_zero, slides=False),
    Planted("origins of joints in mm", "thousandths", lengths(1000.0), "any", (2, 6)),
    Planted("readings lost for a second", "stuck_position", lost_readings),
    Planted("position in counts", "counts", counted("position"), slides=False),
    Planted("command in counts", "counts", counted("command"), slides=False),
    Planted("position and command in counts", "counts", counted("position", "command"), slides=False),
    Planted("both in filtered counts", "counts", counted("position", "command", noise=0.3), slides=False),
)
