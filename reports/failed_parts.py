"""Write a report even if a bug prevents some of its parts.

`attempt` makes each part. If a part fails, the report says so in its place, and after the report is
written, `IncompleteReportError` names all failed parts.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar

from ghostball.model import GhostballError

T = TypeVar("T")

NAMED = 5
"""Number of failed parts that a message names; the rest are counted."""


class FailedPart(NamedTuple):
    """A part that failed, such as "figure stop-sheet", with the error and its traceback."""

    part: str
    error: str
    traceback: str


class IncompleteReportError(Exception):
    """A report was written without the parts in `failed`, because of a bug in Ghostball."""

    def __init__(self, report: Path, failed: Sequence[FailedPart]) -> None:
        super().__init__(report, tuple(failed))
        self.report = report
        self.failed = tuple(failed)

    def __str__(self) -> str:
        return f"{self.report}: written, but {failed_text(self.failed)}"


def attempt(part: str, make: Callable[[], T], failed: list[FailedPart]) -> T | None:
    """Return the result of `make`; if it raises an error, add it to `failed` and return None.

    A `GhostballError`, whose cause the user can fix, is raised again.
    """
    try:
        return make()
    except GhostballError:
        raise
    except Exception as error:
        said = " ".join(f"{type(error).__name__}: {error}".split())
        failed.append(FailedPart(part, said, "".join(traceback.format_exception(error)).rstrip()))
        return None


def failed_text(failed: Sequence[FailedPart]) -> str:
    """Return a sentence, without a full stop, with the failed parts and their errors."""
    count = "1 part" if len(failed) == 1 else f"{len(failed)} parts"
    named = [f"{one.part} ({one.error})" for one in failed[:NAMED]]
    more = [f"and {len(failed) - NAMED} more"] if len(failed) > NAMED else []
    return f"{count} of it could not be written: {', '.join(named + more)}"
