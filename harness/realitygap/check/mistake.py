"""What a check finds: something that a person got wrong, and not physics that a model lacks."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

Certainty = Literal["certain", "likely"]

KINDS: dict[str, str] = {
    "degrees": "an angle in degrees where radians are expected, or the other way round: a factor of 57.3",
    "counts": "an angle in encoder counts, or in another unit that is none of angles, where radians are expected",
    "thousandths": "a length in mm (an angle in mrad) where m (rad) is expected, or the other way round",
    "milliseconds": "times in ms or µs where seconds are expected, or the other way round",
    "coarse_times": "times without the fractions of a second that tell the samples of a motion apart",
    "milliamperes": "an effort a thousand times too large or too small, as from a current in mA",
    "grams": "masses in g or inertias in kg·mm² where kg and kg·m² are expected, or the other way round",
    "flipped_sign": "a command, a state or an effort counts the other way round",
    "swapped_joints": "the signals of two or more joints stand under one another's names",
    "coupling": "a joint that mimics another in the robot's file was measured elsewhere than that says",
    "held_joint": "a joint that is held as it was not measured was commanded to move",
    "another_motion": "the measurement is not of the motion that was commanded",
    "asked_effort": "commands that are efforts, where positions are expected",
    "no_overlap": "commands and states were recorded at different times",
    "clock_offset": "commands and states were stamped by clocks that differ",
    "velocity": "the reported velocity is not the derivative of the position",
    "effort_size": "an effort that no servo of this robot gives",
    "effort_direction": "an effort that does not push towards the command",
    "stuck_position": "a position that never changes while the joint is moved, or not for a while in which it was lost",
    "placeholder": "positions far from all others that stand for readings that were lost",
    "two_senders": "readings that jump away and back again and again, as of two senders of one joint",
    "far_zero": "a position that is far from its command all along",
    "velocity_limit": "a joint was driven faster than the velocity limit that its servo keeps in the simulation",
    "undriven_joint": "nothing drives a joint: it has no servo, or no command",
    "constant_command": "a command that never changes while the joint is moved",
    "far_start": "the motion begins far from its first command, or the simulation far from the motion",
    "servo_pattern": "a pattern of a servo that matches no joint, or only joints that another servo has",
    "impossible_link": "a mass or inertia that no such link has",
    "other_conditions": "recordings that are taken as repetitions of one motion differ as under other conditions",
    "few_samples": "a recording, or its window, holds too few samples to say anything of a motion",
    "window": "a window reaches beyond its recording",
    "drives_nothing": "nothing in the scenario drives the robot",
}
"""Every kind of mistake, and what it is."""


@dataclass(frozen=True)
class Mistake:
    """One mistake.

    Attributes:
        kind: one of `KINDS`.
        certainty: whether nothing else explains it, or something else hardly does.
        joints: where; the sorted names of joints.
        sentence: what was found, what was expected and what to do, with the numbers that show it.
        key: the line of the scenario that it stands at or that mends it.
        runs: the recordings that show it.
        signal: that is in another unit; "" where it is none, or the robot's file is.
    """

    kind: str
    certainty: Certainty
    joints: tuple[str, ...]
    sentence: str
    key: str
    runs: tuple[str, ...] = ()
    signal: str = ""

    @property
    def found(self) -> str:
        """The sentence without what was expected."""
        return self.sentence.rpartition("; expected")[0] or self.sentence

    @property
    def text(self) -> str:
        """The sentence with its place, and how many more recordings show the same."""
        more = len(self.runs) - 1
        also = f" (and in {more} other recording{'s' * (more > 1)})" if more > 0 else ""
        return f"{self.key}: {self.sentence}{also}"


def merged(mistakes: Iterable[Mistake]) -> list[Mistake]:
    """The same mistake at the same joints in several recordings as one, told where it is plainest."""
    groups: dict[tuple[str, tuple[str, ...]], list[Mistake]] = {}
    for m in mistakes:
        groups.setdefault((m.kind, m.joints), []).append(m)
    out = []
    for same in groups.values():
        plainest = min(same, key=lambda m: m.certainty)
        runs = dict.fromkeys(run for m in (plainest, *same) for run in m.runs)
        out.append(replace(plainest, runs=tuple(runs)))
    return sorted(out, key=lambda m: m.certainty)
