"""Named pipes, which tell when all processes that hold one have ended."""

from __future__ import annotations

import select
from io import BufferedReader


def read_to_end(pipe: BufferedReader, within: float = 20.0) -> bytes:
    """Return what is written into a pipe until nobody holds its other end.

    `within` [s]: how long that may take after each part, so that what is left behind is a failure.
    """
    said = b""
    while select.select([pipe], [], [], within)[0]:
        part = pipe.read1()
        if not part:
            return said
        said += part
    raise AssertionError(f"a process still holds the other end of {pipe.name} after {within:g} s")
