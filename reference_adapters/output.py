"""Capture what engines print, separately from Ghostball's output, and escape it for display.

An engine may print anything, even from C code that writes to file descriptor 1. The text isn't a
result, and a terminal would interpret its control characters.
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

KEPT_BYTES = 2_000
"""Number of bytes that are kept from the start of the output, and from its end."""

# All control characters except tab and newline: C0 (with ESC), DEL and C1 (with the one-character
# CSI); characters that change the direction of text or separate lines; zero-width marks; tags;
# halves of surrogate pairs.
_CONTROL = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200b\u200e\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb"
    "\ud800-\udfff\U000e0000-\U000e007f]"
)


def harmless(text: str) -> str:
    r"""Return text with control characters replaced by Python escapes, such as \x1b.

    Tabs and newlines stay. Invisible characters that change the display of other text, such as
    U+202E, which reverses text, are also replaced. Letters of right-to-left scripts stay.

    Applied to every external text, such as a title, the id of a ball or a message of an engine,
    before it reaches a terminal.
    """
    return _CONTROL.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


@dataclass
class Output:
    """Captured output: "" until the capturing block has ended."""

    text: str = ""


@contextmanager
def captured(*, errors: bool = False) -> Iterator[Output]:
    """Capture what is printed to standard output within the block, also by C code.

    A process that the block forks ends with the block: see `end_if_forked`.

    `errors`: whether to capture standard error too. This must be False while a different thread
        writes Ghostball's messages or a progress bar to standard error.
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

    The copy must not continue, because it would answer, print and store everything twice.
    """
    if os.getpid() != process:
        os._exit(0)


@contextmanager
def _diverted(descriptor: int, file: IO[bytes]) -> Iterator[None]:
    flush()
    try:
        before = os.dup(descriptor)
    except OSError:  # the descriptor is closed, so writing fails, as without capturing
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
    """Redirect what this process prints to the end of a file, which a different process reads.

    The name of the file is removed at once, where the system allows it, so that a killed process
    leaves no file.
    """
    file = os.open(path, os.O_WRONLY | os.O_APPEND)
    with suppress(OSError):
        os.unlink(path)
    for descriptor in (1, 2):
        os.dup2(file, descriptor)
    os.close(file)
    sys.stdout, sys.stderr = _written(1), _written(2)


def flush() -> None:
    """Write out the buffers of standard output and error, also those of C code."""
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            with suppress(ValueError):  # the stream is closed
                stream.flush()
    with suppress(OSError, AttributeError, TypeError):  # no C library, as on Windows
        ctypes.CDLL(None).fflush(None)


def text_of(file: IO[bytes]) -> str:
    """Return the text that was printed into a file; of a long text, only the start and the end."""
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    if size <= 2 * KEPT_BYTES:
        parts = [file.read()]
    else:
        first = file.read(KEPT_BYTES)
        file.seek(-KEPT_BYTES, os.SEEK_END)
        parts = [first, f"\n[{size - 2 * KEPT_BYTES} bytes omitted]\n".encode(), file.read()]
    text = b"".join(parts).decode("utf-8", errors="backslashreplace")
    return text.replace("\r\n", "\n").strip("\n")


def _written(descriptor: int) -> IO[str]:
    # Line buffering, so that little is lost if the process crashes.
    return open(
        descriptor, "w", buffering=1, encoding="utf-8", errors="backslashreplace", closefd=False
    )
