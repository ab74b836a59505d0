"""How long a diagnosis looks for more, where nobody says otherwise. Nothing heavy is imported here."""

MINUTES = 3.0
"""Searches of one joint end within 40 s and of two links within two minutes of one core. A real arm with six joints
lacks something everywhere, and goes on for a quarter of an hour to find what hardly shows: its first minutes have
nearly all that its held-out runs gain."""
EACH = 1 / 3
"""The same for every joint of a robot with many: a humanoid needs a minute for a plain fit and five for a round of all
that could be seen beside it."""


def minutes_for(joints: int) -> float:
    """How long to look for more, of a robot with so many joints [min]."""
    return max(MINUTES, EACH * joints)
