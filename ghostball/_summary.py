"""What `--format` prints of a results folder: what its results came to, for other programs."""

from __future__ import annotations

import json
from pathlib import Path

from ghostball._options import Format
from ghostball.reports import summary_markdown, summary_text
from ghostball.validation.baselines import load_regression
from ghostball.validation.baselines.junit import regression_xml
from ghostball.validation.results.frames import rows_of
from ghostball.validation.results.store import Results, has_results
from ghostball.validation.suite.junit import junit_xml


def printed(folder: Path, form: Format) -> str:
    """Return what stored results came to, with what changed where the folder holds a comparison.

    Raises
    ------
    GhostballError
        Where the folder holds neither.
    """
    regression = load_regression(folder) if folder.is_dir() else None
    # A comparison may lie in a folder of its own; what is no folder of ours says so as it is read.
    alone = regression is not None and not has_results(folder)
    results = None if alone else Results.open(folder)
    if form is Format.GITHUB:
        return summary_markdown(results, regression)
    if form is Format.TEXT:
        return summary_text(results, regression)
    if regression is not None and (results is None or regression.judged):
        xml, plain = regression_xml(regression), regression.model_dump(mode="json", by_alias=True)
        return xml if form is Format.JUNIT else json.dumps(plain) + "\n"
    assert results is not None
    if form is Format.JUNIT:
        return junit_xml(results.cases)
    tables = {name: rows_of(folder, name) for name in ("cases", "checks", "metrics")}
    if regression is not None:
        tables["changes"] = rows_of(folder, "changes")
    return json.dumps({"state": results.state, **tables}) + "\n"
