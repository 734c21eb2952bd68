"""The exit statuses of all commands."""

from __future__ import annotations

import enum


class ExitStatus(enum.IntEnum):
    """Exit status of a command."""

    PASSED = 0
    CHECK_FAILED = 1
    BAD_INPUT = 2
    HARNESS_FAILED = 3
    NOT_JUDGED = 4
    INTERRUPTED = 130  # 128 + SIGINT, as shells expect
    OUTPUT_CLOSED = 141  # 128 + SIGPIPE: the reader of the output, such as `head`, has stopped


def worst(*statuses: int) -> ExitStatus:
    """Return the exit status of a command from those of its parts: the most serious one."""
    found = set(map(ExitStatus, statuses))
    return next(status for status in _GRAVEST_FIRST if status in found)


_GRAVEST_FIRST = (
    ExitStatus.OUTPUT_CLOSED,
    ExitStatus.INTERRUPTED,
    ExitStatus.HARNESS_FAILED,
    ExitStatus.BAD_INPUT,
    ExitStatus.CHECK_FAILED,
    ExitStatus.NOT_JUDGED,
    ExitStatus.PASSED,
)
