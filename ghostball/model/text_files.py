"""Read files of users, and write files whole.

Named pipes are rejected, byte-order marks are removed, and no file is written in part.
"""

from __future__ import annotations

import errno
import os
import stat
from contextlib import suppress
from pathlib import Path
from uuid import uuid4

_DESCRIPTORS = ("/dev/fd/", "/dev/stdin", "/proc/self/fd/")
"""Path prefixes of files that this process has open, such as a shell's `<(command)`."""


def read_bytes(path: Path, most: int = -1) -> bytes:
    """Return the content of a file, or its first `most` bytes.

    A named pipe is rejected, because reading it would wait until somebody writes to it. A pipe that
    this process has open (`/dev/fd/63`) is read to its end, and so is a terminal.

    Raises `OSError` if the file can't be read; `ValueError` if no file can have such a path.
    """
    with open(path, "rb", opener=_open_without_waiting) as file:
        is_pipe = stat.S_ISFIFO(os.fstat(file.fileno()).st_mode)
        if is_pipe and not str(path).startswith(_DESCRIPTORS):
            raise OSError(errno.EINVAL, "it is a named pipe and must be a file", str(path))
        if hasattr(os, "O_NONBLOCK"):
            os.set_blocking(file.fileno(), True)  # otherwise reading a terminal returns None
        return file.read(most)


def read_text(path: Path) -> str:
    r"""Return the content of a UTF-8 text file, without a byte-order mark, with "\n" at line ends.

    Raises `OSError` as `read_bytes`; `UnicodeDecodeError` if the file isn't UTF-8.
    """
    text = read_bytes(path).decode("utf-8-sig")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file, text as UTF-8; other processes see the old file or the complete new one.

    The content is first written to a new file next to `path`. If writing fails, that file is
    removed.

    Raises `OSError` if the file can't be written; `ValueError` if no file can have such a path or
    text.
    """
    data = content.encode("utf-8") if isinstance(content, str) else content
    temporary = temporary_path(path)
    try:
        temporary.write_bytes(data)
        temporary.replace(path)
    except BaseException:
        with suppress(OSError, ValueError):  # the first error is raised
            temporary.unlink(missing_ok=True)
        raise


def temporary_path(path: Path) -> Path:
    """Return the path of a new file next to `path`, for content that isn't complete.

    Its name is unique, because several processes may write the same file.

    Raises `ValueError` if `path` has no name.
    """
    start = path.name[:40]  # a name of the largest permitted length can't be extended
    return path.with_name(f"{start}.{uuid4().hex}.part")


def _open_without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
