"""How far a long command has come: one bar on a terminal, a line now and then in a log.

Its steps are named and counted, also what of the kernels must be compiled first; the time left is
that of the step.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.markup import escape
from rich.progress import (
    BarColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeElapsedColumn,
)
from rich.table import Column
from rich.text import Text

from ghostball.cli.shared.terminal import say, stderr

if TYPE_CHECKING:
    from ghostball.validation.parallel.pool import Progress as Count
    from ghostball.validation.results.records import CaseRecord

LOG_INTERVAL = 10.0
"""Seconds between two lines of progress where there is no terminal to draw a bar on."""

SURE_AFTER = 2
"""Parts of a step after which a time left is worth saying."""

COMPILING, DRAWING = "compiling", "drawing"
"""Steps of several commands. Where the kernels are compiled, a run begins with its second step."""


class Steps:
    """The steps of a command, in their order; several bars in turn may show them.

    >>> steps = Steps(COMPILING, "running")
    >>> with steps.bar() as step:
    ...     run_suite(..., compiling=step(COMPILING), progress=step("running"))
    """

    def __init__(self, *names: str) -> None:
        self._names = names

    @contextmanager
    def bar(self, first: str | None = None) -> Iterator[Callable[[str], Count[str]]]:
        """Show a bar while the block runs; what is yielded gives each step what moves it.

        Until something moves, it names the `first` step; left out, the first of all.
        """
        if not stderr().is_terminal:
            yield self._log_lines
            return
        columns = (
            TextColumn("{task.description}"),
            BarColumn(bar_width=20),
            TextColumn("{task.completed:.0f} of {task.fields[planned]}"),
            TimeElapsedColumn(),
            _TimeLeft(),
            TextColumn(
                "{task.fields[last]}",
                style="dim",
                markup=False,
                table_column=Column(no_wrap=True, overflow="ellipsis", ratio=1),
            ),
        )
        with Progress(*columns, console=stderr(), transient=True, expand=True) as bar:
            title = self._title(first or self._names[0])
            task = bar.add_task(title, total=None, planned="?", pace=Pace(), last="")

            def step(name: str) -> Count[str]:
                pace = Pace()

                def count(done: int, planned: int, last: str, /) -> None:
                    pace.done(done, planned)
                    bar.update(
                        task,
                        description=self._title(name),
                        completed=done,
                        total=planned,
                        planned=planned,
                        pace=pace,
                        last=last,
                    )

                return count

            yield step

    def _title(self, name: str) -> str:
        if len(self._names) == 1:
            return name
        return f"{name} (step {self._names.index(name) + 1} of {len(self._names)})"

    def _log_lines(self, name: str) -> Count[str]:
        pace = Pace()
        spoke = time.monotonic()

        def count(done: int, planned: int, last: str, /) -> None:
            nonlocal spoke
            pace.done(done, planned)
            if done == planned or time.monotonic() - spoke >= LOG_INTERVAL:
                spoke = time.monotonic()
                parts = (
                    f"{done} of {planned} done",
                    pace.left(),
                    f"last {escape(last)}" if last else "",
                )
                say(f"{self._title(name)}: {', '.join(filter(None, parts))}")

        return count


def of_cases(count: Count[str]) -> Count[CaseRecord]:
    """Return what counts cases, each by its scene and engine."""

    def progress(done: int, planned: int, case: CaseRecord) -> None:
        count(done, planned, f"{case.scene} on {case.label}")

    return progress


class Pace:
    """How long a step still takes, at the pace of all of it until now.

    What an earlier run did takes no time, so a step is timed from its first part on.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._first: tuple[int, float] | None = None
        self._last = (0, 0, 0.0)

    def done(self, done: int, planned: int) -> None:
        """Note that so many parts are done, of how many."""
        now = self._clock()
        if self._first is None:
            self._first = (done, now)
        self._last = (done, planned, now)

    def left(self) -> str:
        """Return the time left in words; "" where nobody can say, or a part takes longer."""
        if self._first is None:
            return ""
        (before, began), (done, planned, at) = self._first, self._last
        if done - before < SURE_AFTER or done >= planned:
            return ""
        seconds = (at - began) / (done - before) * (planned - done) - (self._clock() - at)
        return f"{in_words(seconds)} left" if seconds > 0.0 else ""


class _TimeLeft(ProgressColumn):
    """What the pace of a task says, at each look anew."""

    def render(self, task: Task) -> Text:
        pace: Pace = task.fields["pace"]
        return Text(pace.left())


def in_words(seconds: float) -> str:
    """Return a time as it is known: to about a fifth of itself.

    >>> in_words(7.3), in_words(47.0), in_words(130.0), in_words(7000.0)
    ('a few seconds', 'about 50 s', 'about 2 min', 'about 1.9 h')
    """
    if seconds < 10.0:
        return "a few seconds"
    if seconds < 90.0:
        return f"about {round(seconds, -1):.0f} s"
    if seconds < 5400.0:
        return f"about {seconds / 60.0:.0f} min"
    return f"about {seconds / 3600.0:.1f} h"


@contextmanager
def counting(name: str) -> Iterator[Count[str]]:
    """Show a bar for a command of one step; the function yielded moves it."""
    with Steps(name).bar() as step:
        yield step(name)
