"""What engines print: kept separate from our own output, and made harmless where it is shown.

An engine may print whatever it likes, also from C code that writes to file descriptor 1 itself.
None of that is a result, and a terminal would obey the control characters in it.
"""

from __future__ import annotations

import ctypes
import os
import re
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass
from typing import IO

KEPT = 2_000
"""Bytes that are kept of the start, and as many of the end, of what was printed."""

# All but tab and newline: C0 (ESC among them), DEL and C1, whose CSI is one character; what turns
# the direction of text or separates lines, marks without width, tags, halves of surrogate pairs.
_CONTROL = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200b\u200e\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb"
    "\ud800-\udfff\U000e0000-\U000e007f]"
)


def harmless(text: str) -> str:
    r"""Write control characters as Python escapes, such as \x1b; tabs and newlines stay.

    Control characters here are also those that show nothing and change how other text looks, such
    as U+202E, which reverses it. Letters that are written from right to left stay.

    For every text that isn't ours, such as a title, a ball's id or what an engine says, before it
    reaches a terminal.
    """
    return _CONTROL.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


@dataclass
class Output:
    """What was printed: "" until the block that it is of has ended."""

    text: str = ""


@contextmanager
def captured(*, errors: bool = False) -> Iterator[Output]:
    """Keep what is printed within the block, also by C code, from standard output.

    A process that the block forks ends with the block: see `end_if_forked`.

    `errors`: whether from standard error too; it must not be where our own messages or a progress
    bar are written there meanwhile, from a thread of theirs.
    """
    output, process = Output(), os.getpid()
    with tempfile.TemporaryFile(buffering=0) as file:
        try:
            with ExitStack() as diverted:
                writer = diverted.enter_context(_written(file.fileno()))
                diverted.enter_context(_diverted(1, file))
                diverted.enter_context(redirect_stdout(writer))
                if errors:
                    diverted.enter_context(_diverted(2, file))
                    diverted.enter_context(redirect_stderr(writer))
                try:
                    yield output
                finally:
                    end_if_forked(process)
        finally:
            output.text = text_of(file)


def end_if_forked(process: int) -> None:
    """End this process if it isn't `process`: an engine forked it and let it return to its caller.

    It must not continue as a second harness, which would answer, print and store everything twice.
    """
    if os.getpid() != process:
        os._exit(0)


@contextmanager
def _diverted(descriptor: int, file: IO[bytes]) -> Iterator[None]:
    flush()
    try:
        before = os.dup(descriptor)
    except OSError:  # it is closed: who writes there fails, as without us
        yield
        return
    os.dup2(file.fileno(), descriptor)
    try:
        yield
    finally:
        flush()
        os.dup2(before, descriptor)
        os.close(before)


def divert(path: str) -> None:
    """Have all that this process prints from now on go to the end of a file that another one reads.

    Its name goes at once, where the system allows that: so no file is left by whoever is killed.
    """
    file = os.open(path, os.O_WRONLY | os.O_APPEND)
    with suppress(OSError):
        os.unlink(path)
    for descriptor in (1, 2):
        os.dup2(file, descriptor)
    os.close(file)
    sys.stdout, sys.stderr = _written(1), _written(2)


def flush() -> None:
    """Write out what is buffered of standard output and error, also by C code."""
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            with suppress(ValueError):  # it was closed
                stream.flush()
    with suppress(OSError, AttributeError, TypeError):  # no C library to be had, as on Windows
        ctypes.CDLL(None).fflush(None)


def text_of(file: IO[bytes]) -> str:
    """Return what was printed into a file: its start and its end, where it is long."""
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    if size <= 2 * KEPT:
        parts = [file.read()]
    else:
        first = file.read(KEPT)
        file.seek(-KEPT, os.SEEK_END)
        parts = [first, f"\n[{size - 2 * KEPT} bytes left out]\n".encode(), file.read()]
    text = b"".join(parts).decode("utf-8", errors="backslashreplace")
    return text.replace("\r\n", "\n").strip("\n")


def _written(descriptor: int) -> IO[str]:
    # A line at a time, so that little is lost where the process crashes.
    return open(
        descriptor, "w", buffering=1, encoding="utf-8", errors="backslashreplace", closefd=False
    )
