"""Progress of a long command: a bar on a terminal, a line every few seconds in a log.

A command has named steps, such as compiling, running and drawing. The time left is that of the
current step.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from datetime import timedelta
from typing import TYPE_CHECKING

from rich.markup import escape
from rich.progress import (
    BarColumn,
    Progress,
    Task,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Column
from rich.text import Text

from ghostball.cli.shared.terminal import say, stderr

if TYPE_CHECKING:
    from ghostball.validation.parallel.pool import Progress as Count

LOG_INTERVAL = 10.0
"""Seconds between two lines of progress in a log."""

SPEED_PERIOD = 600.0
"""Time over which the speed of a step is averaged [s]; a single part can take minutes."""

COMPILING, RUNNING, DRAWING = "compiling", "running", "drawing"
"""Steps of several commands. COMPILING is skipped if all kernels are compiled."""

UNKNOWN_PACE = {COMPILING: "takes a few minutes, once"}
"""Text in place of the time left, for steps without an estimate.

Compiling has no estimate, because one kernel takes seconds and another takes minutes.
"""


class _LeftColumn(TimeRemainingColumn):
    """The time left of a step, or the text for a step without an estimate."""

    def render(self, task: Task) -> Text:
        """Return the text of the column."""
        if pace := task.fields["pace"]:
            return Text(pace, style="dim")
        return Text("left: ").append_text(super().render(task))


class Steps:
    """The steps of a command, in order, shown by one bar or by several bars in turn.

    >>> steps = Steps(COMPILING, RUNNING)
    >>> with steps.bar() as step:
    ...     run_suite(..., compiling=step(COMPILING), progress=step(RUNNING))
    """

    def __init__(self, *names: str) -> None:
        self._names = names

    @contextmanager
    def bar(self, first: str | None = None) -> Iterator[Callable[[str], Count[str]]]:
        """Show a bar while the block runs.

        Yields a function that returns the progress function of a step. Before the first progress,
        the bar shows the step `first`, by default the first step of the command.
        """
        logged = not stderr().is_terminal
        columns = (
            TextColumn("{task.description}"),
            BarColumn(bar_width=20),
            TextColumn("{task.completed:.0f} of {task.fields[planned]}"),
            TimeElapsedColumn(),
            _LeftColumn(),
            TextColumn(
                "{task.fields[last]}",
                style="dim",
                markup=False,
                table_column=Column(no_wrap=True, overflow="ellipsis", ratio=1),
            ),
        )
        bar = Progress(
            *columns,
            console=stderr(),
            transient=True,
            expand=True,
            disable=logged,
            speed_estimate_period=SPEED_PERIOD,
        )
        with nullcontext() if logged else bar:
            begun = self._title(first or self._names[0])
            task = bar.add_task(begun, total=None, planned="?", last="", pace="")
            shown = begun
            spoke = time.monotonic()

            def step(name: str) -> Count[str]:
                title = self._title(name)

                def count(done: int, planned: int, last: str, /) -> None:
                    nonlocal shown, spoke
                    if shown != title:  # the time left is that of the step
                        bar.reset(task)
                        shown = title
                    bar.update(
                        task,
                        description=title,
                        completed=done,
                        total=planned,
                        planned=planned,
                        last=last,
                        pace=UNKNOWN_PACE.get(name, ""),
                    )
                    now = time.monotonic()
                    begins = done == 0 and name in UNKNOWN_PACE
                    if logged and (begins or done == planned or now - spoke >= LOG_INTERVAL):
                        spoke = now
                        seconds = bar.tasks[0].time_remaining
                        left = f"{timedelta(seconds=round(seconds))} left" if seconds else ""
                        left = UNKNOWN_PACE.get(name, left) if done < planned else ""
                        parts = (
                            f"{done} of {planned} done",
                            left,
                            f"last {escape(last)}" * bool(last),
                        )
                        say(f"{title}: {', '.join(filter(None, parts))}")

                return count

            yield step

    def _title(self, name: str) -> str:
        if len(self._names) == 1:
            return name
        return f"{name} (step {self._names.index(name) + 1} of {len(self._names)})"


@contextmanager
def counting(name: str) -> Iterator[Count[str]]:
    """Show a bar for a command with one step; yields the progress function."""
    with Steps(name).bar() as step:
        yield step(name)
