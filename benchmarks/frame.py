"""The frame of all benchmarks: options, progress, the table that is printed, the file that is kept.

A benchmark is a function that returns a measurement; its parameters are the options of its command.

Times that are compared are sampled in turns, round by round (`runs.interleave`), since a machine
that others share is slower for minutes at a time. pytest-benchmark takes all rounds of a function
before it begins the next one (`BenchmarkFixture._raw`), and pyperf all processes of a benchmark
(`Manager.create_runs`), so neither can time in turns. asv interleaves processes, but a benchmark
returns one number there, where a sample of ours has several, and a process costs more than a shot.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from contextvars import ContextVar
from inspect import Signature, signature
from pathlib import Path
from typing import Annotated, Any, Never, TypeVar

import typer
from typer.models import ArgumentInfo

from benchmarks.measurements import Shown, machine_folder
from ghostball.cli.shared.progress import counting
from ghostball.cli.shared.terminal import command, say, stdout
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.parallel.pool import Progress, run_tasks
from ghostball.validation.results.measurement import MeasurementError, make_folder

T = TypeVar("T")
R = TypeVar("R")
M = TypeVar("M", bound=Callable[..., Shown])

app = typer.Typer(
    name="benchmarks",
    help="Measure the speed and the accuracy of ghostball's own engine.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
)

Repeats = Annotated[
    int, typer.Option(min=1, help="Rounds: how often each is measured; slow ones less often.")
]
Count = Annotated[int, typer.Option(min=1, help="How many breaks, shots or tables.")]
Out = Annotated[
    Path | None,
    typer.Option("--out", "-o", metavar="DIR", help="Write the measurement there, as JSON."),
]
Store = Annotated[
    bool,
    typer.Option(
        "--store", help="Write it to benchmarks/results/MACHINE of the checkout, to be committed."
    ),
]

_ALWAYS_WHOLE = ("repeats", "jobs")
"""Options that leave a measurement whole."""

_progress: ContextVar[Progress[str]] = ContextVar("progress")


def benchmark(measure: M) -> M:
    """Make a command of a function that returns a measurement; the function stays as it is."""

    def run(*, out: Out = None, store: Store = False, **options: Any) -> None:
        if store:
            _refuse_parts(own, options)
        folders = [folder for folder in (out, machine_folder() if store else None) if folder]
        for folder in folders:
            make_folder(folder)
        with counting("measuring") as count:
            before = _progress.set(count)
            try:
                measured = measure(**options)
            finally:
                _progress.reset(before)
        stdout().print(measured.table)
        for folder in folders:
            stdout().print(f"written: {measured.save(folder)}", soft_wrap=True, markup=False)
        if measured.failure:
            say(f"[bold red]{measured.failure}[/]")
            raise typer.Exit(ExitStatus.CHECK_FAILED)

    own, kept = (signature(one, eval_str=True).parameters for one in (measure, run))
    run.__signature__ = Signature([*own.values(), kept["out"], kept["store"]])  # type: ignore[attr-defined]
    run.__doc__ = measure.__doc__
    app.command(measure.__name__)(command(run))
    return measure


def _refuse_parts(parameters: Any, options: dict[str, Any]) -> None:
    """Raise an error if an option makes a measurement smaller, or another one."""
    given: list[str] = []
    for name, one in parameters.items():
        if name not in _ALWAYS_WHOLE and one.default not in (one.empty, options[name]):
            (info,) = one.annotation.__metadata__
            given.append(str(info.metavar) if isinstance(info, ArgumentInfo) else f"`--{name}`")
    if given:
        raise MeasurementError(
            f"`--store` keeps whole measurements only: leave out {' and '.join(given)}, or use "
            "`--out DIR`"
        )


def report(done: int, planned: int, last: str, /) -> None:
    """Show how far the benchmark has come; nothing where no command runs it."""
    if (progress := _progress.get(None)) is not None:
        progress(done, planned, last)


def counted(items: Sequence[T], name: Callable[[T], str]) -> Iterator[T]:
    """Yield items; each is reported by its name when the next one is asked for."""
    for done, item in enumerate(items, start=1):
        yield item
        report(done, len(items), name(item))


def in_processes(
    numbers: Sequence[int], jobs: int, work: Callable[[int], R], name: str
) -> Iterator[R]:
    """Yield what `work` returns of each number, in the order in which processes end.

    Raises `MeasurementError` with the name and the number if a process crashes.
    """

    def crashed(number: int, reason: str) -> Never:
        raise MeasurementError(f"the measurement of {name} {number}: {reason}")

    with closing(run_tasks(numbers, jobs, work)) as answers:
        for count, done in enumerate(answers, start=1):
            yield done.or_else(crashed)
            report(count, len(numbers), f"{name} {done.task}")
