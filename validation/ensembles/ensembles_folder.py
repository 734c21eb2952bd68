"""Ensembles in the database of a results folder: what is asked, and a record of each member."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from pydantic import TypeAdapter

from ghostball.validation.ensembles.ensemble_record import (
    EnsembleRecord,
    EnsembleRun,
    Members,
)
from ghostball.validation.ensembles.member import MemberResult
from ghostball.validation.ensembles.members import Stream
from ghostball.validation.results.database import (
    AGAIN,
    get_document,
    has_database,
    name_text,
    reading,
    record_of,
)
from ghostball.validation.results.fields import check_shape
from ghostball.validation.results.files import ResultsError
from ghostball.validation.results.record_store import Name, RecordStore

RUN: Final = TypeAdapter(EnsembleRun)
_MEMBER: Final = TypeAdapter(MemberResult)


@dataclass(frozen=True, eq=False)
class Ensembles:
    """The ensembles of a results folder, read back.

    Attributes
    ----------
    folder : Path
    run : EnsembleRun
    records : list of EnsembleRecord
        Scene by scene, engine by engine.
    """

    folder: Path
    run: EnsembleRun
    records: list[EnsembleRecord]

    @classmethod
    def load(cls, folder: str | Path) -> Ensembles | None:
        """Read the ensembles of a results folder, or return None where it has none.

        Raises
        ------
        ResultsError
            Where they can't be read.
        """
        path = Path(folder)
        if not has_database(path):
            return None
        with reading(path) as database:
            text = get_document(database, "ensembles")
            if text is None:
                return None
            run: EnsembleRun = record_of(RUN, text, f"{folder}: what its ensembles are of")
        records = [_with_members(path, record) for record in run.ensembles]
        records.sort(key=lambda record: _place(record, run))
        return cls(path, run, records)

    def of(self, scene: str, stream: Stream = "shots") -> dict[str, EnsembleRecord]:
        """Return the ensembles of a scene by engine label, in the order of the run."""
        return {
            record.label: record
            for record in self.records
            if (record.scene, record.stream) == (scene, stream)
        }

    def members(self, record: EnsembleRecord) -> Members:
        """Return what the members that came to their end did, of those that the run asked for.

        Raises
        ------
        ResultsError
            Where they can't be read.
        """
        found = [one for one in _members_of(self.folder, record) if one.outcome == "ended"]
        what = f"{self.folder}: a perturbed shot"
        balls = len(record.definition["balls"])
        for one in found:
            try:
                if one.rest_positions is None or one.energy is None or one.rest_time is None:
                    raise ValueError("it ended, and holds no end")
                check_shape("rest_positions", one.rest_positions, (balls, 2))
                check_shape("energy", one.energy, record.times.shape)
                check_shape("counts", np.array(one.counts, dtype=np.float64), (2,))
            except ValueError as error:
                raise ResultsError(f"{what} is damaged: {error}. {AGAIN}") from None
        return members_of(found, balls)


def members_of(ended: list[MemberResult], balls: int) -> Members:
    """Return members that came to their end, in order of their numbers, as arrays."""
    if not ended:
        return Members.none(balls)
    return Members(
        np.array([one.index for one in ended], dtype=np.int64),
        np.array([one.rest_positions for one in ended], dtype=np.float64),
        np.array([one.rest_time for one in ended], dtype=np.float64),
        np.array([one.counts for one in ended], dtype=np.int64),
        np.array([one.energy for one in ended], dtype=np.float64),
    )


class EnsembleWriter(RecordStore[MemberResult, MemberResult]):
    """Writes the members of a run, each as it comes."""

    kind = "member"
    adapter = _MEMBER
    what = "a perturbed shot"
    document = "ensembles"

    def name_of(self, record: MemberResult) -> Name:
        """Return of which ensemble it is, what was asked of that, and its number."""
        return *record.ensemble, record.inputs, str(record.index)

    def stands(self, record: MemberResult) -> bool:
        """Whether it came to its end."""
        return record.outcome == "ended"


def _with_members(folder: Path, record: EnsembleRecord) -> EnsembleRecord:
    """Return an ensemble with what its members that came to no end say."""
    found = _members_of(folder, record)
    unended = [one for one in found if one.outcome != "ended"]
    refused = [one for one in found if one.outcome in ("not-representable", "unavailable")]
    if refused and refused == found:
        outcome: Any = found[0].outcome
        return replace(record, outcome=outcome, reason=found[0].reason)
    return replace(
        record,
        stopped={str(one.index): one.reason for one in unended if one.outcome != "failed"},
        failed={str(one.index): one.reason for one in unended if one.outcome == "failed"},
    )


def _members_of(folder: Path, record: EnsembleRecord) -> list[MemberResult]:
    """Return what became of the members that the run asked for, in order of their numbers."""
    start = name_text(record.key).removesuffix("]") + ","
    with reading(folder) as database:
        texts = database.execute(
            "SELECT record FROM records WHERE kind = 'member' AND current AND name > ? "
            "AND name < ?",
            [start, start + chr(sys.maxunicode)],
        ).fetchall()
    found = [record_of(_MEMBER, text, f"{folder}: a perturbed shot") for (text,) in texts]
    return sorted(found, key=lambda one: one.index)


def _place(record: EnsembleRecord, run: EnsembleRun) -> tuple[int, int, str]:
    return run.scenes.index(record.scene), run.labels.index(record.label), record.stream
