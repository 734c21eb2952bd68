"""Committed measurements, and how they are shown."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TypeVar

from rich import box
from rich.console import RenderableType
from rich.markup import escape
from rich.table import Table

from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.measurement import Measurement

M = TypeVar("M", bound=Measurement)

STORE = Path(__file__).resolve().parent / "results"
"""Committed measurements, one folder per machine."""


class Shown(Measurement):
    """A measurement that `python -m benchmarks` shows."""

    @property
    def table(self) -> RenderableType:
        """It as a table for the eye."""
        raise NotImplementedError


def machine_folder() -> Path:
    """Return where this machine's committed measurements lie, such as "amd-epyc-2-cores"."""
    machine = describe_environment()
    words = re.findall(r"[a-z0-9]+", f"{machine['cpu']} {machine['cores']} cores".lower())
    return STORE / "-".join(words)


def committed(kind: type[M]) -> M | None:
    """Return the committed measurement of this machine, else of the first; None without any."""
    paths = committed_files(f"{kind.model_fields['kind'].default}.json")
    return kind.load(paths[0]) if paths else None


def committed_files(name: str) -> list[Path]:
    """Return the committed files of a name: this machine's first, then those of all others."""
    mine = machine_folder()
    return sorted(STORE.glob(f"*/{name}"), key=lambda path: (path.parent != mine, path))


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
