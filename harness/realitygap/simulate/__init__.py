"""Simulation: from a scenario to a trace. The only place where time passes."""
