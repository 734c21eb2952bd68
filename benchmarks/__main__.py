"""Measure speed and accuracy of Ghostball's engine: `python -m benchmarks COMMAND`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from benchmarks import (  # noqa: F401
    accuracy,
    board,
    breaks,
    doors,
    fits,
    made_balls,
    racks,
    rebounds,
    skips,
    speed,
    strokes,
    uneven,
)
from benchmarks.commands import app
from benchmarks.pictures.gallery import write_gallery
from ghostball.cli.shared.terminal import command


@app.command()
@command
def gallery(
    results: Annotated[Path, typer.Argument(metavar="DIR", help="Results of the full suite.")],
    out: Annotated[Path, typer.Argument(metavar="GALLERY", help="Folder of the pictures.")],
    sections: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Results for the pictures of the paper's section 6."),
    ] = None,
) -> None:
    """Draw the pictures of the README and the documentation."""
    for path in write_gallery(results, out, sections_dir=sections):
        typer.echo(path)


if __name__ == "__main__":
    app()
