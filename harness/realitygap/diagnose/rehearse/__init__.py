"""Rehearsal: effects planted in a scenario, to see what its recordings could reveal."""
