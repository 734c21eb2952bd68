"""The tables of a results folder as plain rows, for exported files and data frames."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from pydantic import TypeAdapter

from ghostball.model import GhostballError
from ghostball.validation.results.comparisons import comparison_row
from ghostball.validation.results.database import reading, record_of
from ghostball.validation.results.files import ResultsError, write_files
from ghostball.validation.results.records import CaseRecord

TABLES: Final[Mapping[str, str]] = {
    "cases": "SELECT record, reused FROM cases ORDER BY id",
    "metrics": "SELECT * FROM metrics",
    "checks": (
        "SELECT scene, label, value AS record FROM cases, json_each(record, '$.checks') "
        "ORDER BY cases.id"
    ),
    "events": (
        "SELECT cases.scene, label, t, kind, a, b FROM cases JOIN motions ON record_id = cases.id "
        "JOIN events ON motion_id = motions.id ORDER BY cases.id, events.rowid"
    ),
    "comparisons": "SELECT record FROM cases ORDER BY id",
    "changes": (
        "SELECT json_extract(engines.value, '$.label') AS label, scenes.value AS record "
        "FROM documents, json_each(content) AS engines, json_each(engines.value, '$.scenes') "
        "AS scenes WHERE name = 'regression'"
    ),
}
"""The tables and their queries; a column `record` holds several columns, as JSON."""

_RECORD: Final = TypeAdapter(dict[str, Any])
_CASE: Final = TypeAdapter(CaseRecord)


def rows_of(folder: Path, table: str) -> list[dict[str, Any]]:
    """Return the rows of a table, as plain values by column.

    Raises `GhostballError` if the table doesn't exist, or if the results can't be read.
    """
    if table not in TABLES:
        raise GhostballError(f"no table `{table}`. The tables are: {', '.join(TABLES)}")
    with reading(folder) as database:
        found = database.execute(TABLES[table])
        names = [column[0] for column in found.description]
        what = f"{folder}: a row of {table}"
        if table == "comparisons":
            cases = (record_of(_CASE, record, what) for (record,) in found)
            return [row for case in cases if (row := comparison_row(case))]
        return [_spread(dict(zip(names, row, strict=True)), what) for row in found]


def frame_of(folder: Path, table: str) -> Any:
    """Return a table as a polars data frame; see `Results.to_frame`.

    Raises `GhostballError` in the cases of `rows_of`, or if polars isn't installed.
    """
    try:
        import polars  # noqa: PLC0415 - an optional dependency
    except ImportError:
        raise GhostballError(
            "a data frame needs polars, which isn't installed. Install it with `pip install "
            "'.[frames]'` in a clone of Ghostball, or write files with `ghostball report DIR "
            "--export FOLDER`"
        ) from None
    # All rows determine the column types, because the first row may lack a value.
    return polars.DataFrame(
        [_flat(row) for row in rows_of(folder, table)], infer_schema_length=None
    )


def export(folder: Path, target: Path) -> list[Path]:
    """Write each table that has rows as JSON lines and as CSV; return the files.

    `target`: folder of the files; created if it doesn't exist.

    Raises `ResultsError` if the results can't be read, or if nothing can be written.
    """
    contents: dict[Path, str | bytes] = {}
    for table in TABLES:
        if rows := rows_of(folder, table):
            lines = (json.dumps(row, ensure_ascii=False) + "\n" for row in rows)
            contents[target / f"{table}.jsonl"] = "".join(lines)
            contents[target / f"{table}.csv"] = csv_of(rows)
    if not contents:
        raise ResultsError(f"{folder}: contains nothing to export")
    write_files(contents, "Choose another folder")
    return list(contents)


def _spread(row: dict[str, Any], what: str) -> dict[str, Any]:
    """Return a row with the column `record` replaced by the fields of the record."""
    record: dict[str, Any] = record_of(_RECORD, row.pop("record", "{}"), what)
    return {name: row[name] for name in row if name not in record} | record | row


def _flat(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row with lists and dicts encoded as JSON."""
    return {
        name: json.dumps(value) if isinstance(value, (dict, list)) else value
        for name, value in row.items()
    }


def csv_of(rows: list[dict[str, Any]]) -> str:
    """Return rows as CSV with a header; the columns are those of all rows, in their order."""
    if not rows:
        return ""
    text = io.StringIO()
    columns = list(dict.fromkeys(name for row in rows for name in row))
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(map(_flat, rows))
    return text.getvalue()
