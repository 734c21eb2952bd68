"""Stored measurements: a JSON file that says what was measured, where, when and with what."""

from __future__ import annotations

import json
import re
from abc import ABC, abstractmethod
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from benchmarks.running import BenchError
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.files import told, write_whole

SCHEMA: Final = 1
"""Version of the files; another one is refused."""

STORE = Path(__file__).resolve().parent / "results"
"""Committed measurements, one folder per machine."""

Stored = TypeVar("Stored", bound="Measurement")


class Measurement(BaseModel, ABC):
    """What every stored measurement has."""

    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)

    schema_version: Literal[1] = Field(default=SCHEMA, alias="schema")
    environment: dict[str, Any]
    rounds: int
    quick: bool = False
    interrupted: bool = False

    @property
    @abstractmethod
    def anything(self) -> bool:
        """Whether anything was measured before an interrupt."""


def measured_where() -> dict[str, Any]:
    """Return machine, versions, revision and date; no command line, for that may hold paths."""
    return {k: v for k, v in describe_environment().items() if k != "command"}


def machine_name(environment: dict[str, Any]) -> str:
    """Return the name of a machine's folder, such as "amd-epyc-2-cores"."""
    text = f"{environment['cpu']} {environment['cores']} cores".lower()
    return "-".join(re.findall(r"[a-z0-9]+", text))


def store_path(environment: dict[str, Any], kind: str) -> Path:
    """Return where this machine's committed measurement lies."""
    return STORE / machine_name(environment) / f"{kind}.json"


def stored_paths(kind: str) -> list[Path]:
    """Return the committed measurements of a kind, one per machine."""
    return sorted(STORE.glob(f"*/{kind}.json"))


def out_path(out: Path, kind: str) -> Path:
    """Return the file that `--out` means: a .json file, or KIND.json in a folder."""
    return out if out.suffix.lower() == ".json" else out / f"{kind}.json"


def check_target(path: Path, kind: str, option: str) -> None:
    """Refuse a file that can't be written, or that holds something else, before measuring.

    Folders that it lacks are made to find out, and removed again: the run may measure nothing.

    Raises
    ------
    BenchError
    """
    try:
        if path.is_dir():
            raise BenchError(f"{path}: `{option}` must be a file, but it is a folder. Name another")
        missing = [folder for folder in path.parents if not folder.exists()]
        part = path.with_name(path.name + ".part")  # what `write_whole` writes first
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            part.touch()
            part.unlink()
        finally:
            for folder in missing:
                with suppress(OSError):  # not made, or someone else's by now
                    folder.rmdir()
    except OSError as error:
        raise _cannot_write(path, option, error) from None
    if path.exists() and not _is_of_kind(path, kind):
        raise BenchError(
            f"{path}: holds no measurement of `{kind}`, so it is not replaced. Choose another "
            f"`{option}`"
        )


def save(measurement: Measurement, path: Path, option: str) -> None:
    """Write a measurement, whole or not at all.

    Raises
    ------
    BenchError
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, _text(measurement))
    except OSError as error:
        raise _cannot_write(path, option, error) from error


def load(path: Path, kind: type[Stored]) -> Stored:
    """Read a measurement of a kind.

    Raises
    ------
    BenchError
        Where it can't be read, or is another file.
    """
    try:
        return kind.model_validate_json(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise BenchError(f"{path}: can't read the measurement: {error}") from None
    except ValidationError as error:
        raise BenchError(f"{path}: {told(error)}. Measure again") from None


def committed(kind: type[Stored]) -> Stored | None:
    """Return the committed measurement of this machine, else of the first; None without any."""
    paths = stored_paths(str(kind.model_fields["kind"].default))
    name = machine_name(describe_environment())
    mine = [path for path in paths if path.parent.name == name]
    return load((mine or paths)[0], kind) if paths else None


def _text(measurement: Measurement) -> str:
    """Return a measurement as JSON: each field has its line, and each row of one that has rows."""
    fields: dict[str, Any] = json.loads(measurement.model_dump_json(by_alias=True))
    lines = (f'  "{name}": {_rows(value)}' for name, value in fields.items())
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _rows(value: Any) -> str:
    if isinstance(value, dict):
        rows = [f"{json.dumps(name)}: {json.dumps(row)}" for name, row in value.items()]
    elif isinstance(value, list):
        rows = [json.dumps(row) for row in value]
    else:
        return json.dumps(value)
    opened, closed = "{}" if isinstance(value, dict) else "[]"
    listed = ",".join(f"\n    {row}" for row in rows)
    return f"{opened}{listed}\n  {closed}" if rows else opened + closed


def _is_of_kind(path: Path, kind: str) -> bool:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(content, dict) and content.get("kind") == kind


def _cannot_write(path: Path, option: str, error: OSError) -> BenchError:
    reason = error.strerror or type(error).__name__
    return BenchError(
        f"{path}: can't write the file of `{option}`: {reason}. Choose another `{option}`"
    )
