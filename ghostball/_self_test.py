"""What `ghostball stress --self-test` does: plant bugs in our engine, show which are caught."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from rich import box
from rich.markup import escape
from rich.table import Table

from ghostball._progress import counting
from ghostball._terminal import ExitStatus, say, stdout
from validation.stress.self_test import TIME_LIMIT, Found, SelfTest, self_test


def run(only: Sequence[str], *, jobs: int, time_limit: float | None, as_json: bool) -> ExitStatus:
    """Run the self-test, print what was caught, and return the exit status."""
    with counting("mutants") as count:

        def progress(found: Found, done: int, planned: int) -> None:
            how = f"killed by {found.killed_by}" if found.killed else "survived"
            count(done, planned, f"{found.name}: {how}")

        limit = TIME_LIMIT if time_limit is None else time_limit
        outcome = self_test(jobs=jobs, only=only, progress=progress, time_limit=limit)
    if as_json:
        print(json.dumps(summary(outcome)))
    else:
        stdout().print(_table(outcome))
        stdout().print(_verdict(outcome))
    if outcome.interrupted:
        say("[bold]Interrupted.[/]")
    return ExitStatus(outcome.exit_status)


def summary(outcome: SelfTest) -> dict[str, Any]:
    """Return what was caught as plain values."""
    return {
        "planned": outcome.planned,
        "trials": outcome.trials,
        "killed": sum(one.killed for one in outcome.mutants),
        "exit_status": outcome.exit_status,
        "unchanged": None if outcome.unchanged is None else _plain(outcome.unchanged),
        "mutants": [_plain(one) for one in outcome.mutants],
    }


def _plain(found: Found) -> dict[str, Any]:
    return {
        "name": found.name,
        "what": found.what,
        "killed": found.killed,
        "killed_by": found.killed_by,
        "faults": list(found.faults),
        "tried": found.tried,
        "seconds": found.seconds,
    }


def _table(outcome: SelfTest) -> Table:
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("bug")
    table.add_column("what is wrong then")
    table.add_column("killed by")
    table.add_column("trials", justify="right")
    table.add_column("s", justify="right")
    for one in outcome.mutants:
        killer = escape(one.killed_by) if one.killed else "[bold red]survived[/]"
        table.add_row(
            escape(one.name), escape(one.what), killer, str(one.tried), f"{one.seconds:.0f}"
        )
    return table


def _verdict(outcome: SelfTest) -> str:
    killed = sum(one.killed for one in outcome.mutants)
    clean = outcome.unchanged
    if clean is None:
        unchanged = "the engine without a bug wasn't come to"
    elif clean.killed:
        unchanged = (
            "[bold red]the engine without a bug breaks[/] in "
            f"{escape(clean.killed_by)}: {escape(clean.faults[0])}"
        )
    else:
        unchanged = f"the engine without a bug survived all {clean.tried} trials"
    return f"{killed} of {outcome.planned} bugs were caught; {unchanged}."
