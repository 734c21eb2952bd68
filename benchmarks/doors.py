"""Time for compiling the lean kernel with both doors of numba, without one, and without both.

A door is a private part of numba that the engine uses for compiling (`engine.library.numba_doors`).
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from functools import partial
from typing import Annotated, Literal, get_args

import typer
from rich.console import RenderableType

from benchmarks.commands import benchmark, report_progress
from benchmarks.measurements import BenchmarkMeasurement, table_of
from benchmarks.processes import timed
from ghostball.engine.library import processor
from ghostball.engine.running import driver
from ghostball.engine.running.variants import Variant
from ghostball.validation.results.measurement import Record
from ghostball.validation.runs.interleave import Sampler, Task, interleave

Way = Literal["both doors", "without by_common_types", "without both"]
WAYS: tuple[Way, ...] = get_args(Way)


class DoorsRow(Record):
    """One way to compile.

    `seconds`: processor time of a process that compiles the kernel [s], the minimum of all rounds.
    """

    way: Way
    seconds: float


class DoorsMeasurement(BenchmarkMeasurement):
    """Measurement of `python -m benchmarks doors`; the first row has both doors."""

    kind: Literal["doors"] = "doors"
    rows: tuple[DoorsRow, ...]

    @property
    def table(self) -> RenderableType:
        """Table with the time of each way, also divided by the time with both doors."""
        first = self.rows[0].seconds
        cells = (
            (row.way, f"{row.seconds:.1f} s", f"{row.seconds / first:.2f}") for row in self.rows
        )
        return table_of(("way to compile", "processor time", "over both doors"), cells)


Rounds = Annotated[
    int, typer.Option(min=1, help="Number of rounds; each way takes minutes in each round.")
]


@benchmark
def doors(repeats: Rounds = 1) -> DoorsMeasurement:
    """Measure the time to compile the lean kernel with private parts of numba and without them.

    The processor times of separate processes are compared.
    """
    return measure_doors(seconds_in_new_process, rounds=repeats)


def measure_doors(seconds: Callable[[Way], float], *, rounds: int) -> DoorsMeasurement:
    """Measure each way `rounds` times, alternately; `seconds` returns the time of one sample."""

    def prepare(way: Way) -> Sampler:
        return lambda: {"seconds": seconds(way)}

    found = interleave([Task(way, partial(prepare, way)) for way in WAYS], rounds, report_progress)
    rows = (DoorsRow(way=way, seconds=min(found[way]["seconds"])) for way in WAYS)
    return DoorsMeasurement(rounds=rounds, rows=tuple(rows))


def seconds_in_new_process(way: Way) -> float:
    """Compile the kernel in a new process; return the processor time for compiling [s].

    Raises `MeasurementError` if the process fails.
    """
    program = f"from benchmarks.doors import seconds_here; print(seconds_here({way!r}))"
    # The settings of the engine for compiling, see `load.build`.
    settings = {"NUMBA_CPU_NAME": processor.target(), "NUMBA_CPU_FEATURES": ""}
    return timed(program, **settings)[1]


def seconds_here(way: Way) -> float:
    """Compile the kernel in this process, which compiles nothing else; return processor time [s].

    Afterwards, this process may compile without the doors.
    """
    from ghostball.engine.library import build, numba_doors, plain_numba  # noqa: PLC0415 - numba

    if way == "without by_common_types":
        numba_doors.by_common_types = lambda dispatcher: dispatcher
    if way == "without both":
        build._WAY[:] = [plain_numba.Plain()]
    gc.disable()  # as `build.build` does
    needed = driver.needed(Variant.LEAN)
    kernel = needed.kernel.function
    before = time.process_time()
    build._in_one_piece(build.object_code, kernel, needed.kinds, processor.target())
    return time.process_time() - before
