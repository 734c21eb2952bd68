"""A part of a report that can't be made costs itself, not the report of minutes of results.

Each part is made by `attempt`, which keeps what went wrong: the part's place says so, and whoever
asked for the report gets all of it in an `IncompleteReportError`, after the rest is written.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar

from ghostball.model import GhostballError

T = TypeVar("T")

NAMED = 5
"""How many parts that could not be made a message names; the others are counted."""


class FailedPart(NamedTuple):
    """A part that could not be made, such as "figure stop-sheet": type and message, and where."""

    part: str
    error: str
    traceback: str


class IncompleteReportError(Exception):
    """A report was written, but for parts that `failed`: ghostball itself failed there."""

    def __init__(self, report: Path, failed: Sequence[FailedPart]) -> None:
        super().__init__(report, tuple(failed))
        self.report = report
        self.failed = tuple(failed)

    def __str__(self) -> str:
        return f"{self.report}: written, but {failed_text(self.failed)}"


def attempt(part: str, make: Callable[[], T], failed: list[FailedPart]) -> T | None:
    """Return what `make` returns; where it fails, note that in `failed`, and return None."""
    try:
        return make()
    except GhostballError:
        raise
    except Exception as error:
        said = " ".join(f"{type(error).__name__}: {error}".split())
        failed.append(FailedPart(part, said, "".join(traceback.format_exception(error)).rstrip()))
        return None


def failed_text(failed: Sequence[FailedPart]) -> str:
    """Return in one sentence which parts could not be made, and why, without its full stop."""
    count = "1 part" if len(failed) == 1 else f"{len(failed)} parts"
    named = [f"{one.part} ({one.error})" for one in failed[:NAMED]]
    more = [f"and {len(failed) - NAMED} more"] if len(failed) > NAMED else []
    return f"{count} of it could not be written: {', '.join(named + more)}"
