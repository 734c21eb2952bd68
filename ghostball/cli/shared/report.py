"""Write the report of a results folder, and print its results as `--format` asks."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import typer
from rich.markup import escape

from ghostball.cli.options import Format
from ghostball.cli.shared.progress import DRAWING, Steps
from ghostball.cli.shared.terminal import say
from ghostball.reports import (
    FailedPart,
    IncompleteReportError,
    failed_text,
    summary_markdown,
    summary_text,
    write_report,
)
from ghostball.reports.ci.findings import findings, notes
from ghostball.reports.ci.junit import junit_xml
from ghostball.reports.report import Pictures
from ghostball.validation.baselines import load_regressions
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.measured.table_agreement import TableAgreement
from ghostball.validation.results.store import Results
from ghostball.validation.results.tables import csv_of, rows_of
from ghostball.validation.suite.real_tables import load_agreements


@dataclass(frozen=True)
class WrittenReport:
    """A written report: its page, and the parts that failed because of a bug."""

    page: Path
    failed: tuple[FailedPart, ...] = ()

    def status(self) -> ExitStatus:
        """Return the exit status; if parts failed, print a warning that names them.

        Call it after all other messages, so that the warning is the last line.
        """
        if not self.failed:
            return ExitStatus.PASSED
        for traceback in dict.fromkeys(one.traceback for one in self.failed):
            say(escape(traceback))
        say(
            f"[bold red]warning:[/] the report was written, but "
            f"{escape(failed_text(self.failed))}. [bold red]ghostball itself failed there.[/] This "
            "is a bug: please report it with the lines above and the output of `ghostball engines "
            "--check`"
        )
        return ExitStatus.HARNESS_FAILED


def write(
    folder: Path, *, jobs: int, figures: Pictures, steps: Steps | None = None
) -> WrittenReport:
    """Write the report, with a progress bar.

    `steps`: the steps of the whole command, if drawing isn't the only one.
    """
    with (steps or Steps(DRAWING)).bar(DRAWING) as step:
        try:
            page = write_report(folder, progress=step(DRAWING), jobs=jobs, figures=figures)
        except IncompleteReportError as error:
            return WrittenReport(error.report, error.failed)
        return WrittenReport(page)


def print_for_programs(folder: Path, form: Format) -> None:
    """Print stored results in a format for programs; for "text", the command has printed tables."""
    if form is not Format.TEXT:
        typer.echo(printed(folder, form), nl=False)


def printed(folder: Path, form: Format) -> str:
    """Return stored results, and stored comparisons with baselines, in a format."""
    results, regressions = Results.open(folder), load_regressions(folder)
    if form is Format.MARKDOWN:
        return summary_markdown(results, *regressions)
    if form is Format.GITHUB:
        return notes(findings(results, regressions))
    if form is Format.TEXT:
        return summary_text(results, *regressions)
    if form is Format.JUNIT:
        return junit_xml(results.cases, regressions)
    if form is Format.CSV:
        return csv_of(rows_of(folder, "comparisons"))
    tables = {name: rows_of(folder, name) for name in ("cases", "comparisons", "checks", "metrics")}
    compared = [one.model_dump(mode="json", by_alias=True) for one in regressions]
    beside = [_json_values(one) for one in load_agreements(folder)]
    whole = {"state": results.state, **tables, "regressions": compared, "real_tables": beside}
    return json.dumps(whole) + "\n"


def _json_values(found: TableAgreement) -> dict[str, Any]:
    """Return the comparison of an engine with real tables as values for JSON."""
    families = []
    for one in found.families:
        graded = one.grades and not one.lacks
        off = {
            "typical": one.typical if graded else None,
            "most": one.most if graded else None,
            "typical_difference": None if one.lacks else one.typical_difference,
            "is_within_known": one.is_within_known,
        }
        families.append(one.model_dump(mode="json") | off)
    return {"label": found.label, "typical": found.typical, "families": families}
