"""A results folder: what one run of the suite found, complete enough to report from alone.

    results.jsonl    one JSON object per case (scene x engine), one per line, in order of completion
    motion/*.npz     events and sampled motion of each case that ran
    earlier.jsonl    cases of earlier runs that this one hasn't replaced, as they were: no part of
                     its results, but a later run may find that they are unchanged
    env.json         machine, versions, revision, command line, and how the run ended
    regression.json  what moved since another state of our engine: `validation.baselines`
    ensembles*       what perturbed shots did, where that was asked for: `validation.ensembles`
    .lock            empty, and locked while a run writes; no part of the results

A line is written whole and flushed before the next case, and `env.json` is replaced in one step, so
a run that is interrupted or killed leaves a folder that reads back. What earlier runs found is put
by in `earlier.jsonl` before anything is replaced, and no file of motion that a line names is ever
overwritten. Only the last line may be cut short, by a kill in the midst of it: it is left out, and
`ResultsFolder.cut_short` names it. Any other damage is an error that names its place.
"""

from __future__ import annotations

import json
import re
import tempfile
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import MISSING, dataclass, fields, replace
from pathlib import Path
from typing import Any, Literal, TextIO

import numpy as np
from filelock import FileLock, Timeout

from validation.results.files import (
    EARLIER_FILE,
    ENVIRONMENT_FILE,
    FORMAT,
    LOCK_FILE,
    MOTION_FOLDER,
    REGRESSION_FILE,
    RESULTS_FILE,
    ResultsError,
    cannot_write,
    is_results_folder,
    line_of,
    load_cases,
    load_environment,
    save_motion,
    write_lines,
    write_whole,
)
from validation.results.records import (
    CERTIFIED,
    CLOSED_FORM,
    INDEPENDENT,
    OUR_ENGINE,
    SCHEMA,
    CaseRecord,
    Check,
    Motion,
)

__all__ = [
    "CERTIFIED",
    "CLOSED_FORM",
    "INDEPENDENT",
    "OUR_ENGINE",
    "SCHEMA",
    "CaseRecord",
    "Check",
    "Motion",
    "ResultsError",
    "ResultsFolder",
    "ResultsWriter",
    "is_results_folder",
    "read_earlier",
]

RunState = Literal["running", "complete", "interrupted", "killed"]


@dataclass(frozen=True, eq=False)
class ResultsFolder:
    """A folder read back.

    Attributes
    ----------
    path : Path
    cases : list of CaseRecord
        In order of completion.
    environment : dict
        Machine, versions, command line ...: the content of `env.json`.
    cut_short : str
        File and number of a last line that was left out, being cut short; "" where none was.
    """

    path: Path
    cases: list[CaseRecord]
    environment: dict[str, Any]
    cut_short: str = ""

    @classmethod
    def load(cls, path: str | Path) -> ResultsFolder:
        """Read a results folder.

        Raises
        ------
        ResultsError
            Where it is missing, is no results folder, has another schema version, or is damaged
            elsewhere than in the last line of its results.
        """
        folder = Path(path)
        if not folder.is_dir():
            raise ResultsError(
                f"{folder}: no such results folder. Make one with `ghostball validate --out {path}`"
            )
        environment = load_environment(folder)
        if environment is None:
            raise ResultsError(
                f"{folder}: not a results folder: it has no {ENVIRONMENT_FILE} of ours. Name the "
                "folder that `ghostball validate --out` wrote"
            )
        cases, cut_short = load_cases(folder / RESULTS_FILE)
        return cls(folder, cases, environment, cut_short)

    @property
    def state(self) -> RunState:
        """How the run ended: "complete", "interrupted", "killed" or "running".

        A run that was killed between two lines is still "running": nothing tells it apart.
        """
        if self.cut_short:
            return "killed"
        state: RunState = self.environment["state"]
        return state

    @property
    def planned(self) -> int:
        """How many cases there would have been; those that are there where nothing says."""
        asked = [len(self.environment.get(key, ())) for key in ("scenes", "engines")]
        return asked[0] * asked[1] or len(self.cases)

    @property
    def scene_names(self) -> list[str]:
        """Scenes in the order in which the run was asked for them; only those with a case."""
        return self._in_order("scenes", [case.scene for case in self.cases])

    @property
    def labels(self) -> list[str]:
        """Engines in the order in which the run was asked for them; only those with a case."""
        return self._in_order("engines", [case.label for case in self.cases])

    def case(self, scene: str, label: str) -> CaseRecord | None:
        """Return the case of a scene and an engine label, or None where there is none."""
        for case in self.cases:
            if case.scene == scene and case.label == label:
                return case
        return None

    def motion(self, case: CaseRecord) -> Motion | None:
        """Read the sampled motion of a case, or None where it did not run.

        Raises
        ------
        ResultsError
            Where its file is missing or damaged.
        """
        if case.motion is None:
            return None
        path = self.path / case.motion
        try:
            # np.load leaks the file that it opens itself where the archive is damaged.
            with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
                parts = (
                    part.name
                    for part in fields(Motion)
                    if part.default is MISSING or part.name in stored
                )
                return Motion(**{name: stored[name] for name in parts})
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            raise ResultsError(
                f"{path}: can't read the motion of `{case.label}` in scene "
                f'"{case.scene}": {error}. Run the suite again'
            ) from error

    def _in_order(self, key: str, present: list[str]) -> list[str]:
        asked = [str(name) for name in self.environment.get(key, ())]
        return [name for name in dict.fromkeys(asked + present) if name in set(present)]


class ResultsWriter:
    """Writes a results folder, case by case.

    Making one checks that the folder may be used and can be written, and changes nothing in it; a
    folder with earlier results of ours keeps them until `begin`. From there, or from `reserved`, to
    `finish` no other writer, of this process or another, gets into the folder. The operating system
    ends the lock with the process, however that ends.

    Raises
    ------
    ResultsError
        Where the path is no folder, can't be made or written, or holds something else.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._file: TextIO | None = None
        self._names: set[str] = set()  # files of motion that there are
        self._kept: set[str] = set()  # those of them that the results name
        self._environment: dict[str, Any] = {}
        self._earlier: dict[tuple[str, str], CaseRecord] = {}
        self._taken_over: Sequence[CaseRecord] = ()
        self._begun = self._finished = False
        # Held by this writer, not by a thread: another one may finish what one began.
        self._lock = FileLock(self.path / LOCK_FILE, timeout=0, thread_local=False)
        self._prepare()

    @property
    def begun(self) -> bool:
        """Whether earlier results gave way to those of this run, be they none so far."""
        return self._begun

    @contextmanager
    def reserved(self) -> Iterator[None]:
        """Keep other writers out, from before the folder is read: what was read stays true.

        Raises
        ------
        ResultsError
            Where another one is in it.
        """
        self._acquire()
        try:
            yield
        finally:
            self._lock.release(force=True)

    def begin(
        self,
        environment: Mapping[str, Any],
        *,
        taken_over: Sequence[CaseRecord] = (),
        earlier: Iterable[CaseRecord] = (),
    ) -> None:
        """Start anew in the folder: earlier results of ours go, `env.json` is written.

        Parameters
        ----------
        environment : mapping
        taken_over : sequence of CaseRecord
            Cases of earlier runs that are results of this one too; their motion stays.
        earlier : iterable of CaseRecord
            What `read_earlier` returned: put by until `finish`.

        Raises
        ------
        ResultsError
            Where another run writes into the folder, or it can't be written.
        """
        self._acquire()
        self._environment = {"format": FORMAT, "schema": SCHEMA, **environment, "state": "running"}
        self._earlier = {(case.scene, case.label): case for case in earlier}
        self._taken_over = taken_over
        self._kept = {case.motion for case in taken_over if case.motion is not None}
        try:
            # First what was there is put by, so that a kill from here on loses nothing of it.
            self._put_by()
            # From here on an interrupt leaves the rest to `finish`.
            self._begun = True
            # env.json comes last to go and first to come: the folder stays recognisably ours.
            (self.path / RESULTS_FILE).unlink(missing_ok=True)
            (self.path / REGRESSION_FILE).unlink(missing_ok=True)  # of other results than these
            self._write_environment()
            (self.path / MOTION_FOLDER).mkdir(exist_ok=True)
            self._drop_motion()
            self._start_results()
        except OSError as error:
            raise cannot_write(self.path, error) from error

    def write(self, record: CaseRecord, motion: Motion | None) -> CaseRecord:
        """Append a case; return it with the name and the hash of its motion file.

        `begin` must have been called.
        """
        assert self._file is not None, "begin() comes first"
        try:
            if motion is not None:
                name = self._motion_name(record)
                digest = save_motion(self.path / name, motion)
                # Before its line: an interrupt between the two must not part them.
                self._kept.add(name)
                record = replace(record, motion=name, motion_hash=digest)
            self._file.write(line_of(record))
            self._file.flush()
        except OSError as error:
            raise cannot_write(self.path, error) from error
        self._earlier.pop((record.scene, record.label), None)
        return record

    def finish(
        self, state: RunState, *, still_of_use: Callable[[CaseRecord], bool] | None = None
    ) -> None:
        """Close the folder, note in `env.json` how the run ended, and let other runs in.

        Where the run never began, the folder stays as it was. Where an interrupt cut `begin` short,
        the rest of it is done here, so that the folder reads back.

        Parameters
        ----------
        state : RunState
        still_of_use : callable, optional
            Which of the earlier cases that this run hasn't replaced stay put by; all of them where
            it is left out.
        """
        try:
            if self._begun and not self._finished:
                self._finish(state, still_of_use)
        except OSError as error:
            raise cannot_write(self.path, error) from error
        finally:
            self._lock.release()  # what `begin` took: `reserved` may still hold it

    def _finish(self, state: RunState, still_of_use: Callable[[CaseRecord], bool] | None) -> None:
        if self._file is None:
            (self.path / MOTION_FOLDER).mkdir(exist_ok=True)
            self._start_results()
        assert self._file is not None
        self._file.close()
        self._file = None
        self._finished = True
        self._environment["state"] = state
        if still_of_use is not None:
            self._earlier = {
                pair: case for pair, case in self._earlier.items() if still_of_use(case)
            }
        self._write_environment()
        self._put_by()
        self._drop_motion()

    def _acquire(self) -> None:
        try:
            self._lock.acquire()  # counted: within `reserved` it is held twice
        except Timeout:
            raise ResultsError(
                f"{self.path}: another run writes there. Wait until it has ended, or choose "
                "another `--out`"
            ) from None
        except OSError as error:
            raise cannot_write(self.path, error) from error

    def _start_results(self) -> None:
        """Write the cases that are taken over, and open the file for those to come."""
        results = self.path / RESULTS_FILE
        write_lines(results, self._taken_over)
        self._file = results.open("a", encoding="utf-8", newline="\n")
        for case in self._taken_over:
            self._earlier.pop((case.scene, case.label), None)

    def _prepare(self) -> None:
        try:
            if self.path.exists() and not self.path.is_dir():
                raise ResultsError(f"{self.path}: not a folder. Choose another `--out`")
            self.path.mkdir(parents=True, exist_ok=True)
            others = any(path.name != LOCK_FILE for path in self.path.iterdir())
            if others and not is_results_folder(self.path):
                raise ResultsError(
                    f"{self.path}: not empty and not a results folder of ours, so nothing in it "
                    "is replaced. Choose another `--out`, or empty it"
                )
            with tempfile.NamedTemporaryFile(dir=self.path):
                pass
        except OSError as error:
            raise cannot_write(self.path, error) from error

    def _put_by(self) -> None:
        """Write the earlier cases that aren't replaced, in one step."""
        if self._earlier:
            write_lines(self.path / EARLIER_FILE, self._earlier.values())
        else:
            (self.path / EARLIER_FILE).unlink(missing_ok=True)

    def _drop_motion(self) -> None:
        """Remove the files of motion that neither the results nor what is put by name."""
        put_by = {case.motion for case in self._earlier.values() if case.motion is not None}
        self._names = self._kept | put_by
        for path in (self.path / MOTION_FOLDER).iterdir():
            stray = f"{MOTION_FOLDER}/{path.name}" not in self._names
            if stray and path.suffix in (".npz", ".part"):
                path.unlink()

    def _write_environment(self) -> None:
        write_whole(self.path / ENVIRONMENT_FILE, json.dumps(self._environment, indent=2) + "\n")

    def _motion_name(self, record: CaseRecord) -> str:
        slug = re.sub(r"[^A-Za-z0-9.+-]+", "-", f"{record.scene}--{record.label}")
        name, copy = f"{MOTION_FOLDER}/{slug}.npz", 1
        # Labels that differ only in what the slug leaves out, or the same case of an earlier run,
        # whose motion must not be replaced before its line is.
        while name in self._names:
            copy += 1
            name = f"{MOTION_FOLDER}/{slug}-{copy}.npz"
        self._names.add(name)
        return name


def read_earlier(path: Path) -> list[CaseRecord]:
    """Return every case that a folder holds, those put by first; none where it has no results.

    Raises
    ------
    ResultsError
        Where they are of another schema version, or damaged elsewhere than in the last line of the
        results.
    """
    if not is_results_folder(path):
        return []
    load_environment(path)
    return [
        case
        for name in (EARLIER_FILE, RESULTS_FILE)
        if (path / name).exists()
        for case in load_cases(path / name)[0]
    ]
