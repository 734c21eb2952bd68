"""What the commands share: their options, and how a measurement is shown and written."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, TypeVar

import typer
from rich.console import RenderableType

from benchmarks import measurements
from benchmarks.measurements import Measurement
from benchmarks.running import BenchError
from ghostball._progress import counting
from ghostball._terminal import say, stdout
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results.environment import describe_environment

M = TypeVar("M", bound=Measurement)

Repeats = Annotated[
    int, typer.Option(min=1, help="Rounds: how often each is measured; slow ones less often.")
]
Quick = Annotated[
    bool, typer.Option("--smoke", help="Tiny sizes, to see that all runs; its times mean nothing.")
]
Out = Annotated[
    Path | None,
    typer.Option("--out", "-o", metavar="FILE|DIR", help="Write the measurement there, as JSON."),
]
Store = Annotated[
    bool,
    typer.Option(
        "--store", help="Write it to benchmarks/results/MACHINE of the checkout, to be committed."
    ),
]


def paths_of(kind: str, out: Path | None, store: bool, *, part: bool) -> dict[str, Path]:
    """Return the files to write, by option, each checked before anything is measured."""
    paths: dict[str, Path] = {}
    if store:
        if part:
            raise BenchError(
                "`--store` keeps whole measurements only, so it can't go with `--smoke`, "
                "single workloads, `--first`, fewer `--shots` than by default, `--engine`, or "
                "single scenes. Use `--out FILE`"
            )
        paths["--store"] = measurements.store_path(describe_environment(), kind)
    if out is not None:
        paths["--out"] = measurements.out_path(out, kind)
    for option, path in paths.items():
        measurements.check_target(path, kind, option)
    return paths


def measured_by(
    measure: Callable[..., M], tables: Callable[[M], RenderableType], paths: dict[str, Path]
) -> M:
    """Measure, show it, and write it; end with 130 where that was interrupted."""
    with counting("measuring") as count:
        measured = measure(progress=count)
    stdout().print(tables(measured))
    for option, path in paths.items():
        if measured.interrupted and not measured.anything:
            continue
        if measured.interrupted and option == "--store":
            say("[bold]Interrupted:[/] nothing is stored, for a part would replace the whole")
            continue
        measurements.save(measured, path, option)
        stdout().print(f"written: {path}", soft_wrap=True, markup=False)
    if measured.interrupted:
        say("[bold]Interrupted:[/] the tables hold what was measured until then")
        raise typer.Exit(ExitStatus.INTERRUPTED)
    return measured
