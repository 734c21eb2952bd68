"""Ensembles in the database of a results folder: a row for each, and one for each member."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from pydantic import TypeAdapter

from ghostball.validation.ensembles.ensemble_record import (
    EnsembleRecord,
    EnsembleRun,
    EnsembleState,
    Members,
)
from ghostball.validation.ensembles.member import MemberResult
from ghostball.validation.ensembles.members import Stream
from ghostball.validation.results.database import (
    AGAIN,
    get_document,
    has_database,
    put_document,
    reading,
    record_of,
    transaction,
)
from ghostball.validation.results.fields import check_shape
from ghostball.validation.results.files import ResultsError

Key = tuple[str, str, Stream]
"""Scene, engine label and stream of an ensemble."""

_RUN: Final = TypeAdapter(EnsembleRun)
_RECORD: Final = TypeAdapter(EnsembleRecord)
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
            run: EnsembleRun = record_of(_RUN, text, f"{folder}: what its ensembles are of")
            records = [
                _with_failures(database, number, record)
                for number, record in _stored(database, "WHERE current")
                if record.scene in run.scenes and record.label in run.labels
            ]
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
        with reading(self.folder) as database:
            texts = database.execute(
                "SELECT members.record FROM members JOIN ensembles ON ensemble_id = id "
                "WHERE current AND (scene, label, stream) = (?, ?, ?) AND outcome = 'ended' "
                "AND number < ? ORDER BY number",
                [*record.key, self.run.count],
            ).fetchall()
        what = f"{self.folder}: a perturbed shot"
        balls = len(record.definition["balls"])
        found: list[MemberResult] = [record_of(_MEMBER, text, what) for (text,) in texts]
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


class EnsembleWriter:
    """Writes the ensembles of a run, each member as it comes; the folder must be reserved.

    Parameters
    ----------
    database : sqlite3.Connection
    run : EnsembleRun
    """

    def __init__(self, database: sqlite3.Connection, run: EnsembleRun) -> None:
        self._database = database
        self._run = run
        self._numbers: dict[Key, int] = {}

    def done_before(self, code: str, count: int) -> dict[str, frozenset[int]]:
        """Return which members the same code ran to their end, by the hash of the inputs."""
        done = {}
        for number, record in _stored(self._database, ""):
            if code and record.inputs_hash and record.code_hash == code:
                rows = self._database.execute(
                    "SELECT number FROM members WHERE ensemble_id = ? AND outcome = 'ended' "
                    "AND number < ?",
                    [number, count],
                )
                done[record.inputs_hash] = frozenset(index for (index,) in rows)
        return done

    def begin(self, records: Mapping[EnsembleRecord, bool]) -> None:
        """Start a run: what the same code found stays, for this run or a later one.

        Parameters
        ----------
        records : mapping of EnsembleRecord to bool
            What is to be run, and whether the members of an unchanged one are taken over.
        """
        with transaction(self._database):
            execute = self._database.execute
            stored: dict[str, int] = {}
            codes = {record.code_hash for record in records}
            for number, record in list(_stored(self._database, "")):
                if record.inputs_hash and record.code_hash in codes:
                    stored[record.inputs_hash] = number
                else:
                    execute("DELETE FROM ensembles WHERE id = ?", [number])
            execute("UPDATE ensembles SET current = 0")
            for record, taken_over in records.items():
                before = stored.get(record.inputs_hash)
                if before is not None and not taken_over:
                    execute("DELETE FROM ensembles WHERE id = ?", [before])
                if before is None or not taken_over:
                    before = execute(
                        "INSERT INTO ensembles (record, current) VALUES (?, 1)",
                        [_RECORD.dump_json(record).decode()],
                    ).lastrowid
                    assert before is not None
                execute("UPDATE ensembles SET current = 1 WHERE id = ?", [before])
                execute(
                    "DELETE FROM members WHERE ensemble_id = ? AND outcome != 'ended'", [before]
                )
                self._numbers[record.key] = before
            put_document(self._database, "ensembles", _RUN.dump_json(self._run))

    def write(self, result: MemberResult) -> None:
        """Add a member."""
        number = self._numbers[result.scene, result.label, result.stream]
        with transaction(self._database):
            self._database.execute(
                "INSERT INTO members (ensemble_id, record) VALUES (?, ?)",
                [number, _MEMBER.dump_json(result).decode()],
            )

    def refuse(self, record: EnsembleRecord) -> None:
        """Note of an ensemble that its engine can't run it."""
        with transaction(self._database):
            self._database.execute(
                "UPDATE ensembles SET record = ? WHERE id = ?",
                [_RECORD.dump_json(record).decode(), self._numbers[record.key]],
            )

    def finish(self, state: EnsembleState) -> None:
        """Note how the run ended."""
        with transaction(self._database):
            run = replace(self._run, state=state)
            put_document(self._database, "ensembles", _RUN.dump_json(run))


def _stored(database: sqlite3.Connection, which: str) -> Iterator[tuple[int, EnsembleRecord]]:
    for number, text in database.execute(f"SELECT id, record FROM ensembles {which}").fetchall():
        yield number, record_of(_RECORD, text, "an ensemble")


def _with_failures(
    database: sqlite3.Connection, number: int, record: EnsembleRecord
) -> EnsembleRecord:
    """Return an ensemble with what its members that came to no end say."""
    stopped: dict[str, str] = {}
    failed: dict[str, str] = {}
    for index, outcome, reason in database.execute(
        "SELECT number, outcome, json_extract(record, '$.reason') FROM members "
        "WHERE ensemble_id = ? AND outcome != 'ended' ORDER BY number",
        [number],
    ):
        (failed if outcome == "failed" else stopped)[str(index)] = reason
    return replace(record, stopped=stopped, failed=failed)


def _place(record: EnsembleRecord, run: EnsembleRun) -> tuple[int, int, str]:
    return run.scenes.index(record.scene), run.labels.index(record.label), record.stream
