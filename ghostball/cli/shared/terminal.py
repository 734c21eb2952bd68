"""The terminal: consoles for results and messages, and exit statuses of errors.

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
"""Columns of a log or a pipe if `COLUMNS` isn't set; rich's default is 80."""

DISK_ERRORS = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EIO})
"""Error numbers of a full or failing disk; these errors aren't bugs of Ghostball."""


@contextmanager
def in_a_command() -> Iterator[None]:
    """Turn an exception in the block, except typer's own, into an exit status: a `typer.Exit`.

    For an error that the user can correct, only the message is printed. Any other error is a bug in
    Ghostball, and is printed with its traceback. Both go to stderr.
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
    """Return `function` as a command that ends with an exit status; see `in_a_command`."""
    return in_a_command()(function)


@contextmanager
def _written_at_the_end() -> Iterator[None]:
    """Flush stdout when the block ends, so that a write error is raised inside the command.

    Python flushes at exit, too, but an error there has Python's own message and exit status.
    """
    try:
        yield
    finally:
        try:
            sys.stdout.flush()
        except OSError:
            # The buffered output can't be written at exit either: discard it.
            with suppress(OSError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise


def stdout() -> Console:
    """Return the console for results."""
    return _console(stderr=False)


def tables(form: str) -> Console:
    """Return the console for tables: stdout for the format "text", else stderr.

    With any other format, stdout must contain only that format.
    """
    return stdout() if form == "text" else stderr()


@functools.cache
def stderr() -> Console:
    """Return the only console for messages; a progress bar must know everything printed on it."""
    return _console(stderr=True)


def say(message: str) -> None:
    """Print a message, which may contain rich's markup, on stderr."""
    stderr().print(message, soft_wrap=True)


def say_printed(engine: str, text: str) -> None:
    """Show on stderr what an engine printed; each line starts with the name of the engine."""
    for line in harmless(text).splitlines():
        say(f"[dim]{escape(f'engine {engine} printed:')}[/] {escape(line)}")


@contextmanager
def busy(message: str) -> Iterator[None]:
    """Show a spinner beside `message` while the block runs; nothing without a terminal."""
    with stderr().status(Text(message)):  # `Text`, because brackets in a message aren't markup
        yield


class _SafeConsole(Console):
    """A console that prints the control characters of a text as visible characters."""

    def on_broken_pipe(self) -> None:
        """Raise the error again for `in_a_command`; rich would exit with status 1."""
        raise  # noqa: PLE0704 - rich calls this method while it handles the error

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterator[Segment]:
        for text, style, control in super().render(renderable, options):
            # rich marks its own control sequences with `control`.
            yield Segment(text if control else harmless(text), style, control)


def _console(*, stderr: bool) -> Console:
    file = None
    if stderr and sys.stderr is sys.__stderr__ and sys.stderr is not None:
        # A duplicate of descriptor 2: while an engine runs, what it prints to descriptor 2 is
        # captured, and messages and the bar must not be.
        with suppress(OSError):
            file = open(  # noqa: SIM115 - until the process ends
                os.dup(sys.stderr.fileno()),
                "w",
                encoding=sys.stderr.encoding,
                errors=sys.stderr.errors,
                buffering=1,
            )
    console = _SafeConsole(file=file, stderr=stderr, highlight=False, emoji=False)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = WIDTH_WITHOUT_TERMINAL
    return console


def _explain(error: Exception) -> ExitStatus:
    """Print an error, and return the exit status."""
    # Imported here, because a command without an error doesn't need it.
    from ghostball.reference_adapters import engine_names  # noqa: PLC0415
    from ghostball.validation.parallel.cluster import ClusterLostError  # noqa: PLC0415

    if isinstance(error, EngineFailedError):
        if error.is_our_bug:
            return _our_bug(error.trace, error.reason)
        if error.trace:
            say(escape(error.trace.rstrip()))
        advice = ""  # for the user's own engine
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
    """Handler that prints log records on stderr, above a progress bar."""

    def emit(self, record: logging.LogRecord) -> None:
        say(escape(record.getMessage()))


@contextmanager
def _modules_here() -> Iterator[None]:
    """Put the working directory at the end of the import path, for engines such as `my_engine`."""
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
    """Show log messages of the packages on stderr, for example that kernels are being compiled."""
    logger = logging.getLogger("ghostball")
    handler = _ShownOnStderr(logging.WARNING)
    propagate, logger.propagate = logger.propagate, False
    logger.addHandler(handler)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.propagate = propagate
