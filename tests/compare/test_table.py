"""A table of gaps that is damaged is told in one sentence, whatever is in its cells."""

from pathlib import Path

import pandas as pd
import pytest
from realitygap.compare.table import read_gaps
from realitygap.files.errors import InputError

DEMO = Path(__file__).parents[2] / "results" / "reference" / "demo" / "gaps.csv"


WRONG = [("solver_iterations", cell) for cell in ("1.5", "-", "99999999999999999999", "inf")]
WRONG += [("step_rate", "fast"), ("mean_abs", "1,5")]


@pytest.mark.parametrize(("column", "cell"), WRONG)
def test_a_cell_that_is_no_such_number(column: str, cell: str, tmp_path: Path) -> None:
    frame = pd.read_csv(DEMO, dtype=str, keep_default_na=False)
    frame.loc[3, column] = cell
    path = tmp_path / "gaps.csv"
    frame.to_csv(path, index=False)
    with pytest.raises(InputError, match=r"gaps.csv: is not a table of gaps \("):
        read_gaps(path)
