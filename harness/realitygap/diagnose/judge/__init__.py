"""The judges: other engines, held-out runs, rivals."""
