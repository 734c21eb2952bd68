"""The option `--relations`, and the results of relations in the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.markup import escape

from ghostball.cli.options import ALL_RELATIONS
from ghostball.cli.shared.tables import table_of
from ghostball.cli.shared.terminal import say
from ghostball.reports.relations import (
    RELATION_KEY,
    asked_relations,
    never_judged,
    relation_rows,
    unjudged_relations,
)
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results.records import CaseRecord

REMARKS_SHOWN = 20
"""Largest number of lines about relations that were not judged."""


def relations_of(text: str | None) -> tuple[str, ...] | None:
    """Return the relations that the option names; () for all of them, None without the option."""
    if text is None:
        return None
    return () if text == ALL_RELATIONS else tuple(one.strip() for one in text.split(","))


def relations_table(cases: Sequence[CaseRecord]) -> RenderableType:
    """Return the kept and broken relations of each engine, and why some weren't judged."""
    mine = list(cases)
    heads = ("engine", *asked_relations(mine))
    rows = (tuple(map(escape, row)) for row in relation_rows(mine))
    remarks = list(unjudged_relations(mine))
    more = len(remarks) - REMARKS_SHOWN
    shown = [*remarks[:REMARKS_SHOWN], *([f"... and {more} more, in the report"] * (more > 0))]
    table = table_of(heads, rows, title="relations")
    return Group(table, f"[dim]{escape(RELATION_KEY)}[/]", *map(escape, shown))


def say_never_judged(cases: Sequence[CaseRecord], relations: Sequence[str] | None) -> ExitStatus:
    """If too few relations were judged, print the unjudged relations and return NOT_JUDGED.

    `relations`: names of the requested relations; () requests all, None requests none. Each named
        relation must be judged in some case. If all are requested, one judged relation is enough,
        because no scene supports every relation.
    """
    found = [] if relations is None else never_judged(list(cases))
    if found and (relations or found == asked_relations(cases)):
        say(f"[bold yellow]judged in no case: {', '.join(found)}.[/]")
        return ExitStatus.NOT_JUDGED
    return ExitStatus.PASSED
