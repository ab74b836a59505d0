"""Reading the tables of a bench: CSV or Parquet, checked row by row, in SI units."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from realitygap_engines.errors import in_a_line

from realitygap.files.errors import InputError
from realitygap.files.text_table import once, text_table


def read_table(
    path: Path, text: Sequence[str], numbers: Mapping[str, float], optional: Sequence[str] = ()
) -> pd.DataFrame:
    """The named columns of a table.

    Args:
        path: a `.csv` or `.parquet` file.
        text: columns with names.
        numbers: columns with numbers, and the factor to SI of each.
        optional: those of the columns that may be absent.

    Raises:
        InputError: for a file that cannot be read, a column that is missing or a row without a value; rows are
            counted as in the file, the header being row 1.
    """
    try:
        table = pd.read_parquet(path) if path.suffix == ".parquet" else text_table(path, comment="#")
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error}); expected a table") from None
    except Exception as error:  # pandas and pyarrow raise many kinds for a broken file
        what = in_a_line(error) or type(error).__name__
        raise InputError(f"{path}: is not a CSV or Parquet table ({what})") from None
    wanted = [c for c in [*text, *numbers] if c in table.columns or c not in optional]
    for column in wanted:
        if column not in table.columns:
            raise InputError(f"{path}: column {column} is missing; found {', '.join(map(str, table.columns))}")
        once(path, column, table.attrs)
    if table.empty:
        raise InputError(f"{path}: has no rows; expected one row per measurement")
    first = 2 + (0 if path.suffix == ".parquet" else _comments(path))
    for column in wanted:
        empty = np.flatnonzero(table[column].isna() | (table[column].astype(str).str.strip() == ""))
        if len(empty):
            raise InputError(f"{path}: row {empty[0] + first} has no {column}; expected a value in every row")
    out = pd.DataFrame({c: table[c].astype(str).str.strip() for c in wanted if c in text})
    for column in (c for c in wanted if c in numbers):
        values = pd.to_numeric(table[column], errors="coerce").to_numpy(dtype=float)
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            found = table[column].iloc[bad[0]]
            raise InputError(f"{path}: row {bad[0] + first} has {column} {found!r}, expected a finite number")
        out[column] = values * numbers[column]
    return out


def _comments(path: Path) -> int:
    """Comment lines before the header, so that row numbers are those of the file."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return next((i for i, line in enumerate(lines) if not line.startswith("#")), 0)
