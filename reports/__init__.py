"""Figures and the report, made from stored results alone.

    >>> from ghostball.reports import write_report
    >>> write_report("out")
    PosixPath('out/report.md')

`report.html` lies beside it, one file to be opened in a browser.
Importing this package loads no matplotlib: that waits for the first figure.
"""

from ghostball.reports.gallery_pictures import write_gallery
from ghostball.reports.guarded import FailedPart, IncompleteReportError, failed_text
from ghostball.reports.parting_figure import plot_explanation
from ghostball.reports.plot import plot_result
from ghostball.reports.report import PAGE, ReportError, write_report
from ghostball.reports.stress_report import write_stress_report
from ghostball.reports.style import EngineStyle, engine_style
from ghostball.reports.summary import add_summary, summary_markdown, summary_text, write_summary

__all__ = [
    "PAGE",
    "EngineStyle",
    "FailedPart",
    "IncompleteReportError",
    "ReportError",
    "add_summary",
    "engine_style",
    "failed_text",
    "plot_explanation",
    "plot_result",
    "summary_markdown",
    "summary_text",
    "write_gallery",
    "write_report",
    "write_stress_report",
    "write_summary",
]

if not __name__.startswith("ghostball."):  # else there were two of each class
    raise ImportError(
        f"this package is part of ghostball: import `ghostball.{__name__}`, or "
        "`from ghostball import Scene, simulate`"
    )
