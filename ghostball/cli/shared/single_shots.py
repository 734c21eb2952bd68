"""Code of `run`, `explain`, `fit` and `engines --steps`: engine processes and output files."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path

import typer
from rich.markup import escape

from ghostball.cli.options import processor_count
from ghostball.cli.shared.progress import COMPILING, counting
from ghostball.cli.shared.terminal import say, say_printed
from ghostball.model import GhostballError, Result, Scene
from ghostball.reference_adapters import ReferenceEngine
from ghostball.reports.plot import ENDINGS, FILMS
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.parallel.compiling import compile_kernels, needed_kernels
from ghostball.validation.runs.engine_runs import in_other_process
from ghostball.validation.runs.runner import check_limits


@contextmanager
def engine_process(engine: ReferenceEngine, time_limit: float) -> Iterator[ReferenceEngine]:
    """Yield the engine in a process of its own.

    What the engine prints is shown on stderr; repeated text is shown once.

    `time_limit` [s]: time limit for each shot; must be positive, for Ghostball's engine, too.
    """
    check_limits(1, time_limit)
    said_once = cache(partial(say_printed, engine.name))
    with in_other_process(engine, time_limit, said_once) as found:
        yield found


def compile_first(scenes: Sequence[Scene], label: str) -> None:
    """Compile the missing kernels of an engine's adapter and of Ghostball's engine, with a bar.

    An engine in another process would compile its kernels there, without a bar.

    `scenes`: scenes for Ghostball's engine; empty if only the adapter's kernels are needed.
    """
    if not all(one.is_made for one in needed_kernels(scenes, [label])):
        with counting(COMPILING) as count:
            compile_kernels(scenes, processor_count(), labels=[label], compiling=count)


def status_of(result: Result, engine: str) -> ExitStatus:
    """Return the exit status of a shot; if the engine did not finish, print why."""
    if result.status.complete:
        return ExitStatus.PASSED
    why = f"{result.status.value}{f': {result.reason}' if result.reason else ''}"
    say(f"[bold red]engine {escape(engine)} did not finish:[/] {escape(why)}")
    return ExitStatus.CHECK_FAILED


def check_plot(path: Path | None, *, films: bool = False) -> None:
    """Raise an error if a picture can't be written.

    `films`: whether films are allowed.

    Raises `typer.BadParameter` if the file name has a wrong ending, `GhostballError` if the file
    can't be written. Called before the run, so that no run is wasted.
    """
    if path is None:
        return
    endings = ENDINGS + FILMS if films else ENDINGS
    if path.suffix.lower() not in endings:
        raise typer.BadParameter(
            f"must end in {', '.join(endings)}, got {path.name!r}", param_hint="--plot"
        )
    check_writable(path, "--plot")


def check_writable(path: Path, option: str) -> None:
    """Raise `GhostballError` if a file can't be written; called before the run."""
    try:
        if path.is_dir():
            raise IsADirectoryError(None, "is a folder")
        with tempfile.NamedTemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise GhostballError(
            f"{path}: can't write the file of `{option}`: {reason}. Choose another path"
        ) from None
