"""What people see of a result folder: figures for papers and one page that opens offline."""

from pathlib import Path

from realitygap.report.figures import write_figures
from realitygap.report.page import write_page

__all__ = ["write_figures", "write_page", "write_report"]


def write_report(folder: Path) -> Path:
    """Write the figures and the page of a result folder. Returns the page.

    Raises:
        InputError: where the folder holds no result table.
    """
    write_figures(folder)
    return write_page(folder)
