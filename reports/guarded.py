"""What becomes of a part of a report that can't be made: it costs itself, and is not passed over.

A section of the page that raises must not cost minutes of results their report. So each part is
made by `attempt`, which keeps what went wrong: the part's place says so, and whoever asked for the
report gets all of it in an `IncompleteReportError`, after the rest is written.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from ghostball.engine import GhostballError

T = TypeVar("T")

NAMED = 5
"""How many parts that could not be made a message names; the others are counted."""


@dataclass(frozen=True)
class FailedPart:
    """A part of a report that could not be made.

    Attributes
    ----------
    part : str
        What it is, such as "section Environment of report.html".
    error : str
        Type and message of what was raised, in one line.
    traceback : str
    """

    part: str
    error: str
    traceback: str

    @property
    def sentence(self) -> str:
        """What stands in the place of the part, without markup."""
        return (
            f"The {self.part} could not be made: {self.error}. This is a bug of ghostball and says "
            "nothing of the results: please report it."
        )


class IncompleteReportError(Exception):
    """A report was written, but for parts that could not be made: ghostball itself failed there.

    Attributes
    ----------
    report : Path
        What was written.
    failed : tuple of FailedPart
    """

    def __init__(self, report: Path, failed: Sequence[FailedPart]) -> None:
        super().__init__(report, tuple(failed))
        self.report = report
        self.failed = tuple(failed)

    def __str__(self) -> str:
        return f"{self.report}: written, but {failed_text(self.failed)}"


def attempt(
    part: str, make: Callable[[], T], failed: list[FailedPart], *, writes: bool = False
) -> T | None:
    """Return what `make` returns; where it fails, note that in `failed`, and return None.

    Parameters
    ----------
    part : str
        What is made, as a message names it after "the".
    make : callable
    failed : list of FailedPart, appended to
    writes : bool
        Whether `make` writes files. Elsewhere an OSError is a fault of ghostball too: a template
        or a style sheet that is missing from the installation.

    Raises
    ------
    GhostballError
        What whoever asked can mend, such as damaged results, is no fault of a part.
    OSError
        Where `make` writes files: a full disk is no fault of a part either.
    """
    try:
        return make()
    except GhostballError:
        raise
    except Exception as error:
        if writes and isinstance(error, OSError):
            raise
        said = " ".join(f"{type(error).__name__}: {error}".split())
        lines = "".join(traceback.format_exception(error)).rstrip()
        failed.append(FailedPart(part, said, lines))
        return None


def failed_text(failed: Sequence[FailedPart]) -> str:
    """Return in one sentence which parts could not be made, and why, without its full stop."""
    count = "1 part" if len(failed) == 1 else f"{len(failed)} parts"
    named = [f"{one.part} ({one.error})" for one in failed[:NAMED]]
    more = [f"and {len(failed) - NAMED} more"] if len(failed) > NAMED else []
    return f"{count} of it could not be made: {', '.join(named + more)}"
