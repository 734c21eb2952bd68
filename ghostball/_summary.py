"""What `ghostball report --summary` and `--text` do: say shortly what stored results came to."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import typer

from ghostball._terminal import check_writable
from ghostball.reports import add_summary, summary_markdown, summary_text, write_summary
from ghostball.validation.baselines import load_regression
from ghostball.validation.results.store import Results, has_results

STDOUT = Path("-")


def write(folder: Path, *, summary: Path | None, text: Path | None) -> None:
    """Write the summary of a results folder, with what changed where it holds a comparison.

    Raises
    ------
    GhostballError
        Where the folder holds neither, or a file can't be written.
    """
    for path, option in ((summary, "--summary"), (text, "--text")):
        if path not in (None, STDOUT):
            check_writable(path, option)
    regression = load_regression(folder) if folder.is_dir() else None
    # A comparison may lie in a folder of its own; what is no folder of ours says so as it is read.
    alone = regression is not None and not has_results(folder)
    results = None if alone else Results.open(folder)
    if summary is not None:
        _put(summary_markdown(results, regression), summary, add_summary)
    if text is not None:
        _put(summary_text(results, regression), text, write_summary)


def _put(text: str, path: Path, write: Callable[[str, Path], None]) -> None:
    if path == STDOUT:
        typer.echo(text, nl=False)
    else:
        write(text, path)
