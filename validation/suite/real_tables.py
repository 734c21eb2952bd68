"""Measure the agreement of engines with measured tables, and store it in the results folder."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from importlib.resources import files
from pathlib import Path
from typing import Final

from pydantic import TypeAdapter

from ghostball.reference_adapters import EngineUnavailableError, ReferenceEngine, make_engine
from ghostball.validation.measured.table_agreement import TableAgreement, agreement_with_tables
from ghostball.validation.parallel.pool import Done, Progress
from ghostball.validation.parallel.sources import is_ours
from ghostball.validation.results.database import (
    REMEDY,
    current_records,
    has_database,
    reading,
    record_of,
)
from ghostball.validation.results.files import ResultsError
from ghostball.validation.results.record_store import Name, RecordStore
from ghostball.validation.runs.engine_runs import in_other_process, run_engine
from ghostball.validation.runs.runner import Ran, run
from ghostball.validation.suite.case import plain_settings
from ghostball.validation.suite.unchanged import code_hash, hash_of

_AGREEMENT: Final = TypeAdapter(TableAgreement)


class AgreementWriter(RecordStore[TableAgreement, TableAgreement]):
    """Store the agreement of each engine with measured tables."""

    kind = "likeness"
    adapter = _AGREEMENT
    what = "comparisons with measured tables"

    def name_of(self, record: TableAgreement) -> Name:
        """Return the label."""
        return (record.label,)

    def is_repeatable(self, record: TableAgreement) -> bool:
        """Return True if running again would give the same result: no crash, no time limit."""
        return not any(family.failed for family in record.families)


def measure_agreements(
    specs: Sequence[str],
    folder: Path,
    time_limit: float | None,
    *,
    reuse: bool = False,
    progress: Progress[TableAgreement] | None = None,
) -> Ran[TableAgreement]:
    """Return the agreement of each installed engine with measured tables, and store it in a folder.

    Stored results of engines that aren't in `specs` are no longer shown.

    `time_limit` [s]: for each shot, which then runs in another process.
    `reuse`, `progress`: see `suite.run_suite`, with engines in place of cases.

    After Ctrl-C, finished results are kept, and the returned value says that the run was
    interrupted.
    """
    engines: dict[Name, ReferenceEngine] = {}
    for spec in specs:
        with suppress(EngineUnavailableError):
            engines[(spec,)] = make_engine(spec)
    ran = run(
        {name: _key(name[0], engine) for name, engine in engines.items()},
        lambda names: (name[0] for name in names),
        partial(_measure, time_limit=time_limit),
        _given,
        AgreementWriter(folder, code_hash()),
        reuse=reuse,
        progress=progress,
    )
    in_order = {name: ran.records[name] for name in engines if name in ran.records}
    return replace(ran, records=in_order)


def load_agreements(folder: Path) -> list[TableAgreement]:
    """Return the stored agreement of the last run in a folder; empty if there is none.

    Raises `ResultsError` if it can't be read.
    """
    if not has_database(folder):
        return []
    with reading(folder) as database:
        rows = current_records(database, AgreementWriter.kind)
    what = f"{folder}: {AgreementWriter.what}"
    found: list[TableAgreement] = [record_of(_AGREEMENT, text, what) for text, _ in rows]
    if len({tuple(family.name for family in one.families) for one in found}) > 1:
        raise ResultsError(f"{what} are damaged: engines have different families. {REMEDY}")
    return found


def _measure(spec: str, time_limit: float | None) -> TableAgreement:
    engine = make_engine(spec)
    with in_other_process(engine, time_limit) as player:
        return agreement_with_tables(spec, engine, partial(run_engine, player))


def _given(done: Done[str, TableAgreement]) -> TableAgreement:
    """Return the result of a task, which always exists, because tasks run in this process."""
    assert done.given is not None
    return done.given


def _key(spec: str, engine: ReferenceEngine) -> str:
    """Return the hash of all inputs of an engine's figures besides the code.

    Returns "" for an engine of another package, because its code is unknown.
    """
    return hash_of([spec, plain_settings(engine), _known()]) if is_ours(spec) else ""


@cache
def _known() -> list[str]:
    """Return the texts of the measured data, and of the best settings found."""
    folder = Path(str(files("ghostball.validation.measured")))
    return [path.read_text(encoding="utf-8") for path in sorted(folder.rglob("*.toml"))]
