"""`ghostball history`: stored measurements over revisions, as a table, a figure, or JSON."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from rich import box
from rich.markup import escape
from rich.table import Table

from ghostball._terminal import ExitStatus, say, stdout
from ghostball.reports import style
from ghostball.reports.history_figure import draw_history, revision_text
from ghostball.validation.bench.history import History, Version, read_history

MOST_VERSIONS = 4
"""Versions that a table has room for."""


def run(kind: str, *, pattern: str | None, plot: Path | None, as_json: bool) -> ExitStatus:
    """Read the history of a kind of measurement and show it."""
    history = read_history(kind, pattern)
    if plot is not None:
        with style.drawing():
            figure = draw_history(history)
            style.lay_out(figure)
            style.save_one(figure, plot)
    for one in history.unread:
        say(f"left out: {escape(one.path)} at {one.commit[:10]}: {escape(one.why)}")
    if history.cut:
        say(
            "[yellow]This clone is shallow: older measurements may be missing.[/] "
            "`git fetch --unshallow` gets them"
        )
    if as_json:
        print(json.dumps(_plain(history)))
        return ExitStatus.PASSED
    for machine in history.machines:
        stdout().print(_table(machine, history))
    if plot is not None:
        stdout().print(f"drawn in {plot}", soft_wrap=True, markup=False)
    return ExitStatus.PASSED


def _plain(history: History) -> dict[str, object]:
    return {
        "kind": history.kind,
        "cut": history.cut,
        "versions": [asdict(version) for version in history.versions],
        "left_out": [asdict(one) for one in history.unread],
    }


def _table(machine: str, history: History) -> Table:
    versions = history.of(machine)
    shown = versions[-MOST_VERSIONS:]
    title = f"{history.kind} on {machine}"
    if len(shown) < len(versions):
        title += f": the newest {len(shown)} of {len(versions)} versions (--json has all)"
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title=escape(title), title_justify="left")
    table.add_column("quantity", no_wrap=True)
    for version in shown:
        table.add_column(f"{revision_text(version)}\n{version.date[:10]}", no_wrap=True)
    first = len(versions) - len(shown)
    for name in history.quantities:
        cells = [_cell(name, versions, k) for k in range(first, len(versions))]
        if any(cells):
            table.add_row(escape(name), *cells)
    return table


def _cell(name: str, versions: tuple[Version, ...], k: int) -> str:
    """Return the value, its spread, and its ratio to the one before; "" where there is none."""
    now = versions[k].values.get(name)
    if now is None:
        return ""
    text = style.format_quantity(now.value, now.unit)
    if now.low is not None and now.high is not None and now.low < now.high:
        low, high = (style.format_quantity(value, now.unit) for value in (now.low, now.high))
        text += f" ({low} to {high})"
    before = next((v.values[name] for v in versions[:k][::-1] if name in v.values), None)
    if before is None:
        return text
    if now.value == before.value:
        return f"{text} ="
    if before.value == 0.0:  # no ratio says how much that is
        return f"{text} from 0"
    return f"{text} × {now.value / before.value:#.3g}"
