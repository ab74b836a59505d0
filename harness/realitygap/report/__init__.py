"""What people see of a result folder: figures for papers and one page that opens offline."""

from realitygap.report.curves import write_curves
from realitygap.report.figures import write_figures
from realitygap.report.page import write_page

__all__ = ["write_curves", "write_figures", "write_page"]
