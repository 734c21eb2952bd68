"""What `ghostball report` and `ghostball export` do: show what an earlier run stored."""

from __future__ import annotations

from pathlib import Path

import typer

from ghostball.cli.shared import report as reports
from ghostball.cli.shared.options import FigureChoice, Format, refuse_given
from ghostball.cli.shared.summary import printed
from ghostball.model import GhostballError
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results import frames
from ghostball.validation.results.store import Results
from ghostball.validation.stress.tally import are_stress


def report(
    context: typer.Context,
    folder: Path,
    jobs: int,
    figures: FigureChoice,
    opened: bool,
    form: Format | None,
) -> ExitStatus:
    """Write the page, or print what the results came to."""
    if form is not None:
        why = "`--format` prints results, and writes no report"
        refuse_given(context, why, "opened", "figures", "jobs")
        typer.echo(printed(folder, form), nl=False)
        return ExitStatus.PASSED
    if are_stress(Results.open(folder).cases):
        raise GhostballError(
            f"{folder}: holds a run of `ghostball stress`, which is a section of the report of the "
            f"folder that it lies in: `ghostball validate --out {folder.parent}`, then `ghostball "
            f"report {folder.parent}`"
        )
    written = reports.write(folder, jobs=jobs, figures=figures.value)
    typer.echo(written.page)
    if opened:
        typer.launch(written.page.resolve().as_uri())
    return written.status()


def export(folder: Path, out: Path | None) -> None:
    """Write all tables of a results folder as files."""
    for path in frames.export(folder, folder / "export" if out is None else out):
        typer.echo(path)
