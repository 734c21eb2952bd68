"""A results folder: what one run of the suite found, complete enough to report from alone.

    results.jsonl    one JSON object per case (scene x engine), one per line, in order of completion
    motion/*.npz     events and sampled motion of each case that ran
    env.json         machine, versions, revision, command line, and how the run ended

A line is written whole and flushed before the next case, and `env.json` is replaced in one step, so
a run that is interrupted or killed leaves a folder that reads back. Only the last line may be cut
short, by a kill in the midst of it: it is left out, and `ResultsFolder.cut_short` names it. Any
other damage is an error that names its place.
"""

from __future__ import annotations

import json
import re
import shutil
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, replace
from pathlib import Path
from typing import Any, Final, Literal, TextIO

import numpy as np
from pydantic import TypeAdapter, ValidationError

from engine import GhostballError
from validation.records import CLOSED_FORM, OUR_ENGINE, SCHEMA, CaseRecord, Check, Motion

__all__ = [
    "CLOSED_FORM",
    "OUR_ENGINE",
    "SCHEMA",
    "CaseRecord",
    "Check",
    "Motion",
    "ResultsError",
    "ResultsFolder",
    "ResultsWriter",
    "is_results_folder",
]

FORMAT: Final = "ghostball results"
RESULTS_FILE: Final = "results.jsonl"
ENVIRONMENT_FILE: Final = "env.json"
MOTION_FOLDER: Final = "motion"

RunState = Literal["running", "complete", "interrupted", "killed"]


class ResultsError(GhostballError):
    """A results folder that can't be read, written or replaced."""


_RECORD = TypeAdapter(CaseRecord)


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
        environment = _load_environment(folder)
        if environment is None:
            raise ResultsError(
                f"{folder}: not a results folder: it has no {ENVIRONMENT_FILE} of ours. Name the "
                "folder that `ghostball validate --out` wrote"
            )
        cases, cut_short = _load_cases(folder / RESULTS_FILE)
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
    folder with earlier results of ours is emptied of them by `begin`.

    Raises
    ------
    ResultsError
        Where the path is no folder, can't be made or written, or holds something else.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._file: TextIO | None = None
        self._names: set[str] = set()
        self._environment: dict[str, Any] = {}
        self._prepare()

    def begin(self, environment: Mapping[str, Any]) -> None:
        """Take over the folder: earlier results of ours go, `env.json` is written."""
        self._environment = {"format": FORMAT, "schema": SCHEMA, **environment, "state": "running"}
        try:
            # env.json comes last to go and first to come: the folder stays recognisably ours.
            (self.path / RESULTS_FILE).unlink(missing_ok=True)
            if (self.path / MOTION_FOLDER).exists():
                shutil.rmtree(self.path / MOTION_FOLDER)
            self._write_environment()
            (self.path / MOTION_FOLDER).mkdir()
            self._file = (self.path / RESULTS_FILE).open("w", encoding="utf-8", newline="\n")
        except OSError as error:
            raise _cannot_write(self.path, error) from error

    def write(self, record: CaseRecord, motion: Motion | None) -> CaseRecord:
        """Append a case; return it with the name of its motion file.

        `begin` must have been called.
        """
        assert self._file is not None, "begin() comes first"
        if motion is not None:
            record = replace(record, motion=self._motion_name(record))
        line = _RECORD.dump_json(record).decode() + "\n"
        try:
            if motion is not None and record.motion is not None:
                _save_motion(self.path / record.motion, motion)
            self._file.write(line)
            self._file.flush()
        except OSError as error:
            raise _cannot_write(self.path, error) from error
        return record

    def finish(self, state: RunState) -> None:
        """Close the folder and note in `env.json` how the run ended."""
        if self._file is None:
            return
        self._file.close()
        self._file = None
        self._environment["state"] = state
        try:
            self._write_environment()
        except OSError as error:
            raise _cannot_write(self.path, error) from error

    def _prepare(self) -> None:
        try:
            if self.path.exists() and not self.path.is_dir():
                raise ResultsError(f"{self.path}: not a folder. Choose another `--out`")
            self.path.mkdir(parents=True, exist_ok=True)
            if any(self.path.iterdir()) and not is_results_folder(self.path):
                raise ResultsError(
                    f"{self.path}: not empty and not a results folder of ours, so nothing in it "
                    "is replaced. Choose another `--out`, or empty it"
                )
            with tempfile.NamedTemporaryFile(dir=self.path):
                pass
        except OSError as error:
            raise _cannot_write(self.path, error) from error

    def _write_environment(self) -> None:
        part = self.path / (ENVIRONMENT_FILE + ".part")
        part.write_text(json.dumps(self._environment, indent=2) + "\n", encoding="utf-8")
        part.replace(self.path / ENVIRONMENT_FILE)

    def _motion_name(self, record: CaseRecord) -> str:
        slug = re.sub(r"[^A-Za-z0-9.+-]+", "-", f"{record.scene}--{record.label}")
        name, copy = f"{MOTION_FOLDER}/{slug}.npz", 1
        while name in self._names:  # labels that differ only in what the slug leaves out
            copy += 1
            name = f"{MOTION_FOLDER}/{slug}-{copy}.npz"
        self._names.add(name)
        return name


def is_results_folder(path: Path) -> bool:
    """Whether `path` holds results of ours, of any schema version."""
    try:
        environment = json.loads((path / ENVIRONMENT_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(environment, dict) and environment.get("format") == FORMAT


def _load_environment(folder: Path) -> dict[str, Any] | None:
    path = folder / ENVIRONMENT_FILE
    if not is_results_folder(folder):
        if _is_damaged(path):
            raise ResultsError(
                f"{path}: is cut short: it is no whole JSON. Run the suite again in another folder"
            )
        return None
    environment: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    _check_schema(environment.get("schema"), str(path))
    return environment


def _is_damaged(path: Path) -> bool:
    """Whether there is a file that holds no whole JSON."""
    try:
        json.loads(path.read_text(encoding="utf-8"))
    except OSError:
        return False
    except ValueError:
        return True
    return False


def _load_cases(path: Path) -> tuple[list[CaseRecord], str]:
    """Return the whole lines as cases, and the place of a last line that is cut short, or ""."""
    try:
        # Cut before it is decoded: a kill may leave half a character. Also not splitlines(), for
        # a reason may hold U+2028.
        whole, newline, rest = path.read_bytes().rpartition(b"\n")
        lines = whole.decode("utf-8").split("\n") if newline else []
    except FileNotFoundError:
        raise ResultsError(f"{path}: missing. Run the suite again") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ResultsError(f"{path}: can't read the results: {error}") from error
    cases = [_load_case(line, f"{path}:{number}") for number, line in enumerate(lines, start=1)]
    return cases, f"{path}:{len(lines) + 1}" if rest else ""


def _load_case(line: str, place: str) -> CaseRecord:
    try:
        data = json.loads(line)
        if not isinstance(data, dict):
            raise ResultsError(f"{place}: not a case: a JSON object was expected")
        _check_schema(data.get("schema"), place)
        return _RECORD.validate_python(data)
    except json.JSONDecodeError as error:
        raise ResultsError(
            f"{place}: not valid JSON: {error.msg} (column {error.colno}). Run the suite again"
        ) from None
    except ValidationError as error:
        first = error.errors()[0]
        name = ".".join(map(str, first["loc"]))
        raise ResultsError(f"{place}: `{name}`: {first['msg']}. Run the suite again") from None


def _check_schema(schema: object, place: str) -> None:
    if schema != SCHEMA:
        raise ResultsError(
            f"{place}: `schema` must be {SCHEMA}, got {schema!r}: another version of ghostball "
            "wrote it. Read it with that version, or run the suite again"
        )


def _save_motion(path: Path, motion: Motion) -> None:
    part = path.with_suffix(".part")
    with part.open("wb") as file:
        parts = {part.name: getattr(motion, part.name) for part in fields(Motion)}
        np.savez_compressed(file, **{name: p for name, p in parts.items() if p is not None})
    part.replace(path)


def _cannot_write(path: Path, error: OSError) -> ResultsError:
    reason = error.strerror or type(error).__name__
    return ResultsError(f"{path}: can't write the results folder: {reason}. Choose another `--out`")
