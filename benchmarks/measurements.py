"""Committed measurements, and how they are shown."""

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
"""Committed measurements, one folder per machine."""


class Shown(Measurement):
    """A measurement that `python -m benchmarks` shows."""

    @property
    def table(self) -> RenderableType:
        """It as a table for the eye."""
        raise NotImplementedError

    @property
    def failure(self) -> str:
        """What is wrong with the engine, in markup; the command then exits with 1."""
        return ""


class Distribution(Record):
    """How one quantity is spread over many values; None where there are none.

    `p99` is the least of the values that 99 % of them don't exceed.
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
    """Return where this machine's committed measurements lie, such as "amd-epyc-2-cores"."""
    machine = describe_environment()
    words = re.findall(r"[a-z0-9]+", f"{machine['cpu']} {machine['cores']} cores".lower())
    return STORE / "-".join(words)


def committed(kind: type[M]) -> M | None:
    """Return the committed measurement of this machine, else of the first; None without any."""
    mine = machine_folder()
    paths = sorted(STORE.glob(f"*/{kind.model_fields['kind'].default}.json"))
    return kind.load(min(paths, key=lambda path: path.parent != mine)) if paths else None


def measured(kind: type[M]) -> M:
    """Return the committed measurement of this machine, else of the first."""
    if (found := committed(kind)) is None:
        name = kind.model_fields["kind"].default
        raise MeasurementError(f"{STORE}: it holds no {name}.json. Measure first, and `--store` it")
    return found


def table_of(
    heads: Sequence[str],
    rows: Iterable[Sequence[str]],
    *,
    left: Sequence[str] = (),
    title: str = "",
) -> Table:
    """Return a table whose first column, and those that `left` names, are text, the others numbers.

    A cell may hold rich's markup, but in the first column, whose names are shown as they are.
    """
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title=title, title_justify="left")
    for k, head in enumerate(heads):
        table.add_column(head, justify="left" if k == 0 or head in left else "right")
    for name, *cells in rows:
        table.add_row(escape(name), *cells)
    return table
