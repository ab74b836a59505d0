"""Proposals: motions that tell apart what the recordings cannot."""
