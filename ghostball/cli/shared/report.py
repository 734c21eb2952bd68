"""Writing the report of a results folder, and saying what became of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rich.markup import escape

from ghostball.cli.shared.progress import DRAWING, Steps
from ghostball.cli.shared.terminal import say
from ghostball.reports import FailedPart, IncompleteReportError, failed_text, write_report
from ghostball.reports.report import Pictures
from ghostball.validation.exit_status import ExitStatus


@dataclass(frozen=True)
class Written:
    """A report that is written: its page, and what of it could not be made."""

    page: Path
    failed: tuple[FailedPart, ...] = ()

    def status(self) -> ExitStatus:
        """Return the exit status; where parts could not be made, say which, and that it is a bug.

        To be called once all else is said: the warning is what must be seen.
        """
        if not self.failed:
            return ExitStatus.PASSED
        for traceback in dict.fromkeys(one.traceback for one in self.failed):
            say(escape(traceback))
        say(
            f"[bold red]warning:[/] the report is written, but "
            f"{escape(failed_text(self.failed))}. [bold red]ghostball itself failed there.[/] This "
            "is a bug: please report it with the lines above and the output of `ghostball engines "
            "--check`"
        )
        return ExitStatus.HARNESS_FAILED


def write(folder: Path, *, jobs: int, figures: Pictures, steps: Steps | None = None) -> Written:
    """Write the report, with a bar that says how far it is: of all `steps`, or of this one."""
    with (steps or Steps(DRAWING)).bar(DRAWING) as step:
        try:
            return Written(write_report(folder, progress=step(DRAWING), jobs=jobs, figures=figures))
        except IncompleteReportError as error:
            return Written(error.report, error.failed)
