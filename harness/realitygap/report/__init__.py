"""What people see of a result folder: figures for papers and one page that opens offline."""

from pathlib import Path

from realitygap.files.errors import spared
from realitygap.files.result_folder import settle, written_whole
from realitygap.files.whole import check_writable
from realitygap.report.each import Each, one_by_one
from realitygap.report.figures import write_figures
from realitygap.report.folder import read_folder
from realitygap.report.page import write_page

__all__ = ["remake", "write_figures", "write_page", "write_report"]

RESULTS = ("traces/*", "gaps.csv", "timings.csv", "missing_effort.*")
"""What page and figures are made of."""


def write_report(folder: Path, each: Each = one_by_one) -> list[str]:
    """Write the figures and the page of a new result folder. Returns sentences on what could not be drawn.

    `each` does work for every item, in other processes where there are some.
    """
    failures: list[str] = []
    with spared("figures", failures):
        write_figures(folder, failures=failures, each=each)
    with spared("the page", failures):
        write_page(folder, each=each)
    return failures


def remake(folder: Path) -> list[str]:
    """Write figures and page of a result folder again, whole. Returns sentences on figures that could not be drawn.

    Raises:
        InputError: where the folder holds no result table, a file of it is damaged, or it takes no files; nothing is
            written then.
    """
    settle(folder)
    read_folder(folder)  # before anything is made there
    check_writable(folder, "report")
    failures: list[str] = []
    with written_whole(folder, keeps=RESULTS) as part:
        write_figures(folder, part, failures)
        write_page(folder, part)
    return failures
