"""How far a long command has come: a bar on a terminal, a line now and then in a log."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

from rich.markup import escape
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from ghostball._terminal import say, stderr

LOG_INTERVAL = 10.0
"""Seconds between two lines of progress where there is no terminal to draw a bar on."""


class Count(Protocol):
    """Says that `done` of `planned` parts are done, and which was the last."""

    def __call__(self, done: int, planned: int, last: str, /) -> None: ...


@contextmanager
def counting(verb: str) -> Iterator[Count]:
    """Show a bar with the time left while the block runs; the function yielded moves it."""
    if not stderr().is_terminal:
        yield _log_lines(verb)
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left:"),
        TimeRemainingColumn(),
        TextColumn("[dim]{task.fields[last]}[/]"),
    )
    with Progress(*columns, console=stderr(), transient=True) as bar:
        task = bar.add_task(verb, total=None, last="")

        def count(done: int, planned: int, last: str, /) -> None:
            bar.update(task, completed=done, total=planned, last=escape(last))

        yield count


def _log_lines(verb: str) -> Count:
    spoke = time.monotonic()

    def count(done: int, planned: int, last: str, /) -> None:
        nonlocal spoke
        if done == planned or time.monotonic() - spoke >= LOG_INTERVAL:
            spoke = time.monotonic()
            say(f"{verb}: {done} of {planned} done, last {escape(last)}")

    return count
