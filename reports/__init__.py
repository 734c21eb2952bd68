"""Figures and the report, made from stored results alone.

    >>> from ghostball.reports import write_report
    >>> write_report("out")
    PosixPath('out/report.html')

The page is one file, to be opened in a browser; pictures lie beside it in `figures/`.
Importing this package loads no matplotlib: that waits for the first figure.
"""

from ghostball.reports import notebook  # noqa: F401  (it registers what a notebook shows)
from ghostball.reports.ci.summary import summary_markdown, summary_text
from ghostball.reports.failed_parts import FailedPart, IncompleteReportError, failed_text
from ghostball.reports.parting_figure import plot_explanation
from ghostball.reports.plot import plot_result
from ghostball.reports.report import PAGE, write_report

__all__ = [
    "PAGE",
    "FailedPart",
    "IncompleteReportError",
    "failed_text",
    "plot_explanation",
    "plot_result",
    "summary_markdown",
    "summary_text",
    "write_report",
]

if not __name__.startswith("ghostball."):  # else there were two of each class
    raise ImportError(
        f"this package is part of ghostball: import `ghostball.{__name__}`, or "
        "`from ghostball import Scene, simulate`"
    )
