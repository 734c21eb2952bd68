"""Tables for the terminal, in the style of all commands."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence

from rich import box
from rich.console import RenderableType
from rich.markup import escape
from rich.table import Table


def table_of(
    heads: Sequence[str],
    rows: Iterable[Sequence[RenderableType]],
    *,
    right: Collection[str] = (),
    whole: Collection[str] | None = None,
    title: str | None = None,
) -> Table:
    """Return a table of cells in rich's markup.

    `right`: heads of the columns that are aligned to the right.
    `whole`: heads of the columns whose lines aren't wrapped (default: the first column).
    """
    table = Table(box=box.SIMPLE_HEAD, title=title, pad_edge=False, padding=(0, 2, 0, 0))
    stacked = any("\n" in head for head in heads)
    for head in heads:
        table.add_column(
            head,
            justify="right" if head in right else "left",
            no_wrap=head in (heads[:1] if whole is None else whole),
            vertical="bottom" if stacked else "top",
        )
    for row in rows:
        table.add_row(*row)
    return table


def facts_table(rows: Mapping[str, str]) -> Table:
    """Return a table with a line for each fact: its dimmed name, and its value."""
    table = Table(box=None, show_header=False, padding=(0, 1))
    table.add_column(style="dim", no_wrap=True)
    table.add_column(overflow="fold")
    for key, value in rows.items():
        table.add_row(key, escape(value))
    return table
