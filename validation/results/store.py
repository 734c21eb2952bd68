"""The results folder of a run; reports need nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

from pydantic import AfterValidator, Field, NonNegativeInt, TypeAdapter

from ghostball.model.scene.fields import SceneName
from ghostball.validation.results.database import (
    current_records,
    documents_in,
    get_document,
    reading,
    record_of,
)
from ghostball.validation.results.fields import Environment
from ghostball.validation.results.files import ResultsError
from ghostball.validation.results.motions import motion_of_case, put_motion
from ghostball.validation.results.quantities import listed
from ghostball.validation.results.record_store import RecordStore, RunState
from ghostball.validation.results.records import (
    CERTIFIED,
    CLOSED_FORM,
    COMPLETE_STATUSES,
    INDEPENDENT,
    INTEGRATION,
    OUR_ENGINE,
    CaseRecord,
    Check,
    Motion,
)
from ghostball.validation.results.tables import frame_of

if TYPE_CHECKING:
    import sqlite3

__all__ = [
    "CERTIFIED",
    "CLOSED_FORM",
    "INDEPENDENT",
    "INTEGRATION",
    "OUR_ENGINE",
    "CaseRecord",
    "Check",
    "Motion",
    "Results",
    "ResultsError",
    "ResultsWriter",
    "has_results",
]

LISTED = 6
"""Number of engines that the `repr` of results names."""

Pair = tuple[str, str]
"""The name of a scene and the label of an engine."""

Finished = tuple[CaseRecord, Motion | None]
"""A finished case, and the motion that is stored with it."""


class _Suite(Environment):
    """The fields of a run's options and state that are read."""

    run: str = ""
    state: RunState
    scenes: tuple[SceneName, ...] = ()
    engines: tuple[str, ...] = ()
    engine_settings: dict[str, dict[str, Any] | None] = Field(default_factory=dict)
    metrics: tuple[str, ...] = ()
    planned: NonNegativeInt | None = None


def _as_suite(values: dict[str, Any]) -> dict[str, Any]:
    _Suite.model_validate(values)
    return values


def _of_one_scene(case: CaseRecord) -> CaseRecord:
    """Refuse a case with a definition of another scene."""
    if case.definition["name"] != case.scene:
        raise ValueError(f"`definition.name` must be {case.scene!r}, the name of its scene")
    return case


_RECORD: Final = TypeAdapter(Annotated[CaseRecord, AfterValidator(_of_one_scene)])
_SUITE: Final = TypeAdapter(Annotated[dict[str, Any], AfterValidator(_as_suite)])


@dataclass(frozen=True, eq=False)
class Results:
    """Stored results of a run.

    Attributes
    ----------
    path : Path
        Of the folder.
    cases : list of CaseRecord
        In order of completion; without ensemble members.
    varied : list of CaseRecord
        The ensemble members.
    environment : dict
        Machine, versions, command line, ..., the options of the run, and how it ended.
    """

    path: Path
    cases: list[CaseRecord]
    environment: dict[str, Any]
    varied: list[CaseRecord] = field(default_factory=list)

    def __repr__(self) -> str:
        """Return folder, state, and what was run, in a few lines; cases are counted."""
        varied = f", {len(self.varied)} of perturbed initial states" if self.varied else ""
        return (
            f"<Results in {str(self.path)!r}: {self.environment.get('state', 'unknown')}, "
            f"{len(self.cases)} cases{varied}: {len(self.scene_names)} scenes on "
            f"{listed(self.labels, LISTED)}>"
        )

    @classmethod
    def open(cls, path: str | Path) -> Results:
        """Read the results in a folder.

        Raises
        ------
        ResultsError
            If there are none, or if the database is cut short, damaged or of another version.
        """
        folder = Path(path)
        with reading(folder) as database:
            environment = get_document(database, "suite")
            rows = current_records(database, "case")
        if environment is None:
            raise ResultsError(
                f"{folder}: contains no results. Run `ghostball validate --out {path}`"
            )
        what = f"{folder}: a case"
        found = [_case_of(what, *row) for row in rows]
        cases = [case for case in found if not case.varied_from]
        varied = [case for case in found if case.varied_from]
        asked: dict[str, Any] = record_of(_SUITE, environment, f"{folder}: the options of its run")
        return cls(folder, cases, asked, varied)

    @property
    def state(self) -> RunState:
        """How the run ended: "complete" or "interrupted"; "running" also if the run was killed."""
        state: RunState = self.environment["state"]
        return state

    @property
    def planned(self) -> int:
        """Number of planned cases; of present cases if the number wasn't stored."""
        asked = [len(self.environment.get(key, ())) for key in ("scenes", "engines")]
        planned: int = self.environment.get("planned", asked[0] * asked[1])
        return max(planned, len(self.cases) + len(self.varied))

    @property
    def scene_names(self) -> list[str]:
        """Scenes that have a case, in the order of the command."""
        return self._in_order("scenes", [case.scene for case in self.cases])

    @property
    def labels(self) -> list[str]:
        """Engines that have a case, in the order of the command."""
        return self._in_order("engines", [case.label for case in self.cases])

    def case(self, scene: str, label: str) -> CaseRecord | None:
        """Return the case of a scene and an engine label, or None if there is none."""
        for case in self.cases:
            if case.scene == scene and case.label == label:
                return case
        return None

    def by_scene(self) -> Iterator[tuple[str, list[CaseRecord | None]]]:
        """Yield each scene with its case on each engine, in the order of `labels`."""
        for scene in self.scene_names:
            yield scene, [self.case(scene, label) for label in self.labels]

    def motion(self, case: CaseRecord) -> Motion | None:
        """Read the sampled motion of a case, or None if the case did not run.

        Raises
        ------
        ResultsError
            If it is damaged.
        """
        return motion_of_case(self.path, case.scene, case.label)

    def to_frame(self, table: str = "cases") -> Any:
        """Return a table as a polars data frame.

        Parameters
        ----------
        table : str
            One of `validation.results.tables.TABLES`, such as "cases", "checks" or "events".

        Raises
        ------
        GhostballError
            If the table doesn't exist, or if polars isn't installed.
        """
        return frame_of(self.path, table)

    def _in_order(self, key: str, present: list[str]) -> list[str]:
        asked = [str(name) for name in self.environment.get(key, ())]
        return [name for name in dict.fromkeys(asked + present) if name in set(present)]


class ResultsWriter(RecordStore[Finished, CaseRecord]):
    """Writes the cases of a run of the suite, each with its motion."""

    kind = "case"
    adapter = _RECORD
    what = "a case"
    document = "suite"

    def record_of(self, given: Finished) -> CaseRecord:
        """Return the case without its motion."""
        return given[0]

    def name_of(self, record: CaseRecord) -> Pair:
        """Return scene and label."""
        return record.scene, record.label

    def is_repeatable(self, record: CaseRecord) -> bool:
        """Return True if running the case again would give the same result."""
        return record.outcome == "not-representable" or (
            record.outcome == "ran" and record.status in COMPLETE_STATUSES
        )

    def reused(self, record: CaseRecord) -> CaseRecord:
        """Return the case, marked as measured by an earlier run."""
        return replace(record, reused=True)

    def forget(self, database: sqlite3.Connection) -> None:
        """Remove the stored comparisons with baselines: they were made from earlier results."""
        database.execute("DELETE FROM documents WHERE name = 'regression'")

    def put_beside(self, database: sqlite3.Connection, number: int, given: Finished) -> None:
        """Store the motion."""
        if given[1] is not None:
            put_motion(database, given[1], record_id=number)


class PartWriter(ResultsWriter):
    """Writes some of the cases in a folder: other cases of the same code are kept."""

    others_stay = True


def has_results(folder: Path) -> bool:
    """Return True if a folder holds results of the suite.

    Raises `ResultsError` if its database is cut short, damaged or of another version.
    """
    return "suite" in documents_in(folder)


def _case_of(what: str, text: str, reused: bool) -> CaseRecord:
    case: CaseRecord = record_of(_RECORD, text, what)
    return replace(case, reused=True) if reused else case
