"""The search for what is missing."""
