"""What `--format` prints of a results folder: what its results came to, for other programs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ghostball.cli.shared.options import Format
from ghostball.reports import summary_markdown, summary_text
from ghostball.reports.ci.findings import findings, notes
from ghostball.reports.ci.junit import junit_xml
from ghostball.validation.baselines import load_regressions
from ghostball.validation.measured.likeness import Likeness
from ghostball.validation.results.frames import csv_of, rows_of
from ghostball.validation.results.store import Results
from ghostball.validation.suite.real_tables import load_likenesses


def printed(folder: Path, form: Format) -> str:
    """Return what stored results came to, with what changed if the folder holds a comparison."""
    results, regressions = Results.open(folder), load_regressions(folder)
    if form is Format.MARKDOWN:
        return summary_markdown(results, *regressions)
    if form is Format.GITHUB:
        return notes(findings(results, regressions))
    if form is Format.TEXT:
        return summary_text(results, *regressions)
    if form is Format.JUNIT:
        return junit_xml(results.cases, regressions)
    if form is Format.CSV:
        return csv_of(rows_of(folder, "comparisons"))
    tables = {name: rows_of(folder, name) for name in ("cases", "comparisons", "checks", "metrics")}
    compared = [one.model_dump(mode="json", by_alias=True) for one in regressions]
    beside = [_plain(one) for one in load_likenesses(folder)]
    whole = {"state": results.state, **tables, "regressions": compared, "real_tables": beside}
    return json.dumps(whole) + "\n"


def _plain(found: Likeness) -> dict[str, Any]:
    """Return what an engine makes of real tables, with how far off it is."""
    families = []
    for one in found.families:
        graded = one.grades and not one.lacks
        off = {
            "typical": one.typical if graded else None,
            "most": one.most if graded else None,
            "typical_difference": None if one.lacks else one.typical_difference,
        }
        families.append(one.model_dump(mode="json") | off)
    return {"label": found.label, "typical": found.typical, "families": families}
