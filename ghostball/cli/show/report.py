"""`ghostball report`: write, print or export the results of an earlier run."""

from __future__ import annotations

from pathlib import Path

import typer

from ghostball.cli.shared.calls import refuse_given
from ghostball.cli.shared.report import printed, write
from ghostball.cli.show.commands import ReportOptions
from ghostball.model import GhostballError
from ghostball.reports.page.stress import FOLDER
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results import tables
from ghostball.validation.results.store import Results
from ghostball.validation.stress.tally import are_stress


def run(asked: ReportOptions) -> ExitStatus:
    """Write the report, print the results, or export their tables; return the exit status.

    Raises `typer.BadParameter` if options contradict each other, `GhostballError` if the folder
    holds a run of `stress` alone.
    """
    context, folder = asked.context, asked.folder
    if asked.export is not None:
        why = "`--export` writes the tables of results instead of a report"
        refuse_given(context, why, "opened", "figures", "jobs", "form")
        for path in tables.export(folder, asked.export):
            typer.echo(path)
        return ExitStatus.PASSED
    if asked.form is not None:
        why = "`--format` prints results instead of writing a report"
        refuse_given(context, why, "opened", "figures", "jobs")
        typer.echo(printed(folder, asked.form), nl=False)
        return ExitStatus.PASSED
    if are_stress(Results.open(folder).cases):
        raise GhostballError(_stress_advice(folder if folder.name else folder.resolve()))
    written = write(folder, jobs=asked.jobs, figures=asked.figures.value)
    typer.echo(written.page)
    if asked.opened:
        typer.launch(written.page.resolve().as_uri())
    return written.status()


def _stress_advice(folder: Path) -> str:
    """Return why a run of `ghostball stress` has no report of its own, and what to do instead."""
    why = (
        f"{folder}: holds only a run of `ghostball stress`. The report of a results folder OUT "
        "shows such a run as a section, if it lies in OUT/stress"
    )
    if folder.name == FOLDER:
        out = folder.parent
        return f"{why}. Run `ghostball validate --out {out}`, then `ghostball report {out}`"
    return (
        f"{why}. Move {folder} to OUT/stress, then run `ghostball report OUT`, or print its "
        f"results: `ghostball report {folder} --format text`"
    )
