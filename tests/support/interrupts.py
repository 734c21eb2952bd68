"""Press Ctrl-C from inside a test."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def ctrl_c() -> Iterator[None]:
    """Send Ctrl-C to this process after 0.3 s, and again every 10 s until the block ends.

    Once isn't enough: Python drops a KeyboardInterrupt that a callback of the garbage collector
    raises, and Hypothesis has such a callback. The test would then never end.
    """
    ended = threading.Event()

    def press() -> None:
        wait = 0.3
        while not ended.wait(wait):
            os.kill(os.getpid(), signal.SIGINT)
            wait = 10.0

    presses = threading.Thread(target=press)
    presses.start()
    try:
        yield
    finally:
        ended.set()
        presses.join()
