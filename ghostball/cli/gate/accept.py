"""`ghostball accept`: store the results of the last run as baselines."""

from __future__ import annotations

from rich.markup import escape

from ghostball.cli.gate.commands import AcceptOptions
from ghostball.cli.gate.regress import labels_of
from ghostball.cli.shared.config import load_config
from ghostball.cli.shared.terminal import say, stdout
from ghostball.validation.baselines import (
    Acceptance,
    Gate,
    NothingToAcceptError,
    RefusedError,
    accept,
)
from ghostball.validation.exit_status import ExitStatus, worst


def run(asked: AcceptOptions) -> ExitStatus:
    """Write the baselines of each engine, print what was written, and return the exit status."""
    config = load_config()
    statuses: list[ExitStatus] = []
    nothing: NothingToAcceptError | None = None
    for label in labels_of(asked.engine, config):
        try:
            done = accept(
                asked.out or config.out,
                asked.reason,
                Gate.of(label, asked.baselines or config.baselines),
                only=asked.scenes or ["*"],
                even_though_limits_fail=asked.even_though_limits_fail,
            )
        except RefusedError as error:
            say(f"[bold red]error:[/] {escape(str(error))}")
            statuses.append(error.status)
        except NothingToAcceptError as error:  # other engines may have results to accept
            nothing = error
        else:
            _say_accepted(done)
            statuses.append(ExitStatus.CHECK_FAILED if done.unfinished else ExitStatus.PASSED)
    if not statuses and nothing is not None:
        raise nothing
    return worst(*statuses)


def _say_accepted(done: Acceptance) -> None:
    stdout().print(f"accepted: {escape(', '.join(done.written))}", soft_wrap=True)
    if done.left:
        say(f"also changed, not accepted: {escape(', '.join(done.left))}")
    for one in done.unfinished:
        say(f"[bold red]not accepted:[/] {escape(f'{one.scene}: {one.summary}')}")
    for one in done.broken:
        say(
            "[bold yellow]accepted, although limits fail:[/] "
            + escape(f"{one.scene}: {'; '.join(one.broken)}")
        )
    stdout().print(f"recorded in {done.changelog}", soft_wrap=True, markup=False)
