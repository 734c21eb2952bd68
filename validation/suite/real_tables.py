"""How like a real table the engines of a run can be made to play; kept beside its results."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from ghostball.model import GhostballError
from ghostball.reference_adapters import EngineUnavailableError, make_engine
from ghostball.validation.measured.likeness import Likeness, likeness
from ghostball.validation.results.files import describe_validation_error, write_whole
from ghostball.validation.runs.playing import in_other_process, run_engine

FILE = "real-tables.json"
_LIST = TypeAdapter(list[Likeness])


def measure_likenesses(
    specs: Sequence[str], folder: Path, time_limit: float | None
) -> list[Likeness]:
    """Return how like a real table each engine that is here can be, and keep it in a folder."""
    found = []
    for spec in specs:
        try:
            engine = make_engine(spec)
        except EngineUnavailableError:
            continue
        with in_other_process(engine, time_limit) as player:
            found.append(likeness(spec, engine, partial(run_engine, player)))
    write_whole(folder / FILE, _LIST.dump_json(found, indent=1))
    return found


def forget_likenesses(folder: Path) -> None:
    """Remove what an earlier run kept, where this one measures none."""
    (folder / FILE).unlink(missing_ok=True)


def load_likenesses(folder: Path) -> list[Likeness]:
    """Return what a run kept in its folder; none where it kept nothing.

    Raises `GhostballError` where the file can't be read.
    """
    path = folder / FILE
    if not path.is_file():
        return []
    try:
        return _LIST.validate_json(path.read_bytes())
    except ValidationError as error:
        raise GhostballError(f"{path}: {describe_validation_error(error)}") from None
