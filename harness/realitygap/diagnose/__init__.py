"""Diagnosis: where simulation and measurement disagree, which effect is missing, and the proof on held-out runs."""
