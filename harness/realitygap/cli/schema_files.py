"""Where the JSON Schemas lie: each in the room of the file that it describes. Nothing heavy is imported to know it."""

from pathlib import Path

from realitygap.scenario.schema_file import SCHEMA

ROOMS = Path(__file__).parents[1]
SCHEMA_FILES = {
    "scenario": SCHEMA,
    "matrix": ROOMS / "matrix" / "matrix.schema.json",
    "bench": ROOMS / "bench" / "bench.schema.json",
}
