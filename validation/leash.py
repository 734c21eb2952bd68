"""Processes that end with who started them, and with all that they started themselves.

Who starts one holds the other end of its standard input. However that process ends, be it killed,
the input closes, and then the one on the leash ends its whole group.
"""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress

OUT_OF_HAND = 1
"""Exit status of a process whose input closed, where it is no group of its own to be killed."""

COMMAND = """\
from validation.leash import end_with_input

end_with_input()
{first}
from ghostball.cli import main

main()
"""
"""What Python runs for a command line of ours on a leash, after what is to be done `first`."""


def end_with_input() -> None:
    """End this process and its group once its standard input closes; called within it."""
    threading.Thread(target=_wait_for_end, daemon=True).start()


def _wait_for_end() -> None:
    # Not `sys.stdin`, whose lock the interpreter couldn't get at its own end.
    while os.read(0, 4096):
        pass
    if hasattr(os, "killpg") and os.getpgrp() == os.getpid():
        os.killpg(0, signal.SIGKILL)  # the stopped and the deaf as well
    os._exit(OUT_OF_HAND)


@contextmanager
def leashed(
    command: Sequence[str], environment: Mapping[str, str] | None = None
) -> Iterator[subprocess.Popen[str]]:
    """Run a command that calls `end_with_input`; what is left of its group ends with the block.

    Parameters
    ----------
    command : sequence of str
    environment : mapping, optional
        This process's where it is left out.

    Yields
    ------
    subprocess.Popen
        Its output and its messages are pipes.
    """
    # Not `stdin=PIPE`, which `communicate` closes at once.
    theirs, ours = os.pipe()
    try:
        try:
            process = subprocess.Popen(
                command,
                env=environment,
                stdin=theirs,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                start_new_session=True,
            )
        finally:
            os.close(theirs)
        try:
            yield process
        finally:
            end_group(process)
            for stream in (process.stdout, process.stderr):
                if stream is not None:
                    stream.close()
    finally:
        os.close(ours)


def end_group(process: subprocess.Popen[str]) -> None:
    """Kill a process that leads a group, and all that still runs of that group."""
    # Who was waited for has given its number back: it may be another's by now.
    if process.returncode is None:
        if hasattr(os, "killpg"):
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
        process.wait()
