"""What people see of a result folder: figures for papers and one page that opens offline."""

from harness.report.curves import write_curves
from harness.report.figures import write_figures
from harness.report.page import write_page

__all__ = ["write_curves", "write_figures", "write_page"]
