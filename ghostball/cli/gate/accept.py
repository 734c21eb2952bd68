"""What `ghostball accept` does: keep what the last run found."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.markup import escape

from ghostball.cli.gate.regress import gates_of, labels_of
from ghostball.cli.shared.config import load_config
from ghostball.cli.shared.terminal import say, stdout
from ghostball.validation.baselines import (
    Acceptance,
    AcceptError,
    LimitsBrokenError,
    NotDeterministicError,
    NotFinishedError,
    NothingToAcceptError,
    UnjudgedError,
    accept,
)
from ghostball.validation.exit_status import ExitStatus, worst


def run(
    reason: str,
    scenes: Sequence[str] | None,
    engine: Sequence[str] | None,
    out: Path | None,
    baselines: Path | None,
    even_though_limits_fail: bool,
) -> ExitStatus:
    """Accept, say what was written, and return the exit status."""
    config = load_config()
    folder = config.baselines if baselines is None else baselines
    gates = gates_of(labels_of(engine or (), config), folder)
    statuses: list[ExitStatus] = []
    nothing: list[AcceptError] = []
    for gate in gates:
        try:
            done = accept(
                config.out if out is None else out,
                reason,
                only=scenes or ["*"],
                folder=gate.folder,
                engine=gate.engine,
                even_though_limits_fail=even_though_limits_fail,
            )
        except LimitsBrokenError as error:
            say(f"[bold red]error:[/] {escape(str(error))}, or use --even-though-limits-fail")
            statuses.append(ExitStatus.CHECK_FAILED)
        except UnjudgedError as error:
            say(f"[bold yellow]error:[/] {escape(str(error))}, or use --even-though-limits-fail")
            statuses.append(ExitStatus.NOT_JUDGED)
        except (NotDeterministicError, NotFinishedError) as error:
            say(f"[bold red]error:[/] {escape(str(error))}")
            statuses.append(ExitStatus.CHECK_FAILED)
        except NothingToAcceptError as error:
            nothing.append(error)
        else:
            _say_accepted(done)
            left_out = bool(done.unfinished)
            statuses.append(ExitStatus.CHECK_FAILED if left_out else ExitStatus.PASSED)
    if len(nothing) == len(gates):
        raise nothing[0]
    return worst(*statuses)


def _say_accepted(done: Acceptance) -> None:
    for words, names in (("accepted", done.written), ("removed", done.deleted)):
        if names:
            stdout().print(f"{words}: {escape(', '.join(names))}", soft_wrap=True)
    if done.left:
        say(f"also changed, not accepted: {escape(', '.join(done.left))}")
    for one in done.unfinished:
        say(f"[bold red]not accepted:[/] {escape(f'{one.scene}: {one.summary}')}")
    for one in done.broken:
        say(
            "[bold yellow]accepted, although limits fail:[/] "
            + escape(f"{one.scene}: {'; '.join(one.broken)}")
        )
    stdout().print(f"noted in {done.changelog}", soft_wrap=True, markup=False)
