"""What a motion tells of the effort that is missing."""

from dataclasses import dataclass

from realitygap.trace.trace import Array


@dataclass(frozen=True)
class Lacking:
    """What a motion tells at its stamps. Shapes (t, n).

    Attributes:
        position, velocity: readings, smoothed [rad, rad/s or m].
        effort: that is missing on the joint [N·m or N].
        error: its standard error.
        load: what moving the links takes: gravity and inertia, without the rotors.
    """

    position: Array
    velocity: Array
    effort: Array
    error: Array
    load: Array
