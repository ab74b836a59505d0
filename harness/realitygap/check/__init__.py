"""Mistakes of unit, sign, order, clock and coverage, found before any physics is blamed."""

from realitygap.check.check import accepted, blamed_joints, certain, check
from realitygap.check.mistake import KINDS, Mistake
from realitygap.check.spikes import advice

__all__ = ["KINDS", "Mistake", "accepted", "advice", "blamed_joints", "certain", "check"]
