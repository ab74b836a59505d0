"""The columns of a Parquet file, each read when it is asked for: a long recording is never there as a table."""

from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow.parquet as pq

from realitygap.files.errors import InputError
from realitygap.files.text_table import TWICE, twice

LARGEST = 2e8
"""Values of a table: three hours of twenty joints with four signals at 200 Hz, and 1.6 GB."""
WHOLE = "a whole Parquet file: get it again, or close its writer, which writes the end of it"


class ParquetColumns:
    """A table as far as a reader asks for it: its columns by name, as series.

    Attributes:
        columns: their names, without white space around them.
        attrs: in which line the rows begin and which names stand twice, as a table of text tells it.

    Raises:
        InputError: for more values than a few bytes should say, and for a file that is damaged.
    """

    def __init__(self, path: Path, plain: Path) -> None:
        self._path, self._file = path, pq.ParquetFile(plain)
        about = self._file.metadata
        if about.num_rows < 0:
            raise InputError(f"{path}: says that it holds {about.num_rows} rows: it is damaged")
        if about.num_rows * about.num_columns > LARGEST:
            raise InputError(
                f"{path}: holds {about.num_rows} rows of {about.num_columns} columns, expected at most {LARGEST:.2g} "
                "values: cut the recording, or leave columns out"
            )
        self.attrs: dict[str, Any] = {"first_line": 2, TWICE: twice(map(str, self._file.schema_arrow.names))}
        self._places = {str(name).strip(): name for name in self._file.schema_arrow.names}
        self.columns = list(self._places)

    def __len__(self) -> int:
        return int(self._file.metadata.num_rows)

    def __contains__(self, name: object) -> bool:
        return name in self._places

    def __getitem__(self, name: str) -> "pd.Series[float]":
        try:
            found: pd.Series[float] = self._file.read(columns=[self._places[name]])[self._places[name]].to_pandas()
        except Exception as error:  # pyarrow raises many kinds for a broken file
            what = " ".join(str(error).split()) or type(error).__name__
            raise InputError(f"{self._path}: is not a table ({what}); expected {WHOLE}") from None
        if len(found) != len(self):
            raise InputError(f"{self._path}: {name} holds {len(found)} values, expected {len(self)}: it is damaged")
        return found
