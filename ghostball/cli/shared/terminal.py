"""The terminal: where messages go, and how errors end a command.

Results go to stdout, everything else (progress, warnings, errors) to stderr.
"""

from __future__ import annotations

import errno
import functools
import logging
import os
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import ParamSpec

import typer
from rich.console import Console, ConsoleOptions, RenderableType
from rich.markup import escape
from rich.segment import Segment
from rich.text import Text

from ghostball.model import EngineFailedError, GhostballError, UnsupportedSceneError
from ghostball.reference_adapters.output import harmless
from ghostball.validation.exit_status import ExitStatus

P = ParamSpec("P")

WIDTH_WITHOUT_TERMINAL = 160
"""Columns of a log or a pipe, where `COLUMNS` doesn't say; rich would take 80."""


DISK_ERRORS = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EIO})
"""What a full or failing disk answers to output that nobody else wrapped: no bug of ours."""


@contextmanager
def in_a_command() -> Iterator[None]:
    """Make a command end in an exit status, whatever happens in it.

    An error that the user can mend is its message alone; any other one is ours, and comes with its
    traceback. Both go to stderr.
    """
    try:
        with _logging_shown(), _modules_here(), _written_at_the_end():
            yield
    except (typer.Exit, typer.Abort, typer.BadParameter):
        raise
    except BrokenPipeError:
        raise typer.Exit(ExitStatus.OUTPUT_CLOSED) from None
    except KeyboardInterrupt:
        say("[bold]Interrupted.[/]")
        raise typer.Exit(ExitStatus.INTERRUPTED) from None
    except Exception as error:
        raise typer.Exit(_explain(error)) from None


def command(function: Callable[P, None]) -> Callable[P, None]:
    """Make a function of options a command, which ends in an exit status; see `in_a_command`."""
    return in_a_command()(function)


@contextmanager
def _written_at_the_end() -> Iterator[None]:
    """Write what is left for stdout as the block ends, so that its error is one of the block.

    Python itself would do so as the process ends, and fail in words and with a status of its own.
    """
    try:
        yield
    finally:
        try:
            sys.stdout.flush()
        except OSError:
            # What is left can't be written later either: it is given up here, not once more there.
            with suppress(OSError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise


def stdout() -> Console:
    """Return the console of results."""
    return _console(stderr=False)


def tables(form: str) -> Console:
    """Return the console of tables: stdout has room for nothing else where it isn't "text"."""
    return stdout() if form == "text" else stderr()


@functools.cache
def stderr() -> Console:
    """Return the one console of messages; a live display on it must know what else is printed."""
    return _console(stderr=True)


def say(message: str) -> None:
    """Print a message, which may hold rich's markup, on stderr."""
    stderr().print(message, soft_wrap=True)


def say_printed(engine: str, text: str) -> None:
    """Show on stderr what an engine printed, a line each with its name before."""
    for line in harmless(text).splitlines():
        say(f"[dim]{escape(f'engine {engine} printed:')}[/] {escape(line)}")


@contextmanager
def busy(message: str) -> Iterator[None]:
    """Show a turning wheel beside `message` while the block runs; nothing without a terminal."""
    with stderr().status(Text(message)):  # a message may hold brackets, which aren't markup
        yield


class _Harmless(Console):
    """A console that shows the control characters of a text instead of obeying them."""

    def on_broken_pipe(self) -> None:
        """Raise the error again, which a command answers; rich would exit with status 1."""
        raise  # noqa: PLE0704 - it is called where the error is handled

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterator[Segment]:
        for text, style, control in super().render(renderable, options):
            # What rich itself steers the terminal with says so.
            yield Segment(text if control else harmless(text), style, control)


def _console(*, stderr: bool) -> Console:
    file = None
    if stderr and sys.stderr is sys.__stderr__ and sys.stderr is not None:
        # A way of its own to where messages go: what engines print to descriptor 2 is diverted,
        # also while a bar is drawn.
        with suppress(OSError):
            file = open(  # noqa: SIM115 - until the process ends
                os.dup(sys.stderr.fileno()),
                "w",
                encoding=sys.stderr.encoding,
                errors=sys.stderr.errors,
                buffering=1,
            )
    console = _Harmless(file=file, stderr=stderr, highlight=False, emoji=False)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = WIDTH_WITHOUT_TERMINAL
    return console


def _explain(error: Exception) -> ExitStatus:
    """Print the error with its cause, and return the exit status."""
    # Imported only here: a command that goes well doesn't wait for it.
    from ghostball.reference_adapters import engine_names  # noqa: PLC0415
    from ghostball.validation.parallel.cluster import ClusterLostError  # noqa: PLC0415

    if isinstance(error, EngineFailedError):
        if error.is_our_bug:
            return _our_bug(error.trace, error.reason)
        if error.trace:
            say(escape(error.trace.rstrip()))
        advice = ""  # to an author, of an engine of his own
        if error.engine in engine_names():
            advice = ". Please report it to the maintainers of that engine"
            advice += ", with the lines above" * bool(error.trace)
        said = f"{error.reason.rstrip('.')}{advice}"
        say(f"[bold red]engine {escape(error.engine)} failed:[/] {escape(said)}")
        return ExitStatus.CHECK_FAILED
    if isinstance(error, GhostballError):
        unsupported = isinstance(error, UnsupportedSceneError)
        hint = ". `ghostball engines` lists what each engine supports" * unsupported
        say(f"[bold red]error:[/] {escape(str(error) + hint)}")
        lost = isinstance(error, ClusterLostError)  # no fault of the input or of Ghostball
        return ExitStatus.CHECK_FAILED if lost else ExitStatus.BAD_INPUT
    if isinstance(error, OSError) and error.errno in DISK_ERRORS:
        where = error.filename or "standard output"
        say(
            f"[bold red]error:[/] {escape(str(where))}: can't be written: "
            f"{escape(error.strerror or type(error).__name__)}. Write elsewhere, or make room"
        )
        return ExitStatus.HARNESS_FAILED
    return _our_bug("".join(traceback.format_exception(error)), f"{type(error).__name__}: {error}")


def _our_bug(trace: str, reason: str) -> ExitStatus:
    say(escape(trace.rstrip()))
    say(
        f"[bold red]ghostball itself failed:[/] {escape(reason)}. This is a bug: please report it "
        "with the lines above and the output of `ghostball engines --check`"
    )
    return ExitStatus.HARNESS_FAILED


class _ShownOnStderr(logging.Handler):
    """Prints log records above whatever live display is on."""

    def emit(self, record: logging.LogRecord) -> None:
        say(escape(record.getMessage()))


@contextmanager
def _modules_here() -> Iterator[None]:
    """Find modules in the working directory, such as `my_engine:simulate`, after all others."""
    here = str(Path.cwd())
    if here in sys.path:
        yield
        return
    sys.path.append(here)
    try:
        yield
    finally:
        sys.path.remove(here)


@contextmanager
def _logging_shown() -> Iterator[None]:
    """Show what the packages log, such as that kernels are being compiled."""
    logger = logging.getLogger("ghostball")
    handler = _ShownOnStderr(logging.WARNING)
    propagate, logger.propagate = logger.propagate, False
    logger.addHandler(handler)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.propagate = propagate
