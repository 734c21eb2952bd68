"""Committed measurements, and tables of them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from statistics import mean, median
from typing import TypeVar

import numpy as np
from rich import box
from rich.console import RenderableType
from rich.markup import escape
from rich.table import Table

from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.measurement import Measurement, MeasurementError, Record

M = TypeVar("M", bound=Measurement)

STORE = Path(__file__).resolve().parent / "results"
"""Folder of committed measurements, with a folder for each machine."""


class BenchmarkMeasurement(Measurement):
    """A measurement of a command of `python -m benchmarks`."""

    @property
    def table(self) -> RenderableType:
        """The measurement as a table for the terminal."""
        raise NotImplementedError

    @property
    def failure(self) -> str:
        """Failure of the engine, in rich's markup, or ""; a failure gives exit status 1."""
        return ""


class Distribution(Record):
    """Distribution of a quantity; the figures are None without values.

    `p99`: the smallest value that at least 99 % of the values don't exceed.
    """

    count: int
    median: float | None = None
    mean: float | None = None
    p99: float | None = None
    greatest: float | None = None

    @classmethod
    def of(cls, values: Sequence[float]) -> Distribution:
        """Return the distribution of some values."""
        if not len(values):
            return cls(count=0)
        return cls(
            count=len(values),
            median=median(values),
            mean=mean(values),
            p99=float(np.quantile(values, 0.99, method="inverted_cdf")),
            greatest=max(values),
        )


def machine_folder() -> Path:
    """Return the folder for measurements on this machine, such as "amd-epyc-2-cores"."""
    machine = describe_environment()
    words = re.findall(r"[a-z0-9]+", f"{machine['cpu']} {machine['cores']} cores".lower())
    return STORE / "-".join(words)


def committed(kind: type[M]) -> M | None:
    """Return the committed measurement of a kind; None if no machine has one.

    The measurement of this machine comes first, then the measurements of other machines by name.
    """
    mine = machine_folder()
    paths = sorted(STORE.glob(f"*/{kind.model_fields['kind'].default}.json"))
    return kind.load(min(paths, key=lambda path: path.parent != mine)) if paths else None


def measured(kind: type[M]) -> M:
    """Return the committed measurement of a kind; see `committed`.

    Raises `MeasurementError` if there is none.
    """
    if (found := committed(kind)) is None:
        name = kind.model_fields["kind"].default
        raise MeasurementError(
            f"{STORE}: no folder has a {name}.json. Run the benchmark with `--store` first"
        )
    return found


def table_of(
    heads: Sequence[str],
    rows: Iterable[Sequence[str]],
    *,
    left: Sequence[str] = (),
    title: str = "",
) -> Table:
    """Return a table; numbers are aligned to the right.

    `left`: heads of columns with text, besides the first column.

    Cells may contain rich's markup, except those of the first column.
    """
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title=title, title_justify="left")
    for k, head in enumerate(heads):
        table.add_column(head, justify="left" if k == 0 or head in left else "right")
    for name, *cells in rows:
        table.add_row(escape(name), *cells)
    return table
