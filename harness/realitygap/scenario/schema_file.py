"""The JSON Schema of scenario files, for editors: it lies beside this and is made by `make reference`."""

from pathlib import Path

SCHEMA = Path(__file__).with_name("scenario.schema.json")
COMMENT = f"# yaml-language-server: $schema={SCHEMA.name}"
"""The line at the top of a scenario by which editors find the schema beside it."""
