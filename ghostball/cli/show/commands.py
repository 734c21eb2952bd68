"""The commands that show what is there, and write files to begin from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ghostball.cli.shared.options import (
    AUTO,
    FigureChoice,
    Figures,
    Format,
    Jobs,
    Plain,
    PlainFormat,
    complete_scene,
    refuse_given,
)
from ghostball.cli.shared.terminal import command, say, stdout
from ghostball.validation.exit_status import ExitStatus

app = typer.Typer()


@app.command()
@command
def report(
    context: typer.Context,
    folder: Annotated[
        Path,
        typer.Argument(metavar="DIR", help="A folder that `validate` or `regress` wrote."),
    ],
    jobs: Jobs = AUTO,
    figures: Figures = FigureChoice.PNG,
    opened: Annotated[bool, typer.Option("--open", help="Show the page in the browser.")] = False,
    form: Annotated[
        Format | None,
        typer.Option(
            "--format",
            metavar="text|json|junit|github",
            help="Instead, print what the results came to, as of `validate` and `regress`.",
        ),
    ] = None,
) -> None:
    """Write the report of a run again, or print what it came to.

    Runs of `stress` within the folder are a section of it.
    """
    if form is not None:
        why = "`--format` prints results, and writes no report"
        refuse_given(context, why, "opened", "figures", "jobs")
        from ghostball.cli.shared.summary import printed  # noqa: PLC0415

        typer.echo(printed(folder, form), nl=False)
        return
    from ghostball.cli.shared.report import write  # noqa: PLC0415
    from ghostball.validation.results.database import documents_in  # noqa: PLC0415

    if documents_in(folder) == {"stress"}:
        from ghostball.model import GhostballError  # noqa: PLC0415

        raise GhostballError(
            f"{folder}: holds a run of `ghostball stress`, which is a section of the report of the "
            f"folder that it lies in: `ghostball validate --out {folder.parent}`, then `ghostball "
            f"report {folder.parent}`"
        )
    written = write(folder, jobs=jobs, figures=figures.value)
    typer.echo(written.page)
    if opened:
        typer.launch(written.page.resolve().as_uri())
    raise typer.Exit(written.status())


@app.command()
@command
def export(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of a run, of any command that has --out.")
    ],
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder of the files (default: DIR/export)."),
    ] = None,
) -> None:
    """Write the results of a run as JSON lines and CSV.

    There is a file for each table, such as cases, checks, metrics and events.
    `Results.open(DIR).to_frame()` gives Python the same tables as data frames.
    """
    from ghostball.validation.results.frames import export as write  # noqa: PLC0415

    for path in write(folder, folder / "export" if out is None else out):
        typer.echo(path)


@app.command()
@command
def scenes(
    wanted: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="NAME|TAG",
            help="Only these: names, tags or files, as for `validate` (default: all that are "
            "shipped).",
            autocompletion=complete_scene,
        ),
    ] = None,
    schema: Annotated[
        bool, typer.Option("--schema", help="Print the JSON schema of scene files instead.")
    ] = False,
    export: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Write them there as JSON, for engines of any language."),
    ] = None,
    form: PlainFormat = Plain.TEXT,
) -> None:
    """List the shipped scenes; of a single one, show its file."""
    if export is not None:
        from ghostball.cli.measure.elsewhere import export_scenes  # noqa: PLC0415

        raise typer.Exit(export_scenes(export, wanted or []))
    if schema:
        from ghostball.model.scene import json_schema  # noqa: PLC0415

        typer.echo(json_schema())
        return
    from ghostball.cli.shared import tables  # noqa: PLC0415
    from ghostball.validation.scenes.library import select  # noqa: PLC0415

    found = select(wanted or [])
    if form is Plain.JSON:
        typer.echo(tables.scenes_json(found))
    elif wanted and len(found) == 1:
        typer.echo(tables.scene_text(found[0]), nl=False)
    else:
        stdout().print(tables.scenes_table(found))


@app.command()
@command
def engines(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="ENGINE", help="Say all of these (default: a line of each)."),
    ] = None,
) -> None:
    """List the engines; of those that are named, their settings and what each represents."""
    from ghostball.cli.shared.tables import engine_blocks, engines_table  # noqa: PLC0415

    if not names:
        stdout().print(engines_table())
    for block in engine_blocks(names or ()):
        stdout().print(block)


@app.command()
@command
def metrics(form: PlainFormat = Plain.TEXT) -> None:
    """List the metrics, which limits and --metric name."""
    from ghostball.cli.shared import tables  # noqa: PLC0415

    if form is Plain.JSON:
        typer.echo(tables.metrics_json())
    else:
        stdout().print(tables.metrics_table())


@app.command()
@command
def init(
    engine: Annotated[
        str | None,
        typer.Option(
            "--engine",
            "-e",
            metavar="ENGINE",
            help="Your engine, such as my_package:MyEngine (default: an example is written).",
        ),
    ] = None,
) -> None:
    """Begin a project: its settings, and an engine to begin from.

    The settings are [tool.ghostball] in pyproject.toml.

    Then `ghostball regress` and `ghostball accept --reason "..."` make the first gate.
    """
    from ghostball.cli.show.init import init as write  # noqa: PLC0415

    write(engine)


@app.command()
@command
def doctor() -> None:
    """Check the installation; exit status 1 where it is broken."""
    from ghostball.cli.show.doctor import examine  # noqa: PLC0415

    findings, healthy = examine()
    stdout().print(findings)
    if not healthy:
        say("[bold red]Something is broken;[/] see above.")
        raise typer.Exit(ExitStatus.CHECK_FAILED)
