"""What `ghostball diff` does: say what moved between two runs, or differs between two engines."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

from rich.markup import escape

from ghostball.cli.shared.config import load_config
from ghostball.cli.shared.options import Plain
from ghostball.cli.shared.tables import table_of
from ghostball.cli.shared.terminal import stdout
from ghostball.model import GhostballError
from ghostball.reports import style
from ghostball.reports.accuracy import cell_text
from ghostball.validation.checks.difference import CaseDifference, Moved, difference_of
from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.checks.verdict import verdict_of
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results.store import CaseRecord, Results, has_results

MOST_NAMED = 3
"""Metrics that a line of the table names; the others are counted."""

FIRST_NAMED = ("matching_events", "collision_count", "rest_time_error")
"""Metrics that are named before others."""


def run(first: str, second: str, out: Path | None, form: Plain) -> ExitStatus:
    """Compare two results folders, or two engines of one; print what differs."""
    found = _compared(first, second, load_config().out if out is None else out)
    if not found:
        raise GhostballError(f"{first} and {second} have no scene, so there is nothing to compare")
    if form is Plain.JSON:
        print(json.dumps({"base": first, "head": second, "cases": [_plain(one) for one in found]}))
    else:
        _show(first, second, found)
    return ExitStatus.CHECK_FAILED if any(one.got_worse for one in found) else ExitStatus.PASSED


def _compared(first: str, second: str, folder: Path) -> list[CaseDifference]:
    folders = [Path(one) for one in (first, second)]
    if all(map(has_results, folders)):
        base, head = (Results.open(one).cases for one in folders)
        return difference_of(base, head)
    for one, path in zip((first, second), folders, strict=True):
        if path.is_dir() or has_results(path):
            Results.open(path)  # says what is wrong with it, if anything is
            other = second if one == first else first
            raise GhostballError(
                f"{other}: no results folder, as {one} is. Give two of them, or two engines"
            )
    results = Results.open(folder)
    for one in (first, second):
        if one not in results.labels:
            raise GhostballError(
                f"{one}: neither a results folder nor an engine of {folder}, which has "
                f"{', '.join(results.labels)}. Another folder is chosen by `--out`"
            )
    return difference_of(results.cases, results.cases, {first: second})


def _show(first: str, second: str, found: Sequence[CaseDifference]) -> None:
    console, moved = stdout(), [one for one in found if one.differs]
    # What got worse first, then what got better, then the rest.
    moved.sort(key=lambda one: (not one.got_worse, not one.got_better))
    if moved:
        heads = ("scene", "engine", "how right", "what else moved")
        console.print(table_of(heads, map(_row, moved)))
    worse = sum(one.got_worse for one in found)
    parts = [f"{len(found) - len(moved)} of {len(found)} cases are alike"]
    if worse:
        parts.append(f"[bold red]{worse} got worse[/]")
    better = sum(one.got_better for one in found)
    if better:
        parts.append(f"[green]{better} got better[/]")
    console.print(f"{', '.join(parts)}: {escape(first)} -> {escape(second)}", soft_wrap=True)
    if ratio := _time_ratio(found):
        console.print(f"run time, {escape(second)} over {escape(first)}: {ratio:.2f} in the median")


def _row(one: CaseDifference) -> tuple[str, ...]:
    case = one.head or one.base
    assert case is not None
    base, head = (
        one.verdicts[side] if found is None else cell_text(found)
        for side, found in enumerate((one.base, one.head))
    )
    right = escape(head if base == head else f"{base} -> {head}")
    if one.got_worse or one.got_better:
        right = f"[{'bold red' if one.got_worse else 'green'}]{right}[/]"
    moved = "another shot has this name" if one.another_shot else _others(one.moved)
    return one.scene, escape(_labels(one)), right, escape(moved)


def _labels(one: CaseDifference) -> str:
    labels = [case.label for case in (one.base, one.head) if case is not None]
    return " -> ".join(dict.fromkeys(labels))


def _others(moved: Sequence[Moved]) -> str:
    # The others say the same again, in other units.
    rest = [
        one
        for one in moved
        if one.name not in ("rest_error_max", "rest_error_rms") and not one.name.endswith("_ulps")
    ]
    rest.sort(key=lambda one: one.name not in FIRST_NAMED)
    named = [f"{one.name} {_number(one)}" for one in rest[:MOST_NAMED]]
    more = [f"and {len(rest) - MOST_NAMED} more"] if len(rest) > MOST_NAMED else []
    return "; ".join(named + more)


def _number(one: Moved) -> str:
    unit = METRICS[one.name].unit
    base, head = (
        "none" if value is None else style.format_quantity(value, unit)
        for value in (one.base, one.head)
    )
    if base == head:
        return f"{base}, by a rounding"
    times = one.factor if one.factor > 1.0 else 1.0 / one.factor if one.factor else math.inf
    larger = "larger" if one.factor > 1.0 else "smaller"
    worth_it = isinstance(one.head, float) and 1.005 <= times < 1000.0
    return f"{base} -> {head}" + f", {times:.3g} times {larger}" * worth_it


def _time_ratio(found: Sequence[CaseDifference]) -> float | None:
    """Return the median of the ratios of run times, or None where no case ran on both sides."""
    ratios = [
        one.head.wall_time / one.base.wall_time
        for one in found
        if one.base is not None
        and one.head is not None
        and one.base.wall_time
        and one.head.wall_time
    ]
    return median(ratios) if ratios else None


def _plain(one: CaseDifference) -> dict[str, Any]:
    def side(case: CaseRecord | None) -> dict[str, Any] | None:
        if case is None:
            return None
        kind = None if case.accuracy is None else case.accuracy.kind
        return {"engine": case.label, "class": kind, "verdict": verdict_of(case).words}

    return {
        "scene": one.scene,
        "base": side(one.base),
        "head": side(one.head),
        "differs": one.differs,
        "got_worse": one.got_worse,
        "got_better": one.got_better,
        "another_shot": one.another_shot,
        "metrics": [{"name": m.name, "base": m.base, "head": m.head} for m in one.moved],
    }
