"""Comparison: the gap, its floors, the table of gaps and the budget."""
