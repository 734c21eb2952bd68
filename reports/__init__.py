"""Figures and the report, made only from stored results.

    >>> from ghostball.reports import write_report
    >>> write_report("out")
    PosixPath('out/report.html')

The page is one file for a browser; pictures are beside it in `figures/`. Importing this package
doesn't load matplotlib; the first figure does.
"""

from ghostball.reports import notebook  # noqa: F401  (registers the pictures for notebooks)
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

if not __name__.startswith("ghostball."):  # otherwise each class would exist twice
    raise ImportError(
        f"this package is part of ghostball: import `ghostball.{__name__}`, or "
        "`from ghostball import Scene, simulate`"
    )
