"""A stored measurement: a JSON file with the values, the machine, the date and the versions."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import BaseModel, Field, ValidationError

from ghostball.model import GhostballError
from ghostball.model.text_files import read_text
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.files import describe_validation_error, write_files


class MeasurementError(GhostballError):
    """A measurement that can't be made or read."""


def describe_machine() -> dict[str, Any]:
    """Return machine, versions, revision and date; no command line, which may hold paths."""
    return {k: v for k, v in describe_environment().items() if k != "command"}


def make_folder(folder: Path) -> None:
    """Create the folder of a measurement, so that a bad path is refused before the measurement."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise MeasurementError(
            f"`--out`: can't create the folder {folder}: {error.strerror}"
        ) from None


class Record(BaseModel, frozen=True, populate_by_name=True):
    """A stored part of a measurement."""


class Measurement(Record):
    """The fields of every stored measurement; its file is named after its kind."""

    schema_version: Literal[1] = Field(default=1, alias="schema")
    environment: dict[str, Any] = Field(default_factory=describe_machine)
    rounds: int = 1
    kind: str

    @property
    def where(self) -> str:
        """Processor and day, for the title of a figure."""
        return f"{self.environment['cpu']}, {str(self.environment['date'])[:10]}"

    def save(self, folder: Path) -> Path:
        """Write the measurement into a folder: a line for each field and each row of a table.

        Raises `ResultsError` if the file can't be written.
        """
        path = folder / f"{self.kind}.json"
        fields = self.model_dump(mode="json", by_alias=True)
        lines = (f'  "{name}": {_in_rows(value)}' for name, value in fields.items())
        write_files({path: "{\n" + ",\n".join(lines) + "\n}\n"}, "Choose another `--out`")
        return path

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a measurement of this kind."""
        try:
            return cls.model_validate_json(read_text(path))
        except (OSError, UnicodeDecodeError) as error:
            raise MeasurementError(f"{path}: can't read the measurement: {error}") from None
        except ValidationError as error:
            raise MeasurementError(
                f"{path}: {describe_validation_error(error)}. Measure again"
            ) from None


def _in_rows(value: Any) -> str:
    if isinstance(value, dict):
        rows = [f"{json.dumps(name)}: {json.dumps(row)}" for name, row in value.items()]
    elif isinstance(value, list):
        rows = [json.dumps(row) for row in value]
    else:
        return json.dumps(value)
    opened, closed = "{}" if isinstance(value, dict) else "[]"
    listed = ",".join(f"\n    {row}" for row in rows)
    return f"{opened}{listed}\n  {closed}" if rows else opened + closed
