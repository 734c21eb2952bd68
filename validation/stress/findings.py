"""What a stress run found, and the folder that keeps it: `stress.jsonl` and the worst cases."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Literal

import filelock
from pydantic import ConfigDict, TypeAdapter

from engine import Scene
from validation.results.files import ResultsError, cannot_write, parse_line, write_whole_lines
from validation.stress.trial import Suite

FORMAT: Final = "ghostball stress"
SCHEMA: Final = 2
FINDINGS_FILE: Final = "stress.jsonl"
WORST_FOLDER: Final = "worst"
LOCK_FILE: Final = ".lock"
PART_FILE: Final = FINDINGS_FILE + ".part"
"""What a kill leaves of a file that was being written."""

Outcome = Literal["survived", "broken", "not-representable", "unavailable", "failed"]
"""Whether every shot held; not all did; the engine can't be asked that; it can't run here; the
harness couldn't judge it, which says nothing of the engine."""

_AGAIN: Final = "Run `ghostball stress` again, into another `--out`"


Key = tuple[str, str, str]
"""Family, trial and label."""


@dataclass(frozen=True)
class Finding:
    """What became of one trial on one engine.

    Attributes
    ----------
    family, trial, label : str
        `label` is the engine with its settings.
    outcome : str
        See `Outcome`. A crash, or a trial that took too long, is "broken".
    faults : tuple of str
        What broke; for the last three outcomes, why.
    severity, shots, broken, values
        As in a `Verdict`.
    seconds : float
        Wall time; 0 where its process died or was ended.
    scene : mapping or None
        Definition of the shot that broke worst, or came nearest.
    code_hash : str
        Of the code that found it; "" where it can't be told.
    """

    family: str
    trial: str
    label: str
    outcome: Outcome
    faults: tuple[str, ...] = ()
    severity: float = 0.0
    shots: int = 0
    broken: int = 0
    values: dict[str, Any] = field(default_factory=dict)
    seconds: float = 0.0
    scene: dict[str, Any] | None = None
    code_hash: str = ""
    schema: int = SCHEMA

    __pydantic_config__ = ConfigDict(extra="forbid")

    @property
    def key(self) -> Key:
        """Family, trial and label."""
        return self.family, self.trial, self.label


@dataclass(frozen=True)
class StressRun:
    """The first line of the file: what was asked for, where and with what.

    Attributes
    ----------
    suite : "quick" or "full"
    families, labels : tuple of str
    environment : mapping
        As in `env.json` of a results folder.
    code_hash : str
        Of the code that ran; "" where it can't be told.
    missing : tuple of (str, str, str)
        Keys of what was asked for, by this run or an earlier one of the same code, and wasn't found
        yet when this line was written.
    """

    suite: Suite
    families: tuple[str, ...]
    labels: tuple[str, ...]
    environment: dict[str, Any]
    code_hash: str = ""
    missing: tuple[Key, ...] = ()
    format: str = FORMAT
    schema: int = SCHEMA

    __pydantic_config__ = ConfigDict(extra="forbid")


_RUN: Final = TypeAdapter(StressRun)
_FINDING: Final = TypeAdapter(Finding)


@dataclass(frozen=True)
class StressFolder:
    """What a folder holds.

    Attributes
    ----------
    path : Path
    run : StressRun
    findings : list of Finding
        In the order of the run: family by family, trial by trial, engine by engine.
    """

    path: Path
    run: StressRun
    findings: list[Finding]

    @property
    def missing(self) -> set[Key]:
        """What was asked for and not come to."""
        return set(self.run.missing) - {one.key for one in self.findings}

    @property
    def planned(self) -> int:
        """How many findings there are once every trial was come to."""
        return len(self.findings) + len(self.missing)

    @property
    def whole(self) -> bool:
        """Whether every trial was come to that this run or an earlier one was asked for."""
        return not self.missing

    @classmethod
    def load(cls, folder: str | Path) -> StressFolder:
        """Read a folder; a last line that a kill cut short is left out.

        Raises
        ------
        ResultsError
            Where there is none, or it is damaged or of another schema version.
        """
        path = Path(folder) / FINDINGS_FILE
        try:
            content, _, _ = path.read_bytes().rpartition(b"\n")  # before decoding: half a character
            lines = content.decode("utf-8").split("\n") if content else []
        except (FileNotFoundError, NotADirectoryError):
            raise ResultsError(
                f"{folder}: not a folder of `ghostball stress`: it has no {FINDINGS_FILE}"
            ) from None
        except (OSError, UnicodeDecodeError) as error:
            raise ResultsError(f"{path}: can't be read: {error}. {_AGAIN}") from error
        if not lines:
            raise ResultsError(f"{path}: is empty. {_AGAIN}")
        run: StressRun = parse_line(_RUN, lines[0], f"{path}:1", SCHEMA, _AGAIN)
        if run.format != FORMAT:
            raise ResultsError(f"{path}:1: not findings of ours. {_AGAIN}")
        findings: list[Finding] = [
            parse_line(_FINDING, line, f"{path}:{number}", SCHEMA, _AGAIN)
            for number, line in enumerate(lines[1:], 2)
        ]
        return cls(path.parent, run, findings)

    def of(self, family: str, label: str) -> list[Finding]:
        """Return what was found in a family on an engine."""
        return [one for one in self.findings if (one.family, one.label) == (family, label)]

    def worst(self, family: str, label: str) -> Finding | None:
        """Return the worst case with a shot that shows it; None where there is none."""
        found = self.of(family, label)
        broken = [one for one in found if one.outcome == "broken"]
        shown = [one for one in broken or found if one.scene is not None]
        return max(shown, key=lambda one: one.severity, default=None)


class StressWriter:
    """Writes findings as they come, a line each: a kill costs no more than the one in hand.

    Within `reserved`, which keeps other runs out of the folder.

    Parameters
    ----------
    path : Path
        Made where it isn't there.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = filelock.FileLock(path / LOCK_FILE, timeout=0)

    @contextmanager
    def reserved(self) -> Iterator[None]:
        """Keep other runs out of the folder while the block runs.

        Raises
        ------
        ResultsError
            Where another run is in it, it can't be written, or holds something else.
        """
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            strangers = [
                entry.name
                for entry in self.path.iterdir()
                if entry.name
                not in (FINDINGS_FILE, PART_FILE, WORST_FOLDER, LOCK_FILE, "stress.md", "figures")
            ]
            if strangers and not (self.path / FINDINGS_FILE).exists():
                raise ResultsError(
                    f"{self.path}: holds something else ({sorted(strangers)[0]}), which stays as "
                    "it is. Choose another `--out`, or empty it"
                )
            self._lock.acquire()
        except filelock.Timeout:
            raise ResultsError(
                f"{self.path}: another run is writing there. Wait for its end, or choose another "
                "`--out`"
            ) from None
        except OSError as error:
            raise cannot_write(self.path, error) from error
        try:
            yield
        finally:
            self._lock.release(force=True)  # its file stays: another run may wait for it

    def earlier(self, suite: Suite) -> StressFolder | None:
        """Return what earlier runs of a suite left in the folder; None where it is new.

        Raises
        ------
        ResultsError
            Where what is there can't be read: nothing is overwritten then.
        """
        if not (self.path / FINDINGS_FILE).exists():
            return None
        folder = StressFolder.load(self.path)
        if folder.run.suite != suite:
            raise ResultsError(
                f"{self.path}: holds what suite {folder.run.suite} found, which stays as it is. "
                "Choose another `--out`, or remove it"
            )
        return folder

    def begin(self, run: StressRun, kept: Iterable[Finding]) -> None:
        """Write the first line and what is taken over, whole or not at all."""
        self._rewrite(run, kept)

    def add(self, finding: Finding) -> None:
        """Append a finding."""
        try:
            with (self.path / FINDINGS_FILE).open("ab") as file:
                file.write(_line(finding) + b"\n")
        except OSError as error:
            raise cannot_write(self.path, error) from error

    def finish(self, run: StressRun, findings: Sequence[Finding]) -> None:
        """Write all again in the order of the run, and each family's worst case as a scene file."""
        self._rewrite(run, findings)
        save_worst(StressFolder(self.path, run, list(findings)))

    def _rewrite(self, run: StressRun, findings: Iterable[Finding]) -> None:
        lines = [_RUN.dump_json(run), *map(_line, findings)]
        try:
            write_whole_lines(self.path / FINDINGS_FILE, lines)
        except OSError as error:
            raise cannot_write(self.path, error) from error


def save_worst(folder: StressFolder) -> None:
    """Save the worst case of each family and engine as a scene file, in place of earlier ones."""
    place = folder.path / WORST_FOLDER
    try:
        place.mkdir(exist_ok=True)
        for old in place.glob("*.toml"):
            old.unlink()
        for family in folder.run.families:
            for label in folder.run.labels:
                worst = folder.worst(family, label)
                if worst is not None and worst.scene is not None:
                    Scene.model_validate(worst.scene).save(place / f"{stem_of(family, label)}.toml")
    except OSError as error:
        raise cannot_write(folder.path, error) from error


def stem_of(family: str, label: str) -> str:
    """Return the name of a worst case's file, without its ending."""
    safe = "".join(c if c.isalnum() or c in "-+=.," else "_" for c in label)
    return f"{family}-{safe}"


def _line(finding: Finding) -> bytes:
    return json.dumps(_plain(_FINDING.dump_python(finding, mode="json"))).encode()


def _plain(value: Any) -> Any:
    """Return `value` with null for every number that is not finite: JSON has none."""
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
