"""The matrix: scenarios through engines, revisions, grounds, step rates and whatever else a scenario states."""
