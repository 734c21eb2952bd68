"""Ensembles in a results folder.

    ensembles.jsonl    what the run was asked for, then one JSON object per ensemble, one per line
    ensembles/*.npz    what the members of each did

Both are written anew, whole, as members are done: first arrays under a name of their own, then the
lines that name them, in one step. So a run that is interrupted or killed leaves files that read
back, and one that is cut short or damaged all the same is refused with its place.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

import numpy as np
from pydantic import TypeAdapter

from validation.ensembles.ensemble_record import (
    FORMAT,
    SCHEMA,
    EnsembleRecord,
    EnsembleRun,
    EnsembleState,
    Members,
)
from validation.ensembles.members import Stream
from validation.results.files import (
    ResultsError,
    cannot_write,
    hash_of_file,
    parse_line,
    read_whole_lines,
    write_whole,
    write_whole_lines,
)

ENSEMBLES_FILE: Final = "ensembles.jsonl"
ENSEMBLES_FOLDER: Final = "ensembles"

Key = tuple[str, str, Stream]
"""Scene, engine label and stream of an ensemble."""

_RUN: Final = TypeAdapter(EnsembleRun)
_RECORD: Final = TypeAdapter(EnsembleRecord)
_AGAIN: Final = "Move it away, or choose another `--out`, and run `validate --ensemble` again"


@dataclass(frozen=True, eq=False)
class Ensembles:
    """The ensembles of a results folder, read back.

    Attributes
    ----------
    folder : Path
    run : EnsembleRun
    records : list of EnsembleRecord
        Those of the run; scene by scene, engine by engine.
    kept : list of EnsembleRecord
        Those of earlier runs that a later one may take over.
    """

    folder: Path
    run: EnsembleRun
    records: list[EnsembleRecord]
    kept: list[EnsembleRecord]

    @classmethod
    def load(cls, folder: str | Path) -> Ensembles | None:
        """Read the ensembles of a results folder, or return None where it has none.

        Raises
        ------
        ResultsError
            Where they are cut short, damaged, or of another schema version.
        """
        path = Path(folder) / ENSEMBLES_FILE
        lines = read_whole_lines(path, _AGAIN)
        if lines is None:
            return None
        if not lines:
            raise ResultsError(f"{path}: is empty. {_AGAIN}")
        run: EnsembleRun = parse_line(_RUN, lines[0], f"{path}:1", SCHEMA, _AGAIN)
        if run.format != FORMAT:
            raise ResultsError(f"{path}:1: not ensembles of ours. {_AGAIN}")
        records: list[EnsembleRecord] = [
            parse_line(_RECORD, line, f"{path}:{number}", SCHEMA, _AGAIN)
            for number, line in enumerate(lines[1:], 2)
        ]
        if len(records) != run.records:
            raise ResultsError(
                f"{path}: is cut short: {run.records} ensembles were written, {len(records)} are "
                f"there. {_AGAIN}"
            )
        own = [record for record in records if not record.kept]
        for record in own:
            if record.scene not in run.scenes or record.label not in run.labels:
                raise ResultsError(
                    f'{path}: `{record.label}` in scene "{record.scene}" is there, but the first '
                    f"line doesn't ask for it. {_AGAIN}"
                )
        own.sort(key=lambda record: _place(record, run))
        return cls(path.parent, run, own, [record for record in records if record.kept])

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
            Where their file is missing or damaged.
        """
        return load_members(self.folder, record).below(self.run.count)


def load_members(folder: Path, record: EnsembleRecord) -> Members:
    """Read the arrays of an ensemble.

    Raises
    ------
    ResultsError
        Where their file is missing or damaged.
    """
    if record.arrays is None:
        return Members.none(len(record.definition["balls"]))
    path = folder / record.arrays
    try:
        content = path.read_bytes()
        if sha256(content).hexdigest() != record.arrays_hash:
            raise ValueError("it isn't what was written")
        with np.load(io.BytesIO(content), allow_pickle=False) as stored:
            return Members(*(stored[part.name] for part in fields(Members)))
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise ResultsError(
            f"{path}: can't read what the members of `{record.label}` in scene "
            f'"{record.scene}" did: {error}. {_AGAIN}'
        ) from error


class EnsembleWriter:
    """Writes the ensembles of a run as their members come.

    The folder must be reserved: see `ResultsWriter.reserved`.

    Parameters
    ----------
    folder : Path
    run : EnsembleRun
    kept : iterable of EnsembleRecord
        Of earlier runs, to be kept as they are.
    """

    def __init__(self, folder: Path, run: EnsembleRun, kept: Iterable[EnsembleRecord]) -> None:
        self._folder = folder
        self._run = run
        self._kept = [replace(record, kept=True) for record in kept]
        self._records: dict[Key, EnsembleRecord] = {}
        self._unwritten: dict[Key, Members] = {}

    def put(self, record: EnsembleRecord, members: Members | None) -> None:
        """Take an ensemble as it is now, in place of what it was; None: its file is as it was."""
        self._records[record.key] = record
        if members is not None:
            self._unwritten[record.key] = members

    def write(self, state: EnsembleState) -> None:
        """Write all that was put.

        Raises
        ------
        ResultsError
            Where the folder can't be written.
        """
        try:
            (self._folder / ENSEMBLES_FOLDER).mkdir(exist_ok=True)
            for key, members in self._unwritten.items():
                self._records[key] = self._with_arrays(self._records[key], members)
            self._unwritten.clear()
            records = [*self._records.values(), *self._kept]
            run = replace(self._run, state=state, records=len(records))
            lines = [_RUN.dump_json(run), *map(_RECORD.dump_json, records)]
            write_whole_lines(self._folder / ENSEMBLES_FILE, lines)
            self._drop_stray({record.arrays for record in records})
        except OSError as error:
            raise cannot_write(self._folder, error) from error

    def _with_arrays(self, record: EnsembleRecord, members: Members) -> EnsembleRecord:
        if not len(members):
            return replace(record, arrays=None, arrays_hash="")
        buffer = io.BytesIO()
        arrays: Mapping[str, Any] = {
            part.name: getattr(members, part.name) for part in fields(Members)
        }
        np.savez_compressed(buffer, **arrays)
        content = buffer.getvalue()
        digest = sha256(content).hexdigest()
        slug = re.sub(r"[^A-Za-z0-9.+-]+", "-", "--".join(record.key))
        # Part of its hash in its name: what a line names is never overwritten.
        name = f"{ENSEMBLES_FOLDER}/{slug}-{digest[:12]}.npz"
        write_whole(self._folder / name, content)
        return replace(record, arrays=name, arrays_hash=digest)

    def _drop_stray(self, named: set[str | None]) -> None:
        for path in (self._folder / ENSEMBLES_FOLDER).iterdir():
            stray = f"{ENSEMBLES_FOLDER}/{path.name}" not in named
            if stray and path.suffix in (".npz", ".part"):
                path.unlink()


def arrays_are_whole(folder: Path, record: EnsembleRecord) -> bool:
    """Whether the arrays of an ensemble are there as they were written."""
    if record.arrays is None:
        return True
    try:
        return hash_of_file(folder / record.arrays) == record.arrays_hash
    except OSError:
        return False


def _place(record: EnsembleRecord, run: EnsembleRun) -> tuple[int, int, str]:
    return run.scenes.index(record.scene), run.labels.index(record.label), record.stream
