"""How long a diagnosis looks for more, where nobody says otherwise. Nothing heavy is imported here."""

MINUTES = 3.0
"""Searches of one joint end within 40 s and of two links within two minutes of one core. A real arm with six joints
lacks something everywhere, and goes on for a quarter of an hour to find what hardly shows: its first minutes have
nearly all that its held-out runs gain. A humanoid is late when its first round ends, which is always made."""
