"""Make commands from benchmark functions: options, progress, printed tables, stored files.

A benchmark is a function that returns a measurement; its parameters are the options of its command.

Times that are compared are sampled alternately, round by round (`runs.interleave`), because a
shared machine can be slow for minutes. pytest-benchmark runs all rounds of one function before the
next function (`BenchmarkFixture._raw`), and pyperf runs all processes of one benchmark
(`Manager.create_runs`), so neither can alternate. asv alternates processes, but its benchmarks
return one number (a sample here has several), and starting a process takes longer than a shot.
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

from benchmarks.measurements import BenchmarkMeasurement, machine_folder
from ghostball.cli.shared.progress import counting
from ghostball.cli.shared.terminal import command, say, stdout
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.parallel.pool import Progress, run_tasks
from ghostball.validation.results.measurement import MeasurementError, make_folder

T = TypeVar("T")
R = TypeVar("R")
M = TypeVar("M", bound=Callable[..., BenchmarkMeasurement])

app = typer.Typer(
    name="benchmarks",
    help="Measure the speed and the accuracy of Ghostball's engine.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
)

Repeats = Annotated[
    int, typer.Option(min=1, help="Number of rounds; slow measurements have fewer.")
]
Count = Annotated[int, typer.Option(min=1, help="Number of breaks, shots or tables.")]
Out = Annotated[
    Path | None,
    typer.Option("--out", "-o", metavar="DIR", help="Write the measurement to DIR, as JSON."),
]
Store = Annotated[
    bool,
    typer.Option(
        "--store", help="Write the measurement to benchmarks/results/MACHINE, to be committed."
    ),
]


def peer_option(peers: Sequence[str]) -> Any:
    """Return the option that names other engines to measure; without it, `peers` are measured."""
    return typer.Option(
        metavar="ENGINE",
        help="Other engine to measure, as for `run --engine`; repeatable. `none` measures only "
        f"Ghostball's engine (default: {', '.join(peers)}).",
    )


_ALLOWED_WITH_STORE = ("repeats", "jobs")
"""Options with which a measurement is still complete."""

_progress: ContextVar[Progress[str]] = ContextVar("progress")


def benchmark(measure: M) -> M:
    """Make a command from a function that returns a measurement, and return the function."""

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
    name, first_line = (
        measure.__name__.replace("_", "-"),
        (measure.__doc__ or "").partition("\n")[0],
    )
    app.command(name, short_help=first_line)(command(run))  # otherwise click cuts the line
    return measure


def _refuse_parts(parameters: Any, options: dict[str, Any]) -> None:
    """Raise `MeasurementError` if an option makes the measurement incomplete or different."""
    given: list[str] = []
    for name, one in parameters.items():
        if name not in _ALLOWED_WITH_STORE and one.default not in (one.empty, options[name]):
            (info,) = one.annotation.__metadata__
            given.append(str(info.metavar) if isinstance(info, ArgumentInfo) else f"`--{name}`")
    if given:
        raise MeasurementError(
            f"`--store` stores only complete measurements. Remove {' and '.join(given)}, or use "
            "`--out DIR`"
        )


def report_progress(done: int, planned: int, last: str, /) -> None:
    """Show the progress of the benchmark, if it runs as a command."""
    if (progress := _progress.get(None)) is not None:
        progress(done, planned, last)


def with_progress(items: Sequence[T], name: Callable[[T], str]) -> Iterator[T]:
    """Yield items, and report each as done, with its name, when the next one is requested."""
    for done, item in enumerate(items, start=1):
        yield item
        report_progress(done, len(items), name(item))


def in_processes(
    numbers: Sequence[int], jobs: int, work: Callable[[int], R], name: str
) -> Iterator[R]:
    """Yield the result of `work` for each number, computed in processes, in order of completion.

    Raises `MeasurementError` with the name and the number if a process crashes.
    """

    def crashed(number: int, reason: str) -> Never:
        raise MeasurementError(f"the measurement of {name} {number}: {reason}")

    with closing(run_tasks(numbers, jobs, work)) as answers:
        for count, done in enumerate(answers, start=1):
            yield done.or_else(crashed)
            report_progress(count, len(numbers), f"{name} {done.task}")
