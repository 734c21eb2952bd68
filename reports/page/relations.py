"""Section of relations: which relation an engine breaks, with both runs."""

from __future__ import annotations

from markupsafe import Markup

from ghostball.reports.page.changed import picture_of
from ghostball.reports.page.rendering import render
from ghostball.reports.relations import (
    RELATION_KEY,
    BrokenRelation,
    asked_relations,
    broken_relations,
    relation_rows,
    unjudged_relations,
)
from ghostball.validation.checks.relations import WORDS
from ghostball.validation.results.store import Results


def relations_html(results: Results) -> Markup:
    """Return the relations by engine, and both runs of each broken one; "" if none was asked."""
    header = asked_relations(results.cases)
    if not header:
        return Markup()
    return render(
        "relations.html",
        key=RELATION_KEY,
        header=header,
        rows=list(relation_rows(results.cases)),
        broken=[(one, _picture(one)) for one in broken_relations(results.cases)],
        words=WORDS,
        unjudged=list(unjudged_relations(results.cases)),
    )


def _picture(one: BrokenRelation) -> tuple[float, dict[str, object]] | None:
    """Return the time and the picture of both runs; None if they were not compared."""
    found = one.case.related.get(one.relation)
    if found is None:
        return None
    first, second = (
        [(x, y, z) for x, y, z in ends.tolist()] for ends in (found.first, found.second)
    )
    return found.t, picture_of(one.case.load_scene(), first, second)
