"""How shots from varied starts end on each engine."""

from __future__ import annotations

from markupsafe import Markup

from ghostball.reports.page.rendering import render
from ghostball.reports.spread_text import HEADER, KEY, remarks_of, rows_of
from ghostball.validation.results.store import Results


def ensembles_html(results: Results) -> Markup:
    """Return how much the ends of varied starts vary; "" where none were played."""
    if not results.varied:
        return Markup()
    rows, remarks = list(rows_of(results)), list(remarks_of(results))
    return render("ensembles.html", key=KEY, header=HEADER, rows=rows, remarks=remarks)
