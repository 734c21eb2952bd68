"""Write files atomically, and describe invalid data and folders in messages."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from ghostball.model import GhostballError
from ghostball.model.text_files import temporary_path


class ResultsError(GhostballError):
    """A results folder that can't be read, written or replaced."""


def toml_of(text: str) -> dict[str, Any]:
    """Return the content of a text in TOML.

    Raises `ValueError` if it is invalid, or nested too deeply for Python's reader.
    """
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("lists or tables are nested too deeply") from None


def describe_validation_error(
    error: ValidationError, known: Sequence[str] = (), *, within: str = "", noun: str = "field"
) -> str:
    """Return the first problem with invalid data: the field, the rule and the value.

    For example "`rounds` must be a valid integer, got 'x'", for a message that names the place.

    `within`: table that holds the data, such as `tool.ghostball`.
    `noun`: the word for a field of the data.
    """
    # For a field of type int or float there are two problems; the one about float is described.
    problems = error.errors()
    first = next((one for one in problems if one["loc"][-1:] != ("int",)), problems[0])
    return describe_problem(first, known, within=within, noun=noun)


def describe_problem(
    problem: ErrorDetails, known: Sequence[str] = (), *, within: str = "", noun: str = "field"
) -> str:
    """Return one problem in words; `known` are the valid field names."""
    where, kind = ".".join(filter(None, (within, field_of(problem)))), problem["type"]
    if kind == "missing":
        return f"`{where}` is missing"
    if kind in ("extra_forbidden", "unexpected_keyword_argument"):
        close = get_close_matches(str(problem["loc"][-1]), known, n=1)
        hint = f"Did you mean `{close[0]}`?" if close else f"Known here: {', '.join(known)}"
        return f"`{where}` is not a known {noun}{f'. {hint}' if known else ''}"
    said = re.sub(r"^\w+ should", "must", problem["msg"].removeprefix("Value error, "))
    # For invalid JSON or a wrong table, the whole text would be shown.
    shown = repr(problem["input"])
    hidden = ", got " in said or len(shown) > _SHOWN or kind == "json_invalid"
    colon = "" if said.startswith("must ") else ":"
    return (f"`{where}`{colon} " if where else "") + said + ("" if hidden else f", got {shown}")


def field_of(problem: ErrorDetails) -> str:
    """Return the field of a problem, such as `criteria[2].metric`; "" if it isn't in a field."""
    parts = (one for one in problem["loc"] if one not in ("int", "float"))
    named = "".join(f"[{one}]" if isinstance(one, int) else f".{one}" for one in parts)
    return named.removeprefix(".")


_SHOWN = 80
"""Largest length of an invalid value that a message shows."""


def write_all_whole(contents: Mapping[Path, str | bytes]) -> None:
    """Write files that belong together: none is replaced before all of them are on the disk.

    Raises `OSError` if a file can't be written; no temporary file is left then.
    """
    encoded = {
        path: content.encode("utf-8") if isinstance(content, str) else content
        for path, content in contents.items()
    }
    parts = {path: temporary_path(path) for path in encoded}
    try:
        for path, data in encoded.items():
            parts[path].write_bytes(data)
        for path, part in parts.items():
            part.replace(path)
    except BaseException:  # also Ctrl-C
        for part in parts.values():
            with suppress(OSError):  # the first error is the one to report
                part.unlink(missing_ok=True)
        raise


def write_files(contents: Mapping[Path, str | bytes], remedy: str) -> None:
    """Write files that belong together, as `write_all_whole`, and create their folders.

    Raises `ResultsError` if they can't be written; its message ends with `remedy`.
    """
    try:
        for path in contents:
            path.parent.mkdir(parents=True, exist_ok=True)
        write_all_whole(contents)
    except OSError as error:
        where = error.filename or next(iter(contents)).parent
        raise ResultsError(f"{where}: can't be written: {_reason(error)}. {remedy}") from error


def cannot_write(path: Path, error: OSError) -> ResultsError:
    """Return the error for a folder that can't be written."""
    return ResultsError(
        f"{path}: can't write the results folder: {_reason(error)}. Choose another `--out`"
    )


def _reason(error: OSError) -> str:
    return error.strerror or type(error).__name__
