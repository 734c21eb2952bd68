"""Named pipes, with which tests detect that all processes with an open end have ended."""

from __future__ import annotations

import select
from io import BufferedReader


def read_to_end(pipe: BufferedReader, within: float = 20.0) -> bytes:
    """Return the bytes written into a pipe until no process holds its other end.

    `within` [s]: longest wait for the next bytes; then a process was left behind, and this fails.
    """
    said = b""
    while select.select([pipe], [], [], within)[0]:
        part = pipe.read1()
        if not part:
            return said
        said += part
    raise AssertionError(f"a process still holds the other end of {pipe.name} after {within:g} s")
