"""Traces: motion over time, simulated or measured, the same type."""
