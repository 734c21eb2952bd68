"""Process groups that ignore Ctrl-C from their start, and end with their parent process."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import wait as wait_for_any

FAILED = 1
"""Exit code of a process if its task raised an unexpected exception, or if its parent ended."""

_GUARD = "exec 3<&0; (read -r _ <&3; kill -KILL 0) &"
"""Shell command that waits until its standard input ends, then kills its own process group.

The command waits in a second process, so that the process that runs it has no child that never
ends: an engine may wait for all of its children.
"""


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Block Ctrl-C within the context; a Ctrl-C that arrives meanwhile takes effect at the end.

    A process that is started within the context inherits the block, so it ignores Ctrl-C from its
    first instruction, not only after it has imported its modules.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    # Starting the resource tracker unblocks Ctrl-C, so it must be running before the block.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def end_with_parent() -> None:
    """Make this process the leader of a process group that is killed when its parent ends.

    A shell kills the group, even while native code blocks all threads of this process. Without a
    shell, a thread ends this process only.
    """
    parent = multiprocessing.parent_process()
    assert parent is not None
    if hasattr(os, "setsid"):
        os.setsid()
        with suppress(FileNotFoundError):
            subprocess.run(
                ["/bin/sh", "-c", _GUARD],
                stdin=parent.sentinel,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                check=True,
            )
            return

    def watch() -> None:
        wait_for_any([parent.sentinel])
        os._exit(FAILED)

    threading.Thread(target=watch, daemon=True).start()
