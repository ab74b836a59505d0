"""A first scenario from what a team has."""
