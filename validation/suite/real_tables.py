"""How like a real table the engines of a run can be made to play; kept beside its results."""

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
from ghostball.validation.measured.likeness import Likeness, likeness
from ghostball.validation.parallel.pool import Done, Progress
from ghostball.validation.parallel.sources import is_ours
from ghostball.validation.results.database import (
    AGAIN,
    current_records,
    has_database,
    reading,
    record_of,
)
from ghostball.validation.results.files import ResultsError
from ghostball.validation.results.record_store import Name, RecordStore
from ghostball.validation.runs.playing import in_other_process, run_engine
from ghostball.validation.runs.runner import Ran, run
from ghostball.validation.suite.case import plain_settings
from ghostball.validation.suite.unchanged import code_hash, hash_of

_LIKENESS: Final = TypeAdapter(Likeness)


class LikenessWriter(RecordStore[Likeness, Likeness]):
    """Writes what each engine makes of what was measured on real tables."""

    kind = "likeness"
    adapter = _LIKENESS
    what = "comparisons with measured tables"

    def name_of(self, record: Likeness) -> Name:
        """Return the label."""
        return (record.label,)

    def stands(self, record: Likeness) -> bool:
        """Whether the engine would come to the same again: not where it crashed or hung."""
        return not any(family.failed for family in record.families)


def measure_likenesses(
    specs: Sequence[str],
    folder: Path,
    time_limit: float | None,
    *,
    reuse: bool = False,
    progress: Progress[Likeness] | None = None,
) -> Ran[Likeness]:
    """Return how like a real table each engine that is here can be, and keep it in a folder.

    What an earlier run kept of other engines isn't shown any more.

    `time_limit` [s]: for each shot, which then runs in another process.
    `reuse`, `progress`: see `suite.run_suite`: of engines in place of cases.

    Interrupted by Ctrl-C, it keeps what is done and says so in what is returned.
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
        LikenessWriter(folder, code_hash()),
        reuse=reuse,
        progress=progress,
    )
    in_order = {name: ran.records[name] for name in engines if name in ran.records}
    return replace(ran, records=in_order)


def load_likenesses(folder: Path) -> list[Likeness]:
    """Return what the last run kept in its folder; none where it kept nothing.

    Raises `ResultsError` where it can't be read.
    """
    if not has_database(folder):
        return []
    with reading(folder) as database:
        rows = current_records(database, LikenessWriter.kind)
    what = f"{folder}: {LikenessWriter.what}"
    found: list[Likeness] = [record_of(_LIKENESS, text, what) for text, _ in rows]
    if len({tuple(family.name for family in one.families) for one in found}) > 1:
        raise ResultsError(f"{what} are damaged: engines have different families. {AGAIN}")
    return found


def _measure(spec: str, time_limit: float | None) -> Likeness:
    engine = make_engine(spec)
    with in_other_process(engine, time_limit) as player:
        return likeness(spec, engine, partial(run_engine, player))


def _given(done: Done[str, Likeness]) -> Likeness:
    """Return what was measured; it crashes no process, for every shot has one of its own."""
    assert done.given is not None
    return done.given


def _key(spec: str, engine: ReferenceEngine) -> str:
    """Return the hash of all that an engine's figures depend on besides the code.

    "" of an engine that others bring, whose code nobody knows.
    """
    return hash_of([spec, plain_settings(engine), _known()]) if is_ours(spec) else ""


@cache
def _known() -> list[str]:
    """Return what was measured, and the best settings that were sought."""
    folder = Path(str(files("ghostball.validation.measured")))
    return [path.read_text(encoding="utf-8") for path in sorted(folder.rglob("*.toml"))]
