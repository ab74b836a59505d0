"""The budget of a search: how long a diagnosis looks for more. Nothing heavy is imported here."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace

MINUTES = 2.25
"""About how long a robot of up to thirteen joints looks for more on two slow cores where nobody says otherwise; as long
again takes what could stand in the place of what was found. Searches of one joint end within 40 s and of two links
within two minutes of one core. A real arm with six joints lacks something everywhere, and goes on for a quarter of an
hour to find what hardly shows: this has nearly all that its held-out runs gain (score 0.163 before, 0.113 after, and
0.1125 to 0.117 when it looked a third longer)."""
EACH = 1 / 5
"""The same for every joint of a robot with many: a humanoid needs a minute for a plain fit and two or three for a round
of all that could be seen beside it, in which load-dependent friction was found on each of three ways that rounding led
a search. What a quarter more finds beside that is a little at the ground and in the offsets."""
STEPS = 96e6
"""Engine steps that make a minute of two slow cores, times the joints that each moves: on an SO-101 a step takes 7.5 µs
there. They are counted, and not the time, for a search to be the same on every machine."""
FEWEST = 4
"""With fewer joints, or none, it takes as many steps: what is around a joint's step counts, too. A servo with 24
recordings had its friction and its delay within 36 million, of which held-out runs refused the friction, and within 54
a centre of mass beside them: errors there of 0.038 rad in place of 0.057. With a third more it found the same."""
AGAIN = 1 / 3
"""The steps of a round that gains more than this share of what was explained before it are not counted. Where six
joints lacked 25 effects the third round still did, with play of five joints to come, when an SO-101, whose second one
gained a quarter, had nearly all."""
LONGER = 3.0
"""The longest that a diagnosis looks for more, where an engine or a machine is slow, in multiples of that time."""


@dataclass(frozen=True)
class SearchBudget:
    """How long to look for more.

    Attributes:
        steps: of engines that may be asked for before, so that what is found does not hang on how fast a processor is.
        until: when to look for nothing more in any case, on the clock of `time.monotonic` [s].
    """

    steps: float = math.inf
    until: float = math.inf

    @staticmethod
    def of(joints: int, minutes: float | None, began: float) -> SearchBudget:
        """For so many minutes, or, of a robot with so many joints, about as long as it takes."""
        if minutes is not None:
            return SearchBudget(until=began + 60.0 * minutes)
        ordinary = max(MINUTES, EACH * joints)
        return SearchBudget(STEPS * ordinary / max(joints, FEWEST), began + 60.0 * LONGER * ordinary)

    def beside(self, steps: float, gained: float, explained: float) -> SearchBudget:
        """The same beside a round of so many steps that gained so much evidence over what was explained before."""
        return replace(self, steps=self.steps + steps) if gained > AGAIN * explained else self

    def part(self, share: float, steps: float) -> SearchBudget:
        """For so many steps, and this share of the time that is left."""
        now = time.monotonic()
        return SearchBudget(steps, now + share * (self.until - now))

    def over(self, steps: float) -> bool:
        """Whether so many steps, or the time, are enough."""
        return steps > self.steps or time.monotonic() > self.until


UNLIMITED = SearchBudget()
"""To the end."""
