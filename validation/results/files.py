"""The files of a results folder: written whole, read back, refused with place and reason."""

from __future__ import annotations

import hashlib
import io
import json
import re
from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import fields
from pathlib import Path
from typing import Any, Final

import numpy as np
from pydantic import TypeAdapter, ValidationError

from engine import GhostballError
from validation.results.records import SCHEMA, CaseRecord, Motion

FORMAT: Final = "ghostball results"
RESULTS_FILE: Final = "results.jsonl"
EARLIER_FILE: Final = "earlier.jsonl"
ENVIRONMENT_FILE: Final = "env.json"
MOTION_FOLDER: Final = "motion"
LOCK_FILE: Final = ".lock"
REGRESSION_FILE: Final = "regression.json"


class ResultsError(GhostballError):
    """A results folder that can't be read, written or replaced."""


_RECORD = TypeAdapter(CaseRecord)


def is_results_folder(path: Path) -> bool:
    """Whether `path` holds results of ours, of any schema version."""
    try:
        environment = json.loads((path / ENVIRONMENT_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(environment, dict) and environment.get("format") == FORMAT


def load_environment(folder: Path) -> dict[str, Any] | None:
    """Return the content of `env.json`, or None where there is none of ours.

    Raises
    ------
    ResultsError
        Where it is cut short, or of another schema version.
    """
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


def load_cases(path: Path) -> tuple[list[CaseRecord], str]:
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
    record: CaseRecord = parse_line(_RECORD, line, place, SCHEMA, "Run the suite again")
    return record


def parse_line(
    adapter: TypeAdapter[Any],
    line: str,
    place: str,
    schema: int,
    again: str,
    older: Collection[int] = (),
) -> Any:
    """Read what a line of JSON holds.

    Parameters
    ----------
    adapter : TypeAdapter
    line, place : str
        And where it is, for the message.
    schema : int
        Its version.
    again : str
        What to do where it can't be read: a sentence without its full stop.
    older : collection of int
        Versions that lack what has a default now, and are read as well, as the present one.

    Raises
    ------
    ResultsError
        Where it is no JSON object, of another version, or not what was expected.
    """
    try:
        data = json.loads(line)
        if not isinstance(data, dict):
            raise ResultsError(f"{place}: a JSON object was expected. {again}")
        if data.get("schema") in older:
            data["schema"] = schema
        _check_schema(data.get("schema"), place, schema, again)
        return adapter.validate_python(data)
    except json.JSONDecodeError as error:
        raise ResultsError(
            f"{place}: not valid JSON: {error.msg} (column {error.colno}). {again}"
        ) from None
    except ValidationError as error:
        raise ResultsError(f"{place}: {told(error)}. {again}") from None


def _check_schema(
    found: object, place: str, schema: int = SCHEMA, again: str = "Run the suite again"
) -> None:
    if found != schema:
        raise ResultsError(
            f"{place}: `schema` must be {schema}, got {found!r}: another version of ghostball "
            f"wrote it. {again}"
        )


def told(error: ValidationError) -> str:
    """Return what is wrong with data that a model refuses: the first field, its rule, its value.

    Such as "`rounds` must be a valid integer, got 'x'", for a message that says where it is.
    """
    # A number may be an integer or a float: what is neither is told by the rule of the latter.
    errors = error.errors()
    first = next((one for one in errors if one["loc"][-1:] != ("int",)), errors[0])
    where = ".".join(str(part) for part in first["loc"] if part not in ("int", "float"))
    if first["type"] == "missing":
        return f"`{where}` is missing"
    if first["type"] in ("extra_forbidden", "unexpected_keyword_argument"):
        return f"`{where}` is no field of this file"
    said = re.sub(r"^\w+ should", "must", first["msg"])
    # Of what is no JSON the whole text would be shown, and of a table all of it.
    shown = repr(first["input"])
    hidden = ", got " in said or len(shown) > _SHOWN or first["type"] == "json_invalid"
    colon = "" if said.startswith("must ") else ":"
    return (f"`{where}`{colon} " if where else "") + said + ("" if hidden else f", got {shown}")


_SHOWN = 80
"""Characters of a refused value that a message has room for."""


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file, text as UTF-8, whole or not at all: an error leaves what was there.

    Raises
    ------
    OSError
        Where it can't be written; nothing is left beside it.
    """
    write_all_whole({path: content})


def write_all_whole(contents: Mapping[Path, str | bytes]) -> None:
    """Write files that belong together: none is replaced until all are on the disk.

    Raises
    ------
    OSError
        As of `write_whole`.
    """
    encoded = {
        path: content.encode("utf-8") if isinstance(content, str) else content
        for path, content in contents.items()
    }
    parts = {path: path.with_name(path.name + ".part") for path in encoded}
    try:
        for path, data in encoded.items():
            parts[path].write_bytes(data)
        for path, part in parts.items():
            part.replace(path)
    except BaseException:  # also Ctrl-C
        for part in parts.values():
            with suppress(OSError):  # the first error is the one to tell
                part.unlink(missing_ok=True)
        raise


def read_whole_lines(path: Path, again: str) -> list[str] | None:
    """Read the lines of a file that is written whole; None where there is none.

    Raises
    ------
    ResultsError
        Where it can't be read, or its last line is cut short.
    """
    try:
        text = path.read_bytes().decode("utf-8")
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, UnicodeDecodeError) as error:
        raise ResultsError(f"{path}: can't be read: {error}. {again}") from error
    lines = text.split("\n")  # not splitlines(): a reason may hold U+2028
    if lines.pop():
        raise ResultsError(f"{path}:{len(lines) + 1}: the line is cut short. {again}")
    return lines


def write_whole_lines(path: Path, lines: Iterable[bytes]) -> None:
    """Write lines, without their ends, whole or not at all."""
    write_whole(path, b"".join(line + b"\n" for line in lines))


def line_of(record: CaseRecord) -> str:
    """Return a case as one line of JSON, with its end."""
    return _RECORD.dump_json(record).decode() + "\n"


def write_lines(path: Path, records: Iterable[CaseRecord]) -> None:
    """Write cases, one per line, whole or not at all."""
    write_whole_lines(path, map(_RECORD.dump_json, records))


def save_motion(path: Path, motion: Motion) -> str:
    """Write a file of motion, whole or not at all, and return its SHA-256."""
    parts = {part.name: getattr(motion, part.name) for part in fields(Motion)}
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **{name: p for name, p in parts.items() if p is not None})
    content = buffer.getvalue()
    write_whole(path, content)
    return hashlib.sha256(content).hexdigest()


def cannot_write(path: Path, error: OSError) -> ResultsError:
    """Return the error that says why a folder can't be written."""
    reason = error.strerror or type(error).__name__
    return ResultsError(f"{path}: can't write the results folder: {reason}. Choose another `--out`")


def hash_of_file(path: Path) -> str:
    """Return the SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
