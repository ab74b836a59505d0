"""Candidates: the effects that could be missing, and where."""
