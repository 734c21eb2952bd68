"""What the text of a report is made of: tables, figures, numbers with their units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import PurePosixPath

from reports import style
from validation.store import CaseRecord

Drawn = Mapping[str, PurePosixPath]
"""Figures by kind: file without its ending, relative to the report."""


def figure_link(caption: str, stem: PurePosixPath | None) -> str:
    """Return a picture that leads to its scalable version; "" where there is none."""
    return "" if stem is None else f"[![{caption}]({stem}.png)]({stem}.svg)"


def table_of(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of cells that are Markdown already."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def one_line(text: str) -> str:
    """Keep a text on one line and within its cell."""
    return " ".join(text.split()).replace("|", "\\|")


def many(count: int, noun: str) -> str:
    """Return "1 scene", "2 scenes"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def metric_of(case: CaseRecord, name: str) -> float | None:
    """Return a metric of a case, or None where it has no value."""
    value = case.metrics.get(name)
    return None if value is None else float(value)


def quantity_text(value: float, unit: str) -> str:
    """Return a number as reports show it, a length or a time with the unit that suits it."""
    if unit == "m":
        return style.format_length(value)
    return style.format_time(value) if unit == "s" else number_text(value)


def number_text(value: float | None) -> str:
    """Return a pure number to three digits, a count in full, a dash for None."""
    if value is None:
        return "–"
    return str(value) if isinstance(value, int) else f"{value:.3g}"
